"""A board for each test, and each test for every board."""

from __future__ import annotations

import itertools
import os
from collections import defaultdict
from collections.abc import Iterator

import pytest

from tests.board import pico as bench
from tests.board.pico import MODELS, EmulatedPico, enumerated
from tools.dev.building import EVERY_BOARD_VARIABLE
from tools.dev.groups import BOARDS_VARIABLE, UNGUARDED_VARIABLE

BOARDS = os.environ.get(BOARDS_VARIABLE, "").split() or list(MODELS)


def pytest_configure(config: pytest.Config) -> None:
    for marker in (
        "one_board: many cases of code that all boards share",
        "slow_chip: work that only an RP2040 has too little time for",
        "unguarded: needs firmware whose guards can be switched off, and runs with it alone",
        "boards_in_turn: takes long; each board has a share of the cases, unless all are asked for",
    ):
        config.addinivalue_line("markers", marker)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave to the RP2040, which is the quicker one here, what would only take time on others."""
    marks = ("one_board", "slow_chip") if "pico" in BOARDS else ("slow_chip",)
    left = [
        item
        for item in items
        if any(item.get_closest_marker(name) for name in marks)
        and "pico2" in item.name.split("[")[-1]
    ]
    if UNGUARDED_VARIABLE not in os.environ:
        left += [item for item in items if item.get_closest_marker("unguarded")]
    if EVERY_BOARD_VARIABLE not in os.environ:
        left += _out_of_turn([item for item in items if item not in left])
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item in items if item not in left]


def _out_of_turn(items: list[pytest.Item]) -> list[pytest.Item]:
    """Give the cases that are another board's share, of those that `boards_in_turn` marks."""
    boards: dict[tuple[str, str], dict[str, pytest.Item]] = defaultdict(dict)
    for item in items:
        if item.get_closest_marker("boards_in_turn") and isinstance(item, pytest.Function):
            parameters = dict(item.callspec.params)
            board = str(parameters.pop("_model"))
            boards[item.originalname, str(parameters)][board] = item
    turns: dict[str, Iterator[int]] = defaultdict(itertools.count)
    left: list[pytest.Item] = []
    for (test, _), cases in boards.items():
        turn = list(MODELS)[next(turns[test]) % len(MODELS)]
        left += [item for board, item in cases.items() if board != turn]
    return left


@pytest.fixture(scope="module", autouse=True, params=list(dict.fromkeys(BOARDS)))
def _model(request: pytest.FixtureRequest) -> None:
    """Run every test on every board that takes part."""
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
