"""Whether a knob leaves a wall by itself once it is let go: one definition for all studies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Outcome = Literal["leaves", "held by friction", "stays"]


@dataclass(frozen=True)
class Exit:
    """Result after the knob was let go.

    Attributes
    ----------
    exit_s
        From then until the first tick from which on the knob is outside; None if it is inside at
        the end.
    stuck_torque_nm
        Torque that the wall asks for at the end; 0 outside.
    outcome
        Dry friction may hold the knob where the wall asks for no more than that, and a count of the
        encoder, that it does not see.
    """

    exit_s: float | None
    stuck_torque_nm: float
    outcome: Outcome


def measure_exit(
    time_s: Array, asked_nm: Array, *, let_go_s: float, friction_nm: float, count_nm: float
) -> Exit:
    """Measure the way out of a wall.

    Parameters
    ----------
    asked_nm
        Size of the torque that a perfect wall gives where the knob truly is, >= 0 and 0 outside
        only; shape as `time_s`.
    friction_nm
        Torque that bearings and released brake can hold together.
    count_nm
        Torque of the wall over one count of the encoder.
    """
    inside = np.flatnonzero(asked_nm > 0.0)
    after = int(inside[-1]) + 1 if len(inside) else 0
    if after < len(time_s):
        return Exit(max(0.0, float(time_s[after]) - let_go_s), 0.0, "leaves")
    stuck_nm = float(asked_nm[-1])
    held = stuck_nm <= friction_nm + count_nm
    return Exit(None, stuck_nm, "held by friction" if held else "stays")
