"""Parts of the emulated plant, named from Python. Expected values come from closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import torsio
from torsio import Belt, BrakeHysteresis, Cogging, PlantParams, ShaftHardening
from torsio.closed_loop import InitialState
from torsio.emulator import Plant

K = 2.873
FREE: dict[str, Any] = {"knob_coulomb_nm": 0.0, "knob_viscous_nm_s_per_rad": 0.0}


def twist_under(torque_nm: float, params: PlantParams) -> float:
    """Let the brake hold, and give how far a constant torque of the motor turns the knob."""
    plant = Plant(params)
    plant.set_command(motor_command_nm=0.0, brake_command_nm=0.11)
    plant.advance(1_000_000_000)
    plant.set_command(motor_command_nm=torque_nm, brake_command_nm=0.11)
    plant.advance(5_000_000_000)
    return float(plant.state["angle_rad"])


def test_hardening_bends_the_characteristic_at_its_knee() -> None:
    hard = ShaftHardening(knee_rad=0.01, stiffness_factor=3.0)
    params = PlantParams(shaft_hardening=hard, shaft_damping_nm_s_per_rad=1e-2, **FREE)
    expected = 0.01 + (0.06 - K * 0.01) / (3.0 * K)
    assert twist_under(0.06, params) == pytest.approx(expected, rel=1e-6)


def test_belt_is_a_spring_behind_the_spring() -> None:
    belt = Belt(stiffness_nm_per_rad=6.0, damping_nm_s_per_rad=1e-2)
    params = PlantParams(belt=belt, shaft_damping_nm_s_per_rad=1e-2, **FREE)
    assert twist_under(0.06, params) == pytest.approx(0.06 / K + 0.06 / 6.0, rel=1e-6)


def test_hysteresis_leaves_the_brake_short_of_its_command_by_the_half_width() -> None:
    plant = Plant(PlantParams(brake_hysteresis=BrakeHysteresis(half_width_nm=5e-3)))
    plant.set_command(brake_command_nm=0.05)
    plant.advance(2_000_000_000)
    assert plant.state["brake_capacity_nm"] == pytest.approx(0.05 - 5e-3 + 2e-3, rel=1e-9)
    plant.set_command(brake_command_nm=0.03)
    plant.advance(2_000_000_000)
    assert plant.state["brake_capacity_nm"] == pytest.approx(0.03 + 5e-3 + 2e-3, rel=1e-9)


def test_cogging_pulls_with_the_torque_of_its_table() -> None:
    wave = Cogging.sine(periods_per_rev=12, amplitude_nm=4e-3, points=16)
    params = PlantParams(cogging=wave, spring_and_brake=False, brake_drag_nm=0.0, **FREE)
    plant = Plant(params)
    quarter = 2 * math.pi / 12 / 4
    plant.set_state(InitialState(revolutions=3, angle_rad=quarter))
    plant.advance(100_000)
    assert plant.state["speed_rad_s"] == pytest.approx(4e-3 / 1e-4 * 1e-4, rel=1e-3)


def test_state_that_is_set_is_where_the_plant_goes_on() -> None:
    plant = Plant(PlantParams(spring_and_brake=False, brake_drag_nm=0.0, **FREE))
    plant.set_state(InitialState(time_s=2.0, angle_rad=1.0, speed_rad_s=3.0))
    plant.advance(1_000_000_000)
    assert plant.time_ns == 3_000_000_000
    decay = 2e-6 / 1e-4  # the brake's viscous friction is left
    travelled = 3.0 * (1.0 - math.exp(-decay)) / decay
    assert plant.state["angle_rad"] == pytest.approx(1.0 + travelled, rel=1e-9)


@pytest.mark.parametrize(
    "wrong",
    [
        {"speed_rad_s": math.nan},
        {"time_s": math.inf},
        {"time_s": -1e-9},
        {"angle_rad": 1e30},
        {"revolutions": 2**63 - 1},
    ],
    ids=lambda wrong: next(iter(wrong)),
)
def test_state_that_is_out_of_range_is_refused_and_changes_nothing(wrong: dict[str, Any]) -> None:
    plant = Plant(PlantParams())
    before = plant.state
    with pytest.raises(ValueError, match=f"initial: {next(iter(wrong))} "):
        plant.set_state(InitialState(**wrong))
    assert plant.state == before


def test_open_without_spring_and_brake_moves_one_rigid_body() -> None:
    with torsio.open(
        "emulated",
        emulator=torsio.EmulatorOptions(
            plant=PlantParams(spring_and_brake=False),
            hand=torsio.TorqueHand(torque_nm=0.02),
            control=torsio.ControlConfig(law="motor_only"),
            log_truth=True,
        ),
    ) as knob:
        knob.sleep(0.2)
        truth = knob.emulator.truth()
    assert np.all(truth["brake_angle_rad"] == truth["angle_rad"])
    # Torque less all friction, over all inertia.
    time_s = truth["time_s"][-1]
    slip = (0.02 - 8e-3) / 1e-4
    assert truth["speed_rad_s"][-1] == pytest.approx(slip * time_s, rel=0.05)


def test_open_with_a_noisy_encoder_sees_that_noise() -> None:
    with torsio.open(
        "emulated",
        emulator=torsio.EmulatorOptions(seed=3, plant=PlantParams(encoder_noise_counts=2.0)),
    ) as knob:
        log = knob.record(duration_s=1.0)
    counts = log["angle_rad"] * 8192 / (2 * math.pi)
    # Rounding adds 1/12 to the variance.
    assert np.std(counts) == pytest.approx(math.sqrt(4.0 + 1 / 12), rel=0.15)


@pytest.mark.parametrize(
    ("plant", "wanted"),
    [
        (PlantParams(belt=Belt(), spring_and_brake=False), "need spring_and_brake"),
        (PlantParams(belt=Belt(stiffness_nm_per_rad=0.0)), r"belt\.stiffness_nm_per_rad"),
        (PlantParams(shaft_hardening=ShaftHardening(stiffness_factor=-1.0)), "stiffness_factor"),
        (PlantParams(cogging=Cogging(periods_per_rev=7, torque_nm=(1e-3,))), "from 2 to 64"),
        (PlantParams(encoder_noise_counts=-1.0), "noise_counts"),
        (PlantParams(encoder_rounding="up"), "encoder_rounding"),  # type: ignore[arg-type]
        (PlantParams(knob_inertia_kg_m2=-1e-5), "knob_inertia_kg_m2"),
    ],
)
def test_open_refuses_a_part_by_name(plant: PlantParams, wanted: str) -> None:
    with pytest.raises(torsio.InvalidArgument, match=wanted):
        torsio.open("emulated", emulator=torsio.EmulatorOptions(plant=plant))
