"""A board for each test, and each test for every board."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.board import pico as bench
from tests.board.pico import MODELS, EmulatedPico, enumerated


def pytest_configure(config: pytest.Config) -> None:
    for marker in (
        "one_board: many cases of what all boards have in common",
        "slow_chip: what only an RP2040 has too little time for",
    ):
        config.addinivalue_line("markers", marker)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave to the RP2040, which is the quicker one here, what would only take time on others."""
    left = [
        item
        for item in items
        if any(item.get_closest_marker(name) for name in ("one_board", "slow_chip"))
        and "pico2" in item.name.split("[")[-1]
    ]
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item in items if item not in left]


@pytest.fixture(scope="module", autouse=True, params=MODELS)
def _model(request: pytest.FixtureRequest) -> None:
    """Run every test on every board."""
    bench.choose(request.param)


def _boot() -> Iterator[EmulatedPico]:
    if not bench.chosen.image.exists() or not bench.ROM.exists() or not bench.FAST.exists():
        pytest.fail("the firmware is not built; run ./dev test", pytrace=False)
    with enumerated() as board:
        yield board


@pytest.fixture
def pico() -> Iterator[EmulatedPico]:
    """Give a board that has booted, disarmed, and knows its host."""
    yield from _boot()


@pytest.fixture(scope="module")
def lasting_pico(_model: None) -> Iterator[EmulatedPico]:
    """Give the same board to many tests, for what must change nothing: booting takes the time."""
    yield from _boot()
