"""What the law calibrated tells of energy, against telemetry and the emulated knob's truth."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import torsio
from torsio.config import Law

Visit = tuple[torsio.Energies, torsio.telemetry.Record, torsio.telemetry.Record]

FINE = 1 << 20
ACTUATOR = torsio.ActuatorConfig(counts_per_rev=FINE)
HAND = torsio.ImpedanceHand(
    intended_angle_rad=[(0.2, 0.0), (0.6, 0.04), (0.7, 0.04), (1.1, 0.0)],
    stiffness_nm_per_rad=2.0,
    damping_nm_s_per_rad=0.02,
)
WALL = torsio.Wall(stiffness_nm_per_rad=2.0)


def visited(law: Law) -> Visit:
    """Press into a wall and out again; energies, telemetry of every tick, and the truth."""
    options = torsio.EmulatorOptions(
        hand=HAND, plant=torsio.PlantParams(counts_per_rev=FINE), log_truth=True
    )
    with torsio.open("emulated", emulator=options) as knob:
        knob.configure(ACTUATOR)
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


def test_energies_close_and_agree_with_the_truth(calibrated: Visit) -> None:
    told, _, truth = calibrated
    assert told.motor_j == pytest.approx(told.felt_j + told.stored_j + told.brake_j, abs=1e-12)
    way_rad = np.diff(truth["brake_angle_rad"])
    braked = 0.5 * (truth["brake_torque_nm"][1:] + truth["brake_torque_nm"][:-1])
    brake_j = -float(np.sum(braked * way_rad))
    assert brake_j > 1e-4
    assert told.brake_j == pytest.approx(brake_j, rel=0.02)
    mean_nm = 0.5 * (truth["motor_torque_nm"][1:] + truth["motor_torque_nm"][:-1])
    motor_j = float(np.sum(mean_nm * np.diff(truth["angle_rad"])))
    assert told.motor_j == pytest.approx(motor_j, rel=0.02)


def test_law_that_bounds_nothing_keeps_no_count() -> None:
    told, _, _ = visited("compensated")
    assert not told.kept
    assert (told.motor_j, told.felt_j, told.brake_j, told.bound_nm_per_rad) == (0, 0, 0, 0)


def test_stiffest_that_is_rendered_begins_at_three_times_what_is_stable(calibrated: Visit) -> None:
    told, _, _ = calibrated
    with torsio.open("emulated") as knob:
        knob.configure(ACTUATOR)
        knob.configure(torsio.ControlConfig(law="calibrated"))
        # The law's beginning leaves the encoder's steps out, which it finds out by itself.
        steps = ACTUATOR.motor_torque_max_nm * ACTUATOR.counts_per_rev / (2.0 * math.pi)
        stable = 1.0 / (1.0 / knob.stable_stiffness().stiffness_nm_per_rad - 1.0 / steps)
        assert told.bound_nm_per_rad == pytest.approx(3.0 * stable, rel=1e-5)
        assert dataclasses.replace(knob.energies(), tick=0, time_s=0.0) == torsio.Energies(
            tick=0, time_s=0.0, kept=True, motor_j=0.0, felt_j=0.0, stored_j=0.0, brake_j=0.0,
            bound_nm_per_rad=0.0,
        )  # fmt: skip
