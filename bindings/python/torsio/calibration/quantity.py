"""Findings and refusals of a calibration."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from torsio.common import checks
from torsio.errors import Error

__all__ = ["Array", "Fit", "Quantity", "Refusal"]

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Quantity:
    """A measured value.

    Attributes
    ----------
    name
        With its unit as the suffix.
    value, standard_uncertainty
        In SI units; the truth lies within 1.96 of these uncertainties in 95 of 100 cases.
    meaning
        In words.
    """

    name: str
    value: float
    standard_uncertainty: float
    meaning: str = ""

    @property
    def interval(self) -> tuple[float, float]:
        """Ends of the interval that holds the truth in 95 of 100 cases."""
        reach = 1.96 * self.standard_uncertainty
        return self.value - reach, self.value + reach

    def holds(self, value: float) -> bool:
        """Tell whether a value lies in this interval."""
        low, high = self.interval
        return low <= value <= high

    def less(self, name: str, part: Quantity, meaning: str) -> Quantity:
        """Give the rest, without a part that was measured by itself."""
        sigma = math.hypot(self.standard_uncertainty, part.standard_uncertainty)
        return Quantity(name, self.value - part.value, sigma, meaning)

    def wider(self, sigma: float) -> Quantity:
        """Give it with an independent uncertainty added."""
        return replace(self, standard_uncertainty=math.hypot(self.standard_uncertainty, sigma))


@dataclass(frozen=True, repr=False)
class Fit(checks.ShortRepr):
    """Data and model of one step, for its picture.

    Attributes
    ----------
    title, x_label, y_label
        Words for the axes.
    x, measured, fitted
        All of equal shape (n,).
    """

    title: str
    x_label: str
    y_label: str
    x: Array
    measured: Array
    fitted: Array

    @property
    def residual_rms(self) -> float:
        """Root mean square of the residuals."""
        return float(np.sqrt(np.mean((self.measured - self.fitted) ** 2)))


class Refusal(Error):
    """A step of a calibration found something that it must not go on with.

    Attributes
    ----------
    reason
        A short name, such as "reversed"; docs/reference/calibration.md lists them.
    step
        Name of the step.
    facts
        Numbers that led to it.
    """

    def __init__(self, step: str, reason: str, sentence: str, **facts: Any) -> None:
        super().__init__(f"{step}: {sentence}")
        self.step: str = step
        self.reason: str = reason
        self.facts: dict[str, Any] = facts
