"""Draws the site's first screen into ``docs/images/site.png``; run ``./dev site`` first.

``python -m tests.studio.picture``
"""

from __future__ import annotations

from tests.studio.browser import chromium, served
from tools import site

PICTURE = site.TREE / "docs/images/site.png"
SETTLED_MS = 3000  # the emulated knob has started


def main() -> None:
    """Open the site as a visitor does, and take its picture."""
    with served(site.HTML) as address, chromium() as browser:
        page = browser.new_page(viewport={"width": 1440, "height": 1000})
        page.goto(address)
        page.frame_locator("iframe").locator("#arm:enabled").wait_for()
        page.wait_for_timeout(SETTLED_MS)
        page.screenshot(path=PICTURE)


if __name__ == "__main__":
    main()
