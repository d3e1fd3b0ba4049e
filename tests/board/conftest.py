"""A board for each test."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.board.pico import IMAGE, ROM, EmulatedPico, enumerated


@pytest.fixture
def pico() -> Iterator[EmulatedPico]:
    """Give a board that has booted, disarmed, and knows its host."""
    if not IMAGE.exists() or not ROM.exists():
        pytest.fail("the firmware is not built; run ./dev test", pytrace=False)
    with enumerated() as board:
        yield board
