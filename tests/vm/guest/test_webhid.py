"""The studio's page in the distribution's browser, which drives a virtual knob over WebHID.

The browser asks the real udev which devices there are, and the kernel's hidraw for the reports; a
policy stands for the user who chooses the knob in its dialogue.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.studio.browser import be_patient, chromium, number, opened, served, settled, state_is
from tests.vm.guest.udev import run
from tests.vm.guest.virtual_bus import VirtualBus
from tools import usb_ids

POLICY = Path("/etc/chromium/policies/managed/torsio.json")
# Of the guest's time, which the host's load does not change; an idle host needs ten times as long.
SLOW_MS = 120_000
STIFFNESS, WALL_RAD = 1.4, 0.3  # the page's first scene

# On an emulated processor a browser takes minutes: with ./dev test games.
pytestmark = [pytest.mark.usefixtures("udev"), pytest.mark.games]


@contextmanager
def _page(*, allowed: bool) -> Iterator[Page]:
    """Open the page; `allowed`: the user has chosen every knob for it."""
    expect.set_options(timeout=SLOW_MS)
    vendor, product = (int(number, 16) for number in usb_ids.ids())
    with served() as address:
        device = {"vendor_id": vendor, "product_id": product}
        choices = [{"devices": [device], "urls": [address]}] if allowed else []
        POLICY.parent.mkdir(parents=True, exist_ok=True)
        POLICY.write_text(json.dumps({"WebHidAllowDevicesForUrls": choices}))
        with chromium() as browser, opened(browser, address) as page:
            page.set_default_timeout(SLOW_MS)
            yield page


@pytest.mark.pulls_cable
def test_page_feels_a_wall_of_a_knob_over_webhid_until_the_plug_is_pulled(bus: VirtualBus) -> None:
    knob = bus.plug()
    run("udevadm", "settle")
    with _page(allowed=True) as page:
        page.select_option("#connection", "webhid")
        page.click("#connect")
        expect(page.locator("#who")).to_contain_text("serial number KNOB-1")
        state_is(page, "disarmed")
        be_patient(page)
        page.click("#arm")
        state_is(page, "armed")
        knob.say("angle 0.4")
        page.wait_for_function("Number(document.getElementById('angle_rad').value) > 0.35")
        angle = settled(page, "angle_rad", within=1e-3, timeout_ms=SLOW_MS)
        step_nm = STIFFNESS * 2 * 2 * 3.15 / 8192
        wanted = -STIFFNESS * (angle - WALL_RAD)
        assert number(page, "desired_torque_nm") == pytest.approx(wanted, abs=step_nm + 2e-3)
        page.keyboard.press("Escape")
        state_is(page, "disarmed")
        knob.unplug()
        expect(page.locator("#message")).to_contain_text("plug it in again")
        state_is(page, "disconnected")
