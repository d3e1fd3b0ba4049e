"""The stiffness that a knob promises rests on the board's own current loop."""

from __future__ import annotations

import pytest

import torsio
from tests.bench import bench_stiffness as bench

# By how much each board's own current loop trails: the motor's lag of its configuration.
LAGS_S = {"pico2": 44e-6, "pico": 160e-6}


@pytest.mark.parametrize("counts", [2048, 4096, *bench.COUNTS])
@pytest.mark.parametrize("board", LAGS_S)
def test_knob_promises_no_stiffness_that_the_board_does_not_hold(board: str, counts: int) -> None:
    loop = next(one for one in bench.LOOPS if one.board == board and "500 Hz" not in one.name)
    options = torsio.EmulatorOptions(plant=loop.plant(counts), control_rate_hz=loop.rate_hz)
    with torsio.open("emulated", emulator=options) as knob:
        knob.update(counts_per_rev=counts, motor_time_constant_s=LAGS_S[board])
        told = knob.stable_stiffness().stiffness_nm_per_rad
    assert bench.rests(loop, counts, [0.5 * told, 0.75 * told, told]).all()
    # Nor much less than it holds.
    assert not bench.rests(loop, counts, [2.5 * told]).all()
