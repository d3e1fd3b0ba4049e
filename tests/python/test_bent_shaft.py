"""A shaft that is not one straight line: what the sensor makes of it, and how it is known."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import torsio
from tests.python.test_calibrated_law import (
    COUNTS,
    options_of,
    sensor_error_nm,
    visitor,
)
from torsio import PlantParams, ShaftConfig, ShaftHardening, calibration
from torsio.closed_loop import replay, simulate
from torsio.printed.config import Law

STIFFNESS = 1.4
# Twice as stiff from 14 mN m on, and half as stiff.
HARDENING, SOFTENING = (
    PlantParams(
        counts_per_rev=COUNTS,
        shaft_hardening=ShaftHardening(knee_rad=0.005, stiffness_factor=factor),
    )
    for factor in (2.0, 0.5)
)


@pytest.mark.parametrize("law", ["paper", "compensated", "calibrated"])
@pytest.mark.parametrize("plant", [HARDENING, SOFTENING], ids=["hardening", "softening"])
def test_sensor_that_knows_the_curve_errs_as_on_a_straight_shaft(
    plant: PlantParams, law: Law
) -> None:
    control = torsio.ControlConfig(law=law)

    def error_nm(plant: PlantParams, shaft: ShaftConfig | None) -> float:
        options = options_of(stiffness=STIFFNESS, plant=plant, hand=visitor(STIFFNESS))
        options = replace(options, control=control, shaft=shaft)
        return sensor_error_nm(simulate(options, duration_s=1.1))

    straight_nm = error_nm(replace(plant, shaft_hardening=None), None)
    told_nm, untold_nm = error_nm(plant, None), error_nm(plant, ShaftConfig())
    assert told_nm < 1.2 * straight_nm + 1e-4
    # The other laws err too, because they know less of the brake.
    assert untold_nm > (4.0 if law == "calibrated" else 1.25) * told_nm


def test_knees_beyond_reach_change_no_bit_of_any_law() -> None:
    far = ShaftConfig(knee_1_rad=90.0, knee_1_nm_per_rad=7.0)
    for law in ("paper", "compensated", "parallel", "motor_only", "calibrated"):
        options = options_of(stiffness=STIFFNESS, hand=visitor(STIFFNESS))
        options = replace(options, control=torsio.ControlConfig(law=law))
        rows = simulate(options, duration_s=1.1)
        counts = rows["position_counts"].astype(np.int64).astype(np.uint32)
        bent = replay(replace(options, shaft=far), counts)
        assert bent.tobytes() == replay(options, counts).tobytes(), law


def test_calibration_finds_the_knee_and_the_device_keeps_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    plant = PlantParams(shaft_hardening=ShaftHardening())
    options = torsio.EmulatorOptions(seed=5, control_rate_hz=10_000.0, plant=plant)
    with torsio.open("emulated", emulator=options) as knob:
        assert knob.shaft_config() == ShaftConfig()
        found = calibration.calibrate(knob)
        assert knob.shaft_config() == ShaftConfig()
        calibration.apply(knob, found)
        shaft = knob.shaft_config()
        assert shaft.knee_1_rad == pytest.approx(0.015, rel=0.02)
        assert shaft.knee_1_nm_per_rad == pytest.approx(2 * 2.873, rel=0.03)
        assert shaft.knee_2_rad == 0.0
        assert 0.0 < knob.calibration_config().sigma_knee_1_nm_per_rad < 0.1
        truth = plant.matching_shaft()
        assert truth == ShaftConfig(knee_1_rad=0.015, knee_1_nm_per_rad=2 * 2.873)


def test_curve_is_kept_dumped_and_loaded(tmp_path: Path) -> None:
    curve = ShaftConfig(
        knee_1_rad=0.01, knee_1_nm_per_rad=4.0, knee_2_rad=0.0625, knee_2_nm_per_rad=0.5
    )
    with torsio.open("emulated:bent-shaft") as knob:
        knob.configure(curve)
        text = torsio.dump_config(knob)
        assert json.loads(text)["shaft_config"]["knee_2_rad"] == 0.0625
        knob.save()
        knob.load_defaults()
        assert knob.shaft_config() == ShaftConfig()
    with torsio.open("emulated:bent-shaft") as knob:
        kept = knob.shaft_config()
        assert kept.knee_1_rad == pytest.approx(0.01)
        knob.load_defaults()
        torsio.load_config(knob, text)
        assert knob.shaft_config() == kept
        knob.update(knee_2_rad=0.125)
        assert knob.shaft_config().knee_2_rad == 0.125


def test_what_a_bent_shaft_has_stored_is_what_its_curve_says() -> None:
    """By hand: 43.095 mN m at the knee of 15 mrad, then 5.746 N m/rad."""
    options = torsio.EmulatorOptions(
        plant=PlantParams(shaft_hardening=ShaftHardening(), brake_drag_nm=0.1),
        actuator=torsio.ActuatorConfig(
            brake_drag_nm=0.1, brake_torque_min_nm=0.1, brake_inertia_kg_m2=0.0
        ),
        shaft=PlantParams(shaft_hardening=ShaftHardening()).matching_shaft(),
        control=torsio.ControlConfig(law="calibrated"),
        hand=torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (0.5, 0.02), (9.0, 0.02)]),
    )
    with torsio.open("emulated", emulator=options) as knob:
        knob.sleep(1.0)
        twist_rad = knob.clock().angle_rad
        torque_nm = 0.043095 + 5.746 * (twist_rad - 0.015)
        work_j = 0.5 * 0.043095 * 0.015 + 0.5 * (0.043095 + torque_nm) * (twist_rad - 0.015)
        energies = knob.energies()
        assert energies.stored_j == pytest.approx(work_j, rel=1e-4)
        assert energies.motor_j == pytest.approx(
            energies.felt_j + energies.stored_j + energies.brake_j, abs=1e-12
        )
        assert abs(energies.brake_j) < 0.01 * work_j  # it held
