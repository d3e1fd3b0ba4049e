"""The lives of a few emulated knobs come to one number in the builds that the tests have.

``./dev determinism`` does it with more compilers, processors and knobs.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.determinism import determinism
from tests.determinism.determinism import Run

TREE = Path(__file__).parent.parent


def program(preset: str) -> Path:
    return TREE / "build" / preset / "tests/determinism/torsio_life"


def test_lives_come_to_one_number_however_they_are_made_run_cut_and_stopped() -> None:
    size = ("--seconds", "2", "--knobs", "4")
    optimised = program("release")
    runs = [Run("asan-ubsan", (str(program("asan-ubsan")), *size))]
    runs += determinism.runs_of(optimised, seconds=2, knobs=4, threads=(1, 3, 32))
    with ThreadPoolExecutor() as pool:  # some only stand still
        numbers = dict(zip([run.name for run in runs], pool.map(Run.number, runs), strict=True))
    assert len(set(numbers.values())) == 1, numbers


def test_other_lives_come_to_another_number() -> None:
    optimised = str(program("release"))
    numbers = {
        Run("", (optimised, "--seconds", seconds, "--knobs", knobs)).number()
        for seconds, knobs in (("1", "1"), ("1", "2"), ("2", "1"))
    }
    assert len(numbers) == 3
