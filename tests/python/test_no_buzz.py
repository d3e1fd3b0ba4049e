"""Bounded stiffness on the boards' own current loops; ./dev bench buzz tries far more."""

from __future__ import annotations

import itertools

import pytest

from tests.python.buzzing import BOARDS, HANDS, REST_COUNTS, SPEEDS_RAD_S, Trial, motion
from torsio.perception import VIBRATION_NM


@pytest.mark.parametrize("two_sided", [False, True], ids=["wall", "spring"])
@pytest.mark.parametrize("board", BOARDS)
def test_knob_comes_to_rest_on_the_board_s_own_loop(board: str, two_sided: bool) -> None:
    trials = [
        Trial(board, stiffness, speed, hand, two_sided, delay)
        for stiffness, speed, hand, delay in itertools.product(
            (0.0, 1.0, 8.0, 20.0, 50.0, 200.0, 1e4, 1e6), SPEEDS_RAD_S, HANDS, (0, 1)
        )
    ]
    motions = {trial: motion(trial) for trial in trials}
    assert {trial: moved for trial, (moved, _, _) in motions.items() if moved > REST_COUNTS} == {}
    loud = {trial: vibration for trial, (_, _, vibration) in motions.items()}
    assert {trial: torque for trial, torque in loud.items() if torque >= VIBRATION_NM} == {}


@pytest.mark.parametrize("counts", [8192, 131072])
@pytest.mark.parametrize("board", BOARDS)
def test_knob_turns_round_no_more_with_a_coarse_or_a_fine_encoder(board: str, counts: int) -> None:
    trials = [
        Trial(board, stiffness, speed, hand, two_sided, delay, counts)
        for stiffness, speed, hand, two_sided, delay in itertools.product(
            (20.0, 200.0, 1e6), SPEEDS_RAD_S, HANDS, (False, True), (0, 1)
        )
    ]
    moves = {trial: motion(trial) for trial in trials}
    assert {trial: turns for trial, (_, turns, _) in moves.items() if turns > 0} == {}
    # In finer counts it may still creep, by an angle that a coarse encoder does not show.
    most = REST_COUNTS * max(counts / 32768, 1.0)
    assert {trial: moved for trial, (moved, _, _) in moves.items() if moved > most} == {}


@pytest.mark.parametrize("board", BOARDS)
def test_trials_can_tell_a_knob_that_buzzes(board: str) -> None:
    for speed_rad_s in SPEEDS_RAD_S:
        trial = Trial(board, 1e6, speed_rad_s, two_sided=True, law="compensated")
        moved, turns, vibration = motion(trial)
        assert vibration > 20e-3
        assert moved > 100
        assert turns > 10
