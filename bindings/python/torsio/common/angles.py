"""Angles in degrees, for those who think in them."""

from __future__ import annotations

import math

from torsio.common import checks

__all__ = ["deg"]


def deg(degrees: float) -> float:
    """Give an angle of so many degrees in radians: ``torsio.Wall(angle_rad=torsio.deg(30), ...)``.

    Raises
    ------
    TypeError
        If it is no number.
    """
    return math.radians(checks.number("degrees", degrees))
