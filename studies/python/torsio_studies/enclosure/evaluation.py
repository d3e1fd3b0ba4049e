"""The exact stepper beside an enclosure of the same motion."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from flint import arb

from torsio_studies.enclosure.balls import DIGITS, UndecidedError, enclose
from torsio_studies.enclosure.cases import Case, emulate
from torsio_studies.fidelity.truth import hand_torque, simulate_truth

__all__ = ["evaluate"]

Array = npt.NDArray[np.float64]

_DIGITS: Final = (100, 200, 400)  # tried in this order


def _narrowest(case: Case, torque: Any, most_pieces: int | None) -> tuple[Any, float, str]:
    """Enclose a case with more digits until the balls are small enough.

    Gives the balls with the run and its counts of events, the largest radius, or why there is none.
    """
    motor, brake = np.array(case.motor_nm), np.array(case.brake_nm)
    best, radius, why = None, math.inf, ""
    for digits in _DIGITS:
        try:
            found = enclose(
                case.plant, torque, motor, brake, period_s=1e-9 * case.period_ns, digits=digits,
                most_pieces=most_pieces,
            )  # fmt: skip
        except UndecidedError as error:
            why = str(error)
            continue
        if not found[0]:
            return best, radius, "takes too long"
        # What fewer digits have proven stays so.
        widest = float(max(ball.rad() for some in found[0] for ball in some))
        if widest < radius:
            best, radius = found, widest
        if radius < 10.0**-DIGITS:
            break
    return best, radius, why


def evaluate(case: Case, most_pieces: int | None = None) -> list[dict[str, Any]]:
    """Enclose a case; give the stepper's error, and in which event it grew.

    A case that takes more pieces of time to look at is only enclosed so far.
    """
    torque = hand_torque(case.hand)
    found, radius, why = _narrowest(case, torque, most_pieces)
    row: dict[str, Any] = {"name": case.name, "periods": len(case.motor_nm), "decided": False}
    if found is None:
        return [row | {"why": why}]
    balls, run, counts = found
    row = {**row, "periods": len(balls), "decided": True, "why": ""}
    middles = np.array([[float(ball.mid()) for ball in some] for some in balls])
    range_rad = float(np.abs(middles[:, :2]).max()) or 1.0

    def errors(values: Array) -> Array:
        return np.array([
            [float((arb(one) - ball).abs_upper()) for one, ball in zip(own, some, strict=True)]
            for own, some in zip(values.tolist(), balls, strict=True)
        ])  # fmt: skip

    each = errors(emulate(case)[: len(balls)])
    error = each[:, :2].max(axis=1)
    grown = np.diff(error, prepend=0.0) / range_rad
    losses: dict[str, float] = {}
    for growth, begin, end in zip(grown.tolist(), [0, *counts[:-1]], counts, strict=True):
        for name in set(run.events[begin:end]) or {"between events"}:
            losses[name] = max(losses.get(name, 0.0), growth)
    row |= {
        "events": len(run.events),
        "range_rad": range_rad,
        "error": float(error.max()) / range_rad,
        "digits": -math.log10(radius / range_rad) if radius else math.inf,
        "losses": losses,
    }
    if case.plant.electrics:
        row["current_error"] = float(each[:, 2].max() / np.abs(middles[:, 2]).max())
    if case.with_scipy:
        motor, brake = np.array(case.motor_nm), np.array(case.brake_nm)
        truth = simulate_truth(case.plant, torque, motor, brake, period_s=1e-9 * case.period_ns)
        angles = np.column_stack([truth.angle_rad, truth.brake_angle_rad])
        row["scipy_error"] = float(errors(angles).max()) / range_rad
    return [row]
