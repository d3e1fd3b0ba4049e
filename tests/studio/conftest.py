"""One browser for all tests of a module, and the page served to it."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, expect

from tests.studio.browser import PAGE, chromium, served
from tools.kernels import GAMES_VARIABLE

# With ./dev test games.
collect_ignore = [] if GAMES_VARIABLE in os.environ else ["test_firefox.py"]

# Longer than any loaded machine takes: nothing here is about time.
expect.set_options(timeout=60_000)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Give a browser."""
    if not (PAGE / "knob.wasm").exists():
        pytest.fail("the page is not built; run ./dev test", pytrace=False)
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def site() -> Iterator[str]:
    """Give the address of the page on a host that only has files."""
    with served() as address:
        yield address
