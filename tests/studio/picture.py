"""Draws ``docs/images/site.png`` and ``docs/images/studio.png``; run ``./dev site`` first.

``python -m tests.studio.picture``
"""

from __future__ import annotations

from tests.studio.browser import armed, chromium, drag_to, news, opened, served
from tools import site

IMAGES = site.TREE / "docs/images"
SETTLED_MS = 3000  # the emulated knob has started
PRESSED_RAD, STEPS = 0.45, 60


def main() -> None:
    """Open site and page as a visitor does, and take their pictures."""
    with chromium() as browser:
        with served(site.HTML) as address:
            page = browser.new_page(viewport={"width": 1440, "height": 1000})
            page.goto(address)
            page.frame_locator("iframe").locator("#arm:enabled").wait_for()
            page.wait_for_timeout(SETTLED_MS)
            page.screenshot(path=IMAGES / "site.png")
        with (
            served() as address,
            opened(browser, address, viewport={"width": 1280, "height": 800}) as page,
        ):
            armed(page)
            drag_to(page, PRESSED_RAD, STEPS)
            news(page, 1000)
            page.screenshot(path=IMAGES / "studio.png")


if __name__ == "__main__":
    main()
