"""The paper's critical torque: the largest that does not saturate the motor."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from torsio.closed_loop import LoopOptions, simulate_many
from torsio.common import checks
from torsio.printed.config import ControlConfig
from torsio.printed.hands import PrescribedMotion
from torsio.printed.plant import PlantParams
from torsio.printed.scenes import Wall
from torsio_studies.paper.runs import BRAKE_NM, MOTOR_NM, SHAFT_NM_PER_RAD, Array


def critical_torque(
    stiffness: float,
    beta: float,
    *,
    shaft: float = SHAFT_NM_PER_RAD,
    motor: float = MOTOR_NM,
    brake: float = BRAKE_NM,
) -> float:
    """Largest torque that does not saturate the motor (docs/explanation/theory.md).

    Raises
    ------
    InvalidArgument
        If the shaft's stiffness is not positive, or anything else is outside its range.
    """
    checks.positive("shaft", shaft)
    checks.number("stiffness", stiffness, 0.0, sys.float_info.max)
    checks.number("beta", beta, 0.0, 1.0)
    if stiffness <= shaft:
        rest = 1.0 - beta * stiffness / shaft
        critical = motor / rest if rest > 0 else math.inf
        if beta * critical > brake:
            critical = motor + stiffness * brake / shaft
    elif beta * stiffness <= shaft:
        critical = motor / (1.0 - beta) if beta < 1 else math.inf
    else:
        critical = motor * stiffness / (stiffness - shaft)
    return min(critical, motor + brake)


def printed_critical_torque(stiffness_ratio: float, beta: float) -> float:
    """Give the paper's (8) and (11) as they are printed, without the brake's limit."""
    if stiffness_ratio <= 1:
        rest = 1.0 - beta * stiffness_ratio
    else:
        rest = (stiffness_ratio - min(1.0, beta * stiffness_ratio)) / stiffness_ratio
    return MOTOR_NM / rest if rest != 0 else math.inf


IDEAL_PLANT = PlantParams(
    knob_coulomb_nm=0.0,
    knob_viscous_nm_s_per_rad=0.0,
    brake_drag_nm=0.0,
    brake_viscous_nm_s_per_rad=0.0,
    brake_inertia_kg_m2=1e-7,
    brake_time_constant_s=0.0,
    motor_time_constant_s=0.0,
    counts_per_rev=1 << 24,
)
"""No lag, no friction, no drag, and an encoder so fine that it does not round."""


def ideal_push(stiffness: float, beta: float, peak_nm: float) -> LoopOptions:
    """Slide into a wall until it asks for the peak torque, and out, on the ideal plant."""
    checks.positive("stiffness", stiffness)
    surface, deepest = 0.01, 0.01 + peak_nm / stiffness
    return LoopOptions(
        scene=Wall(angle_rad=surface, stiffness_nm_per_rad=stiffness),
        hand=PrescribedMotion(
            angle_rad=[(0, 0), (0.05, surface), (1.05, deepest), (2.05, surface)]
        ),
        plant=IDEAL_PLANT,
        actuator=replace(IDEAL_PLANT.matching_config(), brake_torque_min_nm=0.0),
        control=ControlConfig(law="paper", beta=beta),
    )


IDEAL_PUSH_S = 2.1


def measured_critical_torque(
    cases: Sequence[tuple[float, float]],
    *,
    halvings: int = 12,
    on_progress: Callable[[int], None] = lambda _: None,
) -> Array:
    """Find, for pairs (stiffness, beta), the largest peak at which the motor never saturates.

    Returns
    -------
    ndarray
        Torques in N m, shape (n_cases,), to within 0.28 N m / 2**halvings.
    """
    low, high = np.full(len(cases), 0.02), np.full(len(cases), 0.30)
    for done in range(halvings):
        middle = 0.5 * (low + high)
        pushes = [ideal_push(k, beta, peak) for (k, beta), peak in zip(cases, middle, strict=True)]
        runs = simulate_many(pushes, duration_s=IDEAL_PUSH_S)
        saturates = np.array([bool(rows["motor_saturated"].any()) for rows in runs])
        high = np.where(saturates, middle, high)
        low = np.where(saturates, low, middle)
        on_progress(done + 1)
    return np.asarray(0.5 * (low + high))
