"""Emulated knobs with hidden parameters, and what a calibration says of them."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

import torsio
from torsio import calibration
from torsio.calibration import Calibration
from torsio.closed_loop import LoopOptions
from torsio.demos.wall import rms
from torsio.printed.plant import Belt, BrakeHysteresis, Cogging, PlantParams, ShaftHardening
from torsio_studies.paper import runs

RATE_HZ: Final = 10_000.0
MOTOR_LAG_S: Final = 0.1e-3  # as for the figures of docs/reference/calibration.md
WALL_NM_PER_RAD: Final = math.degrees(30e-3)
WALL_PHASES: Final = 16
EVALUATION: Final = 11
"""Changes whenever the numbers of the same knob may change."""

FIRST: Final = 1000
"""Number of the study's first knob; earlier ones were used to make the estimators."""

FAR: Final = 2000
"""From this number on the brake, the shaft's knee and the cogging are far from the reference's."""
FIRST_FAR: Final = 2040
"""Number of the study's first one of them; those before it were used to make the estimators."""

QUANTITIES: Final = (
    "inertia_kg_m2", "coulomb_nm", "viscous_nm_s_per_rad", "cogging_nm", "offset_nm",
    "stiffness_nm_per_rad", "backlash_rad", "knee_rad", "stiffness_factor", "knob_coulomb_nm",
    "knob_inertia_kg_m2", "shaft_damping_nm_s_per_rad", "brake_gain", "hysteresis_nm", "rise_s",
    "release_s", "brake_drag_nm", "brake_inertia_kg_m2", "knob_viscous_nm_s_per_rad",
)  # fmt: skip
_COGGING_POINTS: Final = 16


@dataclass(frozen=True)
class HiddenKnob:
    """A knob that the calibration does not know; `reversed` is how its encoder is configured."""

    number: int
    plant: PlantParams
    reversed: bool


@dataclass(frozen=True)
class Batch:
    """Knobs that are computed and stored together: their numbers."""

    group: str
    index: int
    designs: tuple[int, ...]


