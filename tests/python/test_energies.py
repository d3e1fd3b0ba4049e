"""The energies of the law calibrated, against telemetry and the emulated knob's truth."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import torsio
from torsio.printed.config import Law
from torsio.printed.told import Energies

Visit = tuple[Energies, torsio.telemetry.Record, torsio.telemetry.Record]

FINE = 1 << 20
ACTUATOR = torsio.ActuatorConfig(counts_per_rev=FINE)
PLANT = torsio.PlantParams(counts_per_rev=FINE)
HAND = torsio.ImpedanceHand(
    intended_angle_rad=[(0.2, 0.0), (0.6, 0.04), (0.7, 0.04), (1.1, 0.0)],
    stiffness_nm_per_rad=2.0,
    damping_nm_s_per_rad=0.02,
)
WALL = torsio.Wall(stiffness_nm_per_rad=2.0)


def visited(
    law: Law,
    actuator: torsio.ActuatorConfig = ACTUATOR,
    plant: torsio.PlantParams = PLANT,
    rate_hz: float = 1000.0,
) -> Visit:
    """Press into a wall and out again; energies, telemetry of every tick, and the truth."""
    options = torsio.EmulatorOptions(
        hand=HAND, plant=plant, control_rate_hz=rate_hz, log_truth=True
    )
    with torsio.open("emulated", emulator=options) as knob:
        knob.configure(actuator)
        knob.configure(torsio.ControlConfig(law=law, passive_ramp_s=0.0))
        knob.play(WALL)
        knob.arm()
        log = knob.record(1.3, rate_hz=1000.0)
        return knob.energies(), log, knob.emulator.truth()


@pytest.fixture(scope="module")
def calibrated() -> Visit:
    return visited("calibrated")


def test_energies_agree_with_the_sums_of_telemetry_to_its_rounding(calibrated: Visit) -> None:
    told, log, _ = calibrated
    way_rad = np.diff(log["angle_rad"])
    motor_j = float(np.sum(log["motor_command_nm"][:-1] * way_rad))
    spring_nm = log["spring_torque_nm"]
    spring_j = float(np.sum(0.5 * (spring_nm[1:] + spring_nm[:-1]) * way_rad))
    # Telemetry rounds each torque to a step of 10 uN m; the knob rests before.
    rounding_j = 1e-5 * float(np.sum(np.abs(way_rad)))
    assert abs(motor_j) > 1e-4
    assert told.motor_j == pytest.approx(motor_j, abs=rounding_j)
    assert told.felt_j - told.motor_j == pytest.approx(spring_j, abs=rounding_j)


def test_energies_agree_with_the_truth(calibrated: Visit) -> None:
    told, _, truth = calibrated
    way_rad = np.diff(truth["brake_angle_rad"])
    braked = 0.5 * (truth["brake_torque_nm"][1:] + truth["brake_torque_nm"][:-1])
    brake_j = -float(np.sum(braked * way_rad))
    assert brake_j > 1e-4
    assert told.brake_j == pytest.approx(brake_j, rel=0.02)
    mean_nm = 0.5 * (truth["motor_torque_nm"][1:] + truth["motor_torque_nm"][:-1])
    motor_j = float(np.sum(mean_nm * np.diff(truth["angle_rad"])))
    assert told.motor_j == pytest.approx(motor_j, rel=0.02)


@pytest.mark.parametrize("counts", [1 << 13, 1 << 15, 1 << 17, 1 << 20])
def test_energies_are_off_by_what_the_counts_leave_open_and_no_more(counts: int) -> None:
    # No lag, no damping of the shaft and next to no inertia behind it: only the counts are left.
    parts: dict[str, Any] = {
        "counts_per_rev": counts, "motor_time_constant_s": 0.0, "brake_inertia_kg_m2": 1e-7,
    }  # fmt: skip
    told, _, truth = visited(
        "calibrated",
        torsio.ActuatorConfig(**parts),
        torsio.PlantParams(**parts, shaft_damping_nm_s_per_rad=0.0),
        rate_hz=10_000.0,
    )
    braked = 0.5 * (truth["brake_torque_nm"][1:] + truth["brake_torque_nm"][:-1])
    brake_j = -float(np.sum(braked * np.diff(truth["brake_angle_rad"])))
    # The motor's torque is held until the row that tells it.
    motor_j = float(np.sum(truth["motor_torque_nm"][1:] * np.diff(truth["angle_rad"])))
    assert min(brake_j, motor_j) > 1e-4
    # An eighth with 8,192 counts, and so on in proportion, down to a thousandth with a million.
    assert told.brake_j == pytest.approx(brake_j, rel=1000 / counts)
    assert told.motor_j == pytest.approx(motor_j, rel=1000 / counts)


def test_law_that_bounds_nothing_keeps_no_count() -> None:
    told, _, _ = visited("compensated")
    assert not told.kept
    assert (told.motor_j, told.felt_j, told.brake_j, told.bound_nm_per_rad) == (0, 0, 0, 0)


def test_stiffest_that_is_rendered_begins_at_three_times_what_is_stable(calibrated: Visit) -> None:
    told, _, _ = calibrated
    with torsio.open("emulated") as knob:
        knob.configure(ACTUATOR)
        knob.configure(torsio.ControlConfig(law="calibrated"))
        # The law starts without the encoder's part of equation (8').
        steps = ACTUATOR.motor_torque_max_nm * ACTUATOR.counts_per_rev / (2.0 * math.pi)
        stable = 1.0 / (1.0 / knob.stable_stiffness().stiffness_nm_per_rad - 1.0 / steps)
        assert told.bound_nm_per_rad == pytest.approx(3.0 * stable, rel=1e-5)
        assert dataclasses.replace(knob.energies(), tick=0, time_s=0.0) == Energies(
            tick=0, time_s=0.0, kept=True, motor_j=0.0, felt_j=0.0, stored_j=0.0, brake_j=0.0,
            bound_nm_per_rad=0.0,
        )  # fmt: skip
