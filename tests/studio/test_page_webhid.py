"""The page where the system keeps a knob from the browser, and where it may have two of them.

The browser's WebHID is a stand-in here; ``tests/vm/guest/test_webhid.py`` has the real one.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

from playwright.sync_api import Browser, Page, Route, expect

from tests.studio.browser import state_is

TREE = Path(__file__).parents[2]


def _udev_line() -> str:
    rules = (TREE / "sdk/60-torsio.rules").read_text(encoding="utf-8")
    return next(line for line in rules.splitlines() if '"hidraw"' in line)


def _usb_ids() -> dict[str, int]:
    found = re.findall(r'ATTRS{id(?:Vendor|Product)}=="([0-9a-f]{4})"', _udev_line())
    return dict(zip(("VENDOR_ID", "PRODUCT_ID"), (int(id, 16) for id in found), strict=True))


# A browser whose knob the system keeps from it, as Chromium has it.
REFUSED = """
const { VENDOR_ID: vendorId, PRODUCT_ID: productId } = IDS;
const refusal = new DOMException("Failed to open the device.", "NotAllowedError");
const open = () => Promise.reject(refusal);
const knob = { vendorId, productId, collections: [{ usagePage: 0xff00 }], opened: false, open };
Object.defineProperty(navigator, "hid", { value: { getDevices: async () => [knob] } });
"""


def _connected_over_webhid(browser: Browser, site: str, knobs: str, *, early: bool = False) -> Page:
    """Open the page in a browser with these knobs, and press connect.

    `early`: before the emulated knob, with which the page begins, is there.
    """
    page = browser.new_page()
    page.add_init_script(knobs.replace("IDS", json.dumps(_usb_ids())))
    held: list[Route] = []
    if early:
        page.route("**/knob.wasm", lambda route: held.append(route))
    with page.expect_request("**/knob.wasm"):
        page.goto(site)
    if not early:
        state_is(page, "disarmed")
    page.select_option("#connection", "webhid")
    page.click("#connect")
    for route in held:
        route.continue_()
    return page


def test_connect_is_heard_while_another_knob_is_coming(browser: Browser, site: str) -> None:
    page = _connected_over_webhid(browser, site, REFUSED, early=True)
    expect(page.locator("#message")).to_contain_text("Failed to open the device")
    page.close()


def test_page_that_may_not_open_the_knob_shows_the_udev_line(browser: Browser, site: str) -> None:
    page = _connected_over_webhid(browser, site, REFUSED)
    expect(page.locator("#message")).to_contain_text(_udev_line())
    expect(page.locator("#message")).to_contain_text("Failed to open the device")
    page.close()


# A browser with knobs that it was allowed; the dialogue offers the second.
TWO_KNOBS = """
const { VENDOR_ID: vendorId, PRODUCT_ID: productId } = IDS;
const made = (productName) => ({
  vendorId, productId, productName, collections: [{ usagePage: 0xff00 }], opened: false,
  open: () => Promise.reject(new Error(`opened ${productName}`)),
});
const knobs = [made("first"), made("second")];
window.allowed = knobs;
const hid = { getDevices: async () => allowed, requestDevice: async () => [knobs[1]] };
Object.defineProperty(navigator, "hid", { value: hid });
"""


def test_one_of_two_allowed_knobs_is_chosen_in_the_dialogue(browser: Browser, site: str) -> None:
    page = _connected_over_webhid(browser, site, TWO_KNOBS)
    expect(page.locator("#message")).to_contain_text("opened second")
    # Where only one can be meant nobody is asked.
    page.evaluate("allowed.pop()")
    page.click("#connect")
    expect(page.locator("#message")).to_contain_text("opened first")
    page.close()
