"""Parts of the plant against an integration of their own equations by SciPy."""

from __future__ import annotations

import numpy as np
import pytest

from tests.python.parts_oracle import Rows
from torsio import Belt, BrakeHysteresis, Cogging, PlantParams, ShaftHardening
from torsio.emulator import Plant

HARD = ShaftHardening(knee_rad=0.008, stiffness_factor=2.5)
SOFT = ShaftHardening(knee_rad=0.008, stiffness_factor=0.5)
COGGING = Cogging.sine(periods_per_rev=12, amplitude_nm=3e-3, points=8)
PLANTS = {
    "rigid": PlantParams(spring_and_brake=False),
    "hardening": PlantParams(shaft_hardening=HARD),
    "hysteresis": PlantParams(brake_hysteresis=BrakeHysteresis()),
    "cogging": PlantParams(cogging=COGGING),
    "belt": PlantParams(belt=Belt()),
    "all": PlantParams(
        belt=Belt(), shaft_hardening=SOFT, brake_hysteresis=BrakeHysteresis(), cogging=COGGING
    ),
}


@pytest.mark.parametrize("name", PLANTS)
def test_part_moves_as_its_equations_say(name: str) -> None:
    params, ticks = PLANTS[name], 80
    random = np.random.default_rng(5)
    motor = np.repeat(random.uniform(-0.07, 0.07, ticks // 8), 8)
    brake = np.repeat(random.uniform(0.0, 0.06, ticks // 8), 8)
    plant = Plant(params)
    rows = plant.record(motor, brake)
    got = {
        key: np.append(rows[key][1:], plant.state[key]) for key in ("angle_rad", "spring_torque_nm")
    }
    truth, seen = Rows(params), []
    for command in zip(motor, brake, strict=True):
        truth.advance(*map(float, command))
        seen.append(truth.seen())
    angles, torques = np.asarray(seen).T
    assert np.abs(got["angle_rad"] - angles).max() <= 1e-8 * np.abs(angles).max()
    assert np.abs(got["spring_torque_nm"] - torques).max() <= 1e-8 * np.abs(torques).max()
