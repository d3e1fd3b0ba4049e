"""A search for plants and commands at which the exact stepper errs most."""

from __future__ import annotations

import math
from typing import Any, Final

import cma
import numpy as np
import numpy.typing as npt

from torsio.printed.hands import TorqueHand
from torsio.printed.plant import Belt, BrakeHysteresis, Cogging, PlantParams, ShaftHardening
from torsio_studies.enclosure.cases import Case
from torsio_studies.enclosure.evaluation import evaluate

__all__ = ["PARTS", "SPACE", "extreme_case", "search"]

PARTS: Final = ("shaft_hardening", "brake_hysteresis", "belt", "cogging")
SPACE: Final[dict[str, tuple[float, float]]] = {
    "knob_inertia_kg_m2": (1e-9, 1.0),
    "brake_inertia_kg_m2": (1e-9, 1.0),
    "knob_viscous_nm_s_per_rad": (1e-9, 1.0),
    "brake_viscous_nm_s_per_rad": (1e-9, 1.0),
    "knob_coulomb_nm": (1e-6, 1.0),
    "brake_drag_nm": (1e-6, 1.0),
    "shaft_stiffness_nm_per_rad": (1e-3, 1e6),
    "shaft_damping_nm_s_per_rad": (1e-9, 1.0),
    "motor_time_constant_s": (1e-6, 10.0),
    "brake_time_constant_s": (1e-6, 10.0),
    "knee_rad": (1e-6, 1.0),
    "factor": (0.1, 10.0),
    "half_width_nm": (1e-6, 0.1),
    "belt_nm_per_rad": (1e-3, 1e6),
    "belt_nm_s_per_rad": (1e-9, 1.0),
    "pulley_share": (0.01, 0.99),
    "periods_per_rev": (1.0, 1000.0),
    "cogging_nm": (1e-6, 0.1),
    "rate_hz": (100.0, 40_000.0),
    "push": (1.1, 100.0),
    "motor_nm": (1e-6, 0.085),
    "brake_nm": (1e-6, 0.1),
}
"""Bounds of the optimiser's variables, which move evenly in the logarithm.

`push` is the hand's largest torque over the knob's friction: less would not move it.
"""
_TICKS: Final = 20
_PIECES: Final = 4000  # of time to look at: a try takes a second at most
_POPULATION: Final = 10


def extreme_case(number: int, point: npt.ArrayLike) -> Case:
    """Make the case of a point, each coordinate from 0 to 1; bits of the number are its parts."""
    value: dict[str, Any] = {
        name: float(low * (high / low) ** share)
        for (name, (low, high)), share in zip(SPACE.items(), np.asarray(point), strict=True)
    }
    parts: dict[str, Any] = {
        "shaft_hardening": ShaftHardening(
            knee_rad=value["knee_rad"], stiffness_factor=value["factor"]
        ),
        "brake_hysteresis": BrakeHysteresis(half_width_nm=value["half_width_nm"]),
        "belt": Belt(
            stiffness_nm_per_rad=value["belt_nm_per_rad"],
            damping_nm_s_per_rad=value["belt_nm_s_per_rad"],
            pulley_inertia_kg_m2=value["pulley_share"] * value["brake_inertia_kg_m2"],
        ),
        "cogging": Cogging.sine(
            periods_per_rev=round(value["periods_per_rev"]), amplitude_nm=value["cogging_nm"]
        ),
    }
    values = {name: value[name] for name in SPACE if hasattr(PlantParams, name)}
    values |= {name: parts[name] for bit, name in enumerate(PARTS) if number >> bit & 1}
    random = np.random.default_rng([39, number])
    period_ns = round(1e9 / value["rate_hz"])
    # The emulator counts whole nanoseconds.
    times = 1e-9 * np.sort(random.integers(0, _TICKS * period_ns, 5))
    pulls = random.uniform(-1.0, 1.0, 5)
    pulls *= value["push"] * value["knob_coulomb_nm"] / np.abs(pulls).max()
    held = np.arange(_TICKS) // 7
    motor = value["motor_nm"] * random.uniform(-1.0, 1.0, _TICKS)[held]
    brake = value["brake_nm"] * random.uniform(0.0, 1.0, _TICKS)[held]
    hand = TorqueHand(torque_nm=np.column_stack([times, pulls]))
    return Case(
        f"extreme {number}", PlantParams(**values), hand,
        tuple(motor.tolist()), tuple(brake.tolist()), period_ns=period_ns,
    )  # fmt: skip


def search(number: int, tries: int) -> dict[str, Any]:
    """Look for the largest error with some parts, in so many tries; give it and its point."""
    random = np.random.default_rng([40, number])
    strategy = cma.CMAEvolutionStrategy(
        random.uniform(0.2, 0.8, len(SPACE)), 0.3,
        {"bounds": [0, 1], "popsize": _POPULATION, "seed": number + 1, "verbose": -9},
    )  # fmt: skip
    worst: dict[str, Any] = {"name": f"extreme {number}", "decided": False, "error": 0.0}
    count = dict.fromkeys(("undecided", "cut"), 0)
    for _ in range(0, tries, _POPULATION):
        points = strategy.ask()
        rows = [evaluate(extreme_case(number, point), _PIECES)[0] for point in points]
        # The emulator rounds to a share of a turn, however small the motion.
        errors = [row.get("error", math.nan) * min(row.get("range_rad", 1.0), 1.0) for row in rows]
        for row, error, point in zip(rows, errors, points, strict=True):
            count["undecided"] += not row["decided"]
            count["cut"] += row["decided"] and row["periods"] < _TICKS
            if error > worst["error"]:
                worst = {**row, "error": error, "point": point.tolist()}
        # What takes too long is neither sought nor fled from.
        found = [error for error in errors if not math.isnan(error)] or [0.0]
        costs = -np.log10(np.nan_to_num(errors, nan=float(np.median(found))) + 1e-18)
        strategy.tell(points, costs.tolist())
    return {**worst, **count, "tries": tries}
