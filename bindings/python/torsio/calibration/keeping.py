"""Keeps a calibration beside the knob: a file for each serial number."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from torsio.calibration.proposal import Calibration
from torsio.common import checks
from torsio.common.whole_file import keep_text, text_of, user_folder
from torsio.errors import Error

__all__ = ["Drift", "drifts", "keep", "kept", "place_of"]


def place_of(serial: str) -> Path:
    """Give the file of a serial number, whether it exists or not."""
    name = "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in serial)
    return user_folder("calibration") / f"{name or 'unnamed'}.json"


def keep(calibration: Calibration) -> Path:
    """Write the file, whole or not at all. Raises `Error` if that fails."""
    checks.kind("calibration", calibration, Calibration, "what calibrate() gave")
    path = place_of(str(calibration.conditions["serial"]))
    keep_text(path, json.dumps(calibration.as_dict(), indent=2) + "\n")
    return path


def kept(serial: str) -> dict[str, Any] | None:
    """Give what was kept for a knob, as `Calibration.as_dict` has it; None if nothing was."""
    path = place_of(checks.text("serial", serial))
    try:
        found = json.loads(text_of(path))
        if not isinstance(found["quantities"], dict) or not isinstance(found["conditions"], dict):
            raise ValueError
        for quantity in found["quantities"].values():
            _numbers(quantity)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, OverflowError, RecursionError):
        raise Error(f"{path} cannot be read: move it away, and calibrate again") from None
    return dict(found)


def _numbers(quantity: dict[str, Any]) -> tuple[float, float]:
    return float(quantity["value"]), float(quantity["standard_uncertainty"])


@dataclass(frozen=True)
class Drift:
    """A quantity that has changed."""

    name: str
    before: float
    now: float
    sigmas: float


def drifts(before: dict[str, Any], now: Calibration) -> list[Drift]:
    """Give what has changed: by three standard uncertainties, and by a twentieth of itself."""
    checks.kind("before", before, dict, "what kept() gave")
    checks.kind("now", now, Calibration, "what calibrate() gave")
    changed = []
    for name, quantity in now.quantities.items():
        if name not in before["quantities"]:
            continue
        old, old_uncertainty = _numbers(before["quantities"][name])
        sigma = math.hypot(quantity.standard_uncertainty, old_uncertainty)
        difference = abs(quantity.value - old)
        if difference > max(3.0 * sigma, 0.05 * abs(old)):
            changed.append(Drift(name, old, quantity.value, difference / max(sigma, 1e-30)))
    return changed
