"""A calibration's excitations through both binaries; ./dev bench calibration does whole ones."""

from __future__ import annotations

import numpy as np
import pytest

from tests.board.hidden import hidden_board
from torsio.calibration.play import Player, Recording
from torsio_studies.calibration.knobs import hidden_knob, truth_of

TORQUE_NM, STRETCH_S = 40e-3, 0.06


def _acceleration(log: Recording, begin_s: float) -> float:
    part = log.between(begin_s + 0.01, begin_s + STRETCH_S - 2e-3)
    return 2.0 * float(np.polyfit(part.time_s - part.time_s[0], part.angle_rad, 2)[0])


@pytest.mark.parametrize("number", [1000])
def test_torques_to_and_fro_tell_the_inertia_through_the_binary(number: int) -> None:
    hidden = hidden_knob(number)
    with hidden_board(hidden) as knob:
        assert hidden.reversed == knob.actuator_config().encoder_reversed
        with Player.playing(knob) as player:
            log = player.chain(
                [
                    (STRETCH_S, {"motor_command_nm": TORQUE_NM}),
                    (STRETCH_S, {"motor_command_nm": -TORQUE_NM}),
                ],
                travel_rad=20.0,
                speed_limit_rad_s=60.0,
                torque_limit_nm=TORQUE_NM,
            )
        assert knob.state == "disarmed"
        # Samples come from the first excitation on, which the chain begins with.
        assert log.stopped == ""
        begin_s = float(log.time_s[np.argmax(log.motor_nm > 0.5 * TORQUE_NM)] - log.time_s[0])
        faster = _acceleration(log, begin_s) - _acceleration(log, begin_s + STRETCH_S)
    # It turns one way in both, so friction drops out; the configuration has its encoder reversed.
    sign = -1.0 if hidden.reversed else 1.0
    inertia = truth_of(hidden.plant)["inertia_kg_m2"]
    assert sign * 2.0 * TORQUE_NM / faster == pytest.approx(inertia, rel=0.05)
