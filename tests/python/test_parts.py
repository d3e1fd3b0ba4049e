"""Parts of the emulated plant, named from Python. Expected values come from closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import torsio
from torsio import Belt, Cogging, PlantParams, ShaftHardening
from torsio.closed_loop import InitialState
from torsio.emulator import Plant

FREE: dict[str, Any] = {"knob_coulomb_nm": 0.0, "knob_viscous_nm_s_per_rad": 0.0}


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


def test_sine_has_two_corners_at_least() -> None:
    assert list(Cogging.sine(periods_per_rev=7, amplitude_nm=0.0, points=2).torque_nm) == [0, 0]


def test_plant_of_another_kind_is_refused() -> None:
    with pytest.raises(TypeError, match="params must be PlantParams"):
        Plant(torsio.ActuatorConfig())  # type: ignore[arg-type]


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
