"""A brake that keeps some of its torque: a calibration finds the same before use and after.

The truth is the plant's own: friction of the knob's side, drag, and half the width of the loop.
"""

from __future__ import annotations

import json
from dataclasses import dataclass

import pytest

import torsio
from torsio import calibration

KNOB_NM, DRAG_NM, LOOP_NM = 6e-3, 2e-3, 6e-3
PLANT = torsio.PlantParams(
    knob_coulomb_nm=KNOB_NM,
    brake_drag_nm=DRAG_NM,
    brake_hysteresis=torsio.BrakeHysteresis(half_width_nm=LOOP_NM),
)


@dataclass(frozen=True)
class Found:
    """Results of one knob, one after the other."""

    fresh: calibration.Calibration
    quick: calibration.Calibration
    used: calibration.Calibration


@pytest.fixture(scope="module")
def found() -> Found:
    """Calibrate a knob that never braked; take what it proposes, use it, and calibrate again."""
    options = torsio.EmulatorOptions(seed=4, control_rate_hz=10_000.0, plant=PLANT)
    with torsio.open("emulated", emulator=options) as knob:
        fresh = calibration.calibrate(knob)
        calibration.apply(knob, fresh)
        _use(knob)
        quick = calibration.calibrate(knob, drift=True)
        return Found(fresh, quick, calibration.calibrate(knob))


def _use(knob: torsio.Knob) -> None:
    """Push hard into a wall, let go, and disarm."""
    here = knob.position_rad()
    knob.play(torsio.Wall(angle_rad=here + 0.05, stiffness_nm_per_rad=1.0))
    knob.arm()
    knob.emulator.set_hand(torsio.TorqueHand(torque_nm=60e-3))
    knob.sleep(1.0)
    assert knob.position_rad() > here + 0.05
    knob.emulator.set_hand(torsio.TorqueHand(torque_nm=0.0))
    knob.sleep(1.0)
    knob.disarm()


def test_friction_has_not_drifted_because_the_knob_was_used(found: Found) -> None:
    kept = json.loads(json.dumps(found.fresh.as_dict()))
    assert calibration.drifts(kept, found.quick) == []
    assert calibration.drifts(kept, found.used) == []


@pytest.mark.parametrize("when", ["fresh", "used"])
def test_drag_and_loop_are_told_apart(found: Found, when: str) -> None:
    quantities = getattr(found, when).quantities
    for name, true in (
        ("coulomb_nm", KNOB_NM + DRAG_NM + LOOP_NM),  # as the brake leaves it
        ("knob_coulomb_nm", KNOB_NM),
        ("brake_drag_nm", DRAG_NM),
        ("hysteresis_nm", LOOP_NM),
    ):
        of = quantities[name]
        assert abs(of.value - true) < 3.0 * of.standard_uncertainty, name
        assert of.standard_uncertainty < 0.1e-3, name


@pytest.mark.parametrize("when", ["fresh", "used"])
def test_assist_stays_within_the_friction_that_is_always_there(found: Found, when: str) -> None:
    most_nm = 0.73 * (KNOB_NM + DRAG_NM)
    assert 0.97 * most_nm < getattr(found, when).free_assist_nm < most_nm


@pytest.mark.parametrize("when", ["fresh", "used"])
def test_curve_is_the_straight_line_that_it_is(found: Found, when: str) -> None:
    curve = getattr(found, when).brake_curve
    assert curve.is_straight, curve.in_words()
    (last,) = [one for one in curve.points if one.command_nm == 0.0]
    assert abs(last.torque_nm - LOOP_NM) < 3.0 * last.sigma_nm


def test_quick_look_does_not_take_what_the_loop_leaves_for_drag(found: Found) -> None:
    assert "brake_drag_nm" not in found.quick.quantities
    assert found.quick.actuator.brake_drag_nm == pytest.approx(found.fresh.actuator.brake_drag_nm)
