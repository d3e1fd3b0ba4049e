"""A device, a bridge or a file that lies to the page: it says so in a sentence, and goes on."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, WebSocketRoute, expect

from tests.studio.browser import opened, served, state_is

GET, GOT = 2, 4
HELLO = '{"title": "liar", "read_only": false}'


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
        (HELLO, bytes([GOT]) + bytes(64), "speaks another protocol (version 0, fingerprint 0x0)"),
    ],
    ids=["no JSON", "no title", "bytes", "empty", "unknown kind", "other version"],
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


def test_module_that_is_none_is_named(browser: Browser, site: str) -> None:
    page = browser.new_page()
    page.route("**/knob.wasm", lambda route: route.fulfill(body=b"<html>not found</html>"))
    page.goto(site)
    expect(page.locator("#message")).to_contain_text("knob.wasm is damaged; build it again")
    page.close()
