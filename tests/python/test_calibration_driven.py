"""A brake whose coil the bridge drives, and whose iron keeps a torque until it is demagnetised.

The truth is the plant's own, through a supply and a sensor that are what the board takes them for.
"""

from __future__ import annotations

from dataclasses import replace

import pytest

import torsio
from torsio import calibration

LOOP_NM, DRAG_NM, KNOB_NM = 6e-3, 2e-3, 6e-3
COIL_S, DRIVEN_S = 60e-3, 15e-3
ELECTRICS = torsio.Electrics()
PLANT = torsio.PlantParams(
    knob_coulomb_nm=KNOB_NM,
    brake_drag_nm=DRAG_NM,
    brake_hysteresis=torsio.BrakeHysteresis(half_width_nm=LOOP_NM),
    electrics=replace(ELECTRICS, coil_inductance_h=COIL_S * ELECTRICS.coil_resistance_ohm),
)


@pytest.fixture(scope="module")
def found() -> calibration.Calibration:
    """Calibrate a knob whose coil follows faster than by itself."""
    options = torsio.EmulatorOptions(
        seed=4,
        control_rate_hz=20_000.0,
        plant=PLANT,
        actuator=replace(torsio.ActuatorConfig(), brake_time_constant_s=DRIVEN_S),
        board=torsio.BoardConfig(brake_inductance_h=COIL_S * ELECTRICS.coil_resistance_ohm),
    )
    with torsio.open("emulated", emulator=options) as knob:
        knob.update(motor_current_continuous_a=2.0)
        return calibration.calibrate(knob)


def test_drag_loop_and_release_hold_the_truth(found: calibration.Calibration) -> None:
    for name, true, most in (
        ("knob_coulomb_nm", KNOB_NM, 0.1e-3),
        ("brake_drag_nm", DRAG_NM, 0.5e-3),
        ("hysteresis_nm", LOOP_NM, 0.5e-3),
        ("release_s", DRIVEN_S, 1e-3),
    ):
        of = found.quantities[name]
        assert abs(of.value - true) < 3.0 * of.standard_uncertainty < 3.0 * most, name


def test_loop_is_proposed_and_how_fast_the_coil_is_driven_stays_as_it_is_set(
    found: calibration.Calibration,
) -> None:
    assert found.actuator.brake_hysteresis_nm == pytest.approx(LOOP_NM, rel=0.1)
    rise_s = found.quantities["rise_s"]
    assert rise_s.value > 1.02 * DRIVEN_S  # the supply ends before that
    assert rise_s.standard_uncertainty < 1e-3
    assert found.actuator.brake_time_constant_s == pytest.approx(DRIVEN_S, rel=1e-6)
    assert found.known.sigma_brake_time_constant_s == 0.0
    assert found.actuator.brake_release_time_constant_s == pytest.approx(DRIVEN_S, rel=0.1)


def test_curve_leaves_out_where_the_board_demagnetises(found: calibration.Calibration) -> None:
    curve = found.brake_curve
    assert curve is not None
    assert all(one.command_nm > 0.0 for one in curve.points)
    assert max(one.sigma_nm for one in curve.points) < 1e-3
    assert curve.is_straight
