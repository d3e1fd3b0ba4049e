"""The paper's scenarios with each board's binary feel as with the emulated device."""

from __future__ import annotations

import itertools

import pytest

from tests.board import felt, pico
from tests.studies import bench_binary as binary
from tests.studies.bench_binary import BINARY, EMULATED, NOISE, SCENARIOS, Scenario

# The difference of binary and emulated device, in N m: root of the mean square, and the most.
BOUNDS_NM = {"push": (1e-3, 4e-3), "bounce": (2e-3, 30e-3), "cut": (1e-3, 4e-3)}
# The same if either may be a millisecond late: a bounce has steps of more than 20 mN m in one.
MOST_NM_WITHIN_1_MS = 6e-3


@pytest.mark.parametrize(
    ("scenario", "board"),
    zip(SCENARIOS, itertools.cycle(pico.MODELS)),
    ids=lambda one: getattr(one, "name", one),
)
def test_binary_feels_as_the_emulated_device(scenario: Scenario, board: str) -> None:
    pico.choose(board)
    found = binary.run(scenario)
    for kind in (BINARY, NOISE):
        usual_nm, most_nm = binary.apart_nm(found, kind)
        usual_bound_nm, most_bound_nm = BOUNDS_NM[scenario.name]
        assert usual_nm < usual_bound_nm
        assert most_nm < most_bound_nm
    most_nm = felt.difference_nm(found[BINARY], found[EMULATED], rows=1)[1]
    assert most_nm < MOST_NM_WITHIN_1_MS
    for kind in (BINARY, EMULATED):
        measured = scenario.measure(found[kind])
        assert measured.get("oscillation_rad", 0.0) < 3e-3, "it is not at rest"
        assert abs(measured.get("final_depth_rad", 0.0)) < 1.5e-3
