"""A board for each test."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.board.pico import IMAGE, ROM, EmulatedPico, enumerated


def _boot() -> Iterator[EmulatedPico]:
    if not IMAGE.exists() or not ROM.exists():
        pytest.fail("the firmware is not built; run ./dev test", pytrace=False)
    with enumerated() as board:
        yield board


@pytest.fixture
def pico() -> Iterator[EmulatedPico]:
    """Give a board that has booted, disarmed, and knows its host."""
    yield from _boot()


@pytest.fixture(scope="module")
def lasting_pico() -> Iterator[EmulatedPico]:
    """Give the same board to many tests, for what must change nothing: booting takes the time."""
    yield from _boot()
