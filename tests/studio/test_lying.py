"""A device, a bridge or a file that lies to the page: it says so in a sentence, and goes on."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, WebSocketRoute, expect

from tests.studio.browser import opened, served, state_is

GET, GOT = 2, 4
HELLO = '{"title": "liar", "read_only": false}'
CABLE = "try another cable and another port, without a hub"


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Give a page that looks for a bridge, which the tests play."""
    with served() as address:
        yield f"{address}?token=x"


def _bridge(page: Page, hello: str | bytes, **answers: bytes) -> list[bytes]:
    """Answer a page's GETs with the same bytes; gives what the page has sent."""
    sent: list[bytes] = []

    def answer(route: WebSocketRoute, message: str | bytes) -> None:
        assert isinstance(message, bytes)
        sent.append(message)
        if message[0] == GET:
            route.send(answers["get"])

    def connect(route: WebSocketRoute) -> None:
        route.on_message(lambda message: answer(route, message))
        route.send(hello)

    page.route_web_socket("**/knob?*", connect)
    return sent


@pytest.mark.parametrize(
    ("hello", "get", "said"),
    [
        ("no JSON", b"", "does not speak as `torsio studio` does"),
        ('{"title": 5}', b"", "does not speak as `torsio studio` does"),
        (b"\x00\xff", b"", "does not speak as `torsio studio` does"),
        (HELLO, b"", "does not speak as `torsio studio` does"),
        (HELLO, b"\xee" * 9, "does not speak as `torsio studio` does"),
        (HELLO, bytes([GOT]) + b"\x01\x02", "identity report has 2 bytes in place of 64"),
        (HELLO, bytes([GOT]) + bytes(64), "speaks another protocol (version 0, fingerprint 0x0)"),
    ],
    ids=["no JSON", "no title", "bytes", "empty", "unknown kind", "short", "other version"],
)
def test_bridge_that_lies_is_told_from_one_and_the_scene_stays(
    browser: Browser, address: str, hello: str | bytes, get: bytes, said: str
) -> None:
    with opened(browser, "about:blank") as page:
        sent = _bridge(page, hello, get=get)
        page.goto(address)
        expect(page.locator("#message")).to_contain_text(said)
        expect(page.locator("#who")).to_have_text("no knob")
        expect(page.locator("#arm")).to_be_disabled()
        # Nothing was asked of it but who it is, and the user's work is there.
        assert {message[0] for message in sent} <= {GET}
        expect(page.locator("#python")).to_contain_text("torsio.Wall(")
        # Another way is open still.
        page.select_option("#connection", "wasm")
        page.click("#connect")
        state_is(page, "disarmed")


def test_device_that_sends_garbage_among_samples_is_shown_and_complained_of(
    browser: Browser, site: str
) -> None:
    with opened(browser, "about:blank") as page:
        # The worker's messages, with damage among the reports.
        page.add_init_script("""
          const real = Worker;
          window.Worker = class extends real {
            set onmessage(take) {
              super.onmessage = (event) => {
                if (event.data.kind === "time" && window.lying && event.data.reports.length) {
                  const lies = new Uint8Array(event.data.reports.length + 128);
                  lies.set(event.data.reports);
                  lies.fill(0xff, event.data.reports.length);
                  take({ data: { ...event.data, reports: lies } });
                } else take(event);
              };
            }
          };
        """)
        page.goto(site)
        state_is(page, "disarmed")
        page.evaluate("window.lying = true")
        expect(page.locator("#message")).to_contain_text("damaged reports came from the knob")
        expect(page.locator("#message")).to_contain_text(CABLE)
        shown = page.evaluate("window.studio.samples()")
        page.wait_for_function(f"window.studio.samples() > {shown} + 100")
        page.evaluate("window.lying = false")
        expect(page.locator("#message")).to_be_hidden()
        expect(page.locator("#link")).to_contain_text("0 lost")


def test_module_that_is_none_is_named(browser: Browser, site: str) -> None:
    page = browser.new_page()
    page.route("**/knob.wasm", lambda route: route.fulfill(body=b"<html>not found</html>"))
    page.goto(site)
    expect(page.locator("#message")).to_contain_text("knob.wasm is damaged; build it again")
    page.close()
