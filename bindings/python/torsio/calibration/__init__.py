"""Measuring a knob: its values, their uncertainties, and its faults."""

from __future__ import annotations

from torsio.calibration.brake_curve import BrakeCurve, BrakePoint
from torsio.calibration.circuit import ELECTRIC_STEPS
from torsio.calibration.cogging import Cogging
from torsio.calibration.keeping import Drift, drifts, keep, kept
from torsio.calibration.procedure import STEPS, calibrate
from torsio.calibration.proposal import Calibration, apply
from torsio.calibration.quantity import Fit, Quantity, Refusal

__all__ = [
    "ELECTRIC_STEPS",
    "STEPS",
    "BrakeCurve",
    "BrakePoint",
    "Calibration",
    "Cogging",
    "Drift",
    "Fit",
    "Quantity",
    "Refusal",
    "apply",
    "calibrate",
    "drifts",
    "keep",
    "kept",
]
