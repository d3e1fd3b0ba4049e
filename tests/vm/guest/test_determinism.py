"""The lives of emulated knobs come to the host's number in a guest too, stopped or not."""

from __future__ import annotations

from tests.determinism import determinism
from tests.vm.guests import LIFE, LIFE_NUMBER, LIFE_SIZE


def test_lives_come_to_the_same_number_as_on_the_host() -> None:
    runs = determinism.runs_of(LIFE, *LIFE_SIZE, threads=(1, 3))
    numbers = {run.name: run.number() for run in runs}
    assert set(numbers.values()) == {LIFE_NUMBER.read_text()}, numbers
