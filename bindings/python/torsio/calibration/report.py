"""A calibration in words."""

from __future__ import annotations

from dataclasses import asdict

from torsio.calibration.procedure import Calibration
from torsio.calibration.quantity import Quantity
from torsio.config import ActuatorConfig

__all__ = ["changes", "lines", "number"]


def number(quantity: Quantity) -> str:
    """Give a value to the digits that its uncertainty leaves, and the uncertainty."""
    sigma = quantity.standard_uncertainty
    if sigma <= 0.0:
        return f"{quantity.value:.4g}"
    return f"{quantity.value:.4g} +- {sigma:.2g}"


def lines(calibration: Calibration) -> list[tuple[str, str, str]]:
    """Give name, value with uncertainty, and meaning of all that was found."""
    found = [(of.name, number(of), of.meaning) for of in calibration.quantities.values()]
    if calibration.periods_per_rev:
        found.append(("periods_per_rev", str(calibration.periods_per_rev), "of the cogging"))
    return found


def changes(before: ActuatorConfig, after: ActuatorConfig) -> list[tuple[str, float, float]]:
    """Give the fields that a proposal changes, with both values."""
    old, new = asdict(before), asdict(after)
    return [(name, old[name], new[name]) for name in old if old[name] != new[name]]