def batches(knobs: int, size: int) -> Iterator[Batch]:
    """Give all the work: so many knobs, and a fourth as many that are far from the reference."""
    for group, first, count in (("knob", FIRST, knobs), ("far", FIRST_FAR, max(knobs // 4, 1))):
        for begin in range(0, count, size):
            end = min(begin + size, count)
            yield Batch(group, begin // size, tuple(range(first + begin, first + end)))


def hidden_knob(number: int) -> HiddenKnob:
    """Draw a knob: half to twice the reference actuator, evenly in the logarithm."""
    random = np.random.default_rng([15, number])

    def near(value: float) -> float:
        return float(value * 2.0 ** random.uniform(-1.0, 1.0))

    def maybe() -> bool:
        return bool(random.random() < 0.5)

    default = PlantParams()
    stiffness = near(default.shaft_stiffness_nm_per_rad)
    plant = PlantParams(
        knob_inertia_kg_m2=near(default.knob_inertia_kg_m2),
        knob_viscous_nm_s_per_rad=near(default.knob_viscous_nm_s_per_rad),
        knob_coulomb_nm=near(default.knob_coulomb_nm),
        brake_inertia_kg_m2=near(default.brake_inertia_kg_m2),
        brake_viscous_nm_s_per_rad=near(default.brake_viscous_nm_s_per_rad),
        brake_drag_nm=near(default.brake_drag_nm),
        shaft_stiffness_nm_per_rad=stiffness,
        shaft_damping_nm_s_per_rad=near(default.shaft_damping_nm_s_per_rad),
        brake_time_constant_s=near(default.brake_time_constant_s),
        motor_time_constant_s=near(MOTOR_LAG_S),
        encoder_noise_counts=float(random.uniform(0.0, 0.3)),
        encoder_phase_counts=float(random.uniform(0.0, 1.0)),
        # So that the knee lies within what the motor can twist.
        shaft_hardening=ShaftHardening(
            knee_rad=near(0.010) * default.shaft_stiffness_nm_per_rad / stiffness,
            stiffness_factor=near(2.4),
        )
        if maybe()
        else None,
        brake_hysteresis=BrakeHysteresis(half_width_nm=near(4e-3)) if maybe() else None,
        belt=Belt() if maybe() else None,
        cogging=Cogging.sine(
            periods_per_rev=int(random.integers(6, 25)),
            amplitude_nm=near(1.5e-3),
            points=_COGGING_POINTS,
        )
        if maybe()
        else None,
    )
    is_reversed = maybe()
    return HiddenKnob(number, plant if number < FAR else _far(plant, number), is_reversed)


def _far(plant: PlantParams, number: int) -> PlantParams:
    """Give a knob a wide loop, a fast brake, cogging of many waves, and a shaft that may soften."""
    random = np.random.default_rng([38, number])

    def between(low: float, high: float) -> float:
        return float(low * (high / low) ** random.uniform())

    return replace(
        plant,
        brake_time_constant_s=between(4e-3, 0.12),
        brake_hysteresis=BrakeHysteresis(half_width_nm=between(1e-3, 22e-3)),
        cogging=Cogging.sine(
            periods_per_rev=round(between(6.0, 128.0)), amplitude_nm=between(0.75e-3, 3e-3),
            points=_COGGING_POINTS,
        ),
        shaft_hardening=ShaftHardening(
            knee_rad=between(5e-3, 20e-3), stiffness_factor=between(0.5, 4.8)
        ),
    )  # fmt: skip


def truth_of(plant: PlantParams) -> dict[str, float]:
    """Give what a perfect calibration would find; NaN for what this knob has not."""
    stiffness = plant.shaft_stiffness_nm_per_rad
    belt = math.inf if plant.belt is None else plant.belt.stiffness_nm_per_rad
    together = 1.0 / (1.0 / stiffness + 1.0 / belt)
    share = together / stiffness  # the shaft's part of the twist
    knee = factor = math.nan
    if plant.shaft_hardening is not None:
        hard = stiffness * plant.shaft_hardening.stiffness_factor
        knee = plant.shaft_hardening.knee_rad / share
        factor = 1.0 / (1.0 / hard + 1.0 / belt) / together
    cogging = 0.0
    if plant.cogging is not None:
        # A sine of straight lines has a little less of the first harmonic.
        corner = math.pi / _COGGING_POINTS
        cogging = max(plant.cogging.torque_nm) * (math.sin(corner) / corner) ** 2
    hysteresis = plant.brake_hysteresis
    loop_nm = 0.0 if hysteresis is None else hysteresis.half_width_nm
    return {
        "inertia_kg_m2": plant.knob_inertia_kg_m2 + plant.brake_inertia_kg_m2,
        # Once the brake has held.
        "coulomb_nm": plant.knob_coulomb_nm + plant.brake_drag_nm + loop_nm,
        "viscous_nm_s_per_rad": plant.knob_viscous_nm_s_per_rad + plant.brake_viscous_nm_s_per_rad,
        "cogging_nm": cogging,
        "offset_nm": 0.0,
        "stiffness_nm_per_rad": together,
        "backlash_rad": 0.0,
        "knee_rad": knee,
        "stiffness_factor": factor,
        "knob_coulomb_nm": plant.knob_coulomb_nm,
        "knob_inertia_kg_m2": plant.knob_inertia_kg_m2,
        "shaft_damping_nm_s_per_rad": plant.shaft_damping_nm_s_per_rad * share**2
        + plant.knob_viscous_nm_s_per_rad,
        "brake_gain": 1.0,
        "hysteresis_nm": loop_nm,
        "rise_s": plant.brake_time_constant_s,
        "release_s": plant.brake_time_constant_s,
        "knob_viscous_nm_s_per_rad": plant.knob_viscous_nm_s_per_rad,
        "brake_drag_nm": plant.brake_drag_nm,
        "brake_inertia_kg_m2": plant.brake_inertia_kg_m2,
    }


def emulated(
    plant: PlantParams,
    *,
    rate_hz: float = RATE_HZ,
    reversed: bool = False,
    seed: int = 0,
    log_truth: bool = False,
) -> torsio.Knob:
    """Open a knob whose device knows nothing of its plant but counts and limits."""
    believed = PlantParams(
        counts_per_rev=plant.counts_per_rev, motor_time_constant_s=MOTOR_LAG_S
    ).matching_config()
    return torsio.open(
        "emulated",
        emulator=torsio.EmulatorOptions(
            seed=seed,
            control_rate_hz=rate_hz,
            plant=plant,
            log_truth=log_truth,
            actuator=replace(believed, encoder_reversed=reversed),
        ),
    )


def wall_error(plant: PlantParams, found: Calibration | None = None) -> float:
    """Give the error on the way out of a stiff wall, RMS as a share of the peak, law `calibrated`.

    It is that over all phases of the encoder: where in a count the wall lies is luck.

    Parameters
    ----------
    found
        Beliefs of the device; None: the true parts.
    """
    options = runs.push_options(WALL_NM_PER_RAD, "calibrated", rate_hz=RATE_HZ, plant=plant)
    if found is not None:
        return _error_out(replace(options, actuator=found.actuator, shaft=found.shaft))
    if plant.belt is None:
        return _error_out(options)
    # A device knows of one spring: shaft and belt together.
    truth = truth_of(plant)
    stiffness = truth["stiffness_nm_per_rad"]
    shaft = torsio.ShaftConfig()
    if plant.shaft_hardening is not None:
        hard = truth["stiffness_factor"] * stiffness
        shaft = torsio.ShaftConfig(knee_1_rad=truth["knee_rad"], knee_1_nm_per_rad=hard)
    actuator = replace(plant.matching_config(), spring_stiffness_nm_per_rad=stiffness)
    return _error_out(replace(options, actuator=actuator, shaft=shaft))


def _error_out(options: LoopOptions) -> float:
    phases = [
        replace(options, plant=replace(options.plant, encoder_phase_counts=phase))
        for phase in np.arange(WALL_PHASES) / WALL_PHASES
    ]
    return rms(np.array([runs.run_push(phase)[1].tracking_rms_out for phase in phases]))


def measure(hidden: HiddenKnob) -> dict[str, float]:
    """Calibrate a knob; a reversed encoder must be refused first."""
    begin = time.perf_counter()
    row = {"number": float(hidden.number), "refused_rightly": 1.0, "complete": 0.0}
    row |= {f"{name}_truth": value for name, value in truth_of(hidden.plant).items()}
    row |= {f"{name}_{part}": math.nan for name in QUANTITIES for part in ("value", "sigma")}
    row["knob_seconds"] = row["wall_found"] = math.nan
    row["wall_true"] = wall_error(hidden.plant)
    with emulated(hidden.plant, reversed=hidden.reversed, seed=hidden.number) as knob:
        if hidden.reversed:
            try:
                calibration.calibrate(knob)
                row["refused_rightly"] = 0.0
            except calibration.Refusal as refusal:
                row["refused_rightly"] = float(refusal.reason == "reversed")
            knob.update(encoder_reversed=False)
        try:
            found = calibration.calibrate(knob)
            row["complete"] = 1.0
            row["knob_seconds"] = found.seconds
            row["wall_found"] = wall_error(hidden.plant, found)
            for name, quantity in found.quantities.items():
                row[f"{name}_value"] = quantity.value
                row[f"{name}_sigma"] = quantity.standard_uncertainty
        except calibration.Refusal:
            row["complete"] = 0.0
    row["seconds"] = time.perf_counter() - begin
    return row
