"""Errors of a knob in just noticeable differences (JNDs) of a finger."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from torsio.common import checks

__all__ = [
    "MEANING",
    "STIFFNESS_JND_SHARE",
    "TORQUE_JND_NM",
    "TORQUE_JND_SHARE",
    "VIBRATION_NM",
    "count_step_nm",
    "counts_for",
    "jnds_of",
    "smooth_stiffness_nm_per_rad",
    "stiffness_jnds",
    "text",
    "torque_jnds",
    "vibration_nm",
    "wall_jnds",
]

TORQUE_JND_SHARE: Final = 0.127
"""JND of a knob's torque, at 60 mN m (Jandura & Srinivasan 1994, on a magnetic particle brake)."""

TORQUE_JND_NM: Final = TORQUE_JND_SHARE * 60e-3
"""The same as a torque, 7.6 mN m: in it every error of a torque is counted, whatever the torque."""

STIFFNESS_JND_SHARE: Final = 0.23
"""JND of a spring's stiffness."""

VIBRATION_NM: Final = 1e-3
"""Aim for a motor at rest: friction then keeps the knob still; see `vibration_nm`."""

_AVERAGED_S: Final = 0.05  # a period at 20 Hz: slower changes are no vibration

MEANING: Final = (
    f"the least difference that most fingers tell, {1e3 * TORQUE_JND_NM:.1f} mN·m of torque or "
    f"{100 * STIFFNESS_JND_SHARE:.0f} % of stiffness"
)
"""For who has never heard of a JND."""


def torque_jnds(error_nm: float) -> float:
    """Give an error of torque in JNDs; below 1 most hands do not feel it."""
    return abs(error_nm) / TORQUE_JND_NM


def vibration_nm(torque_nm: npt.NDArray[Any], rate_hz: float) -> npt.NDArray[np.float64]:
    """Give the root of the mean square of a torque above 20 Hz.

    Parameters
    ----------
    torque_nm
        Samples along the first axis, for 0.05 s at least; a rest of less than 0.05 s is left out.
    rate_hz
        Rate of the samples; 40 and more.

    Returns
    -------
    In N m, of the shape of one sample.
    """
    each = round(_AVERAGED_S * rate_hz)
    whole = len(torque_nm) // each * each
    blocks = np.reshape(torque_nm[:whole], (-1, each, *torque_nm.shape[1:]))
    around = blocks - blocks.mean(axis=1, keepdims=True)
    return np.asarray(np.sqrt(np.mean(np.square(around), axis=(0, 1))), dtype=np.float64)


def stiffness_jnds(error_share: float) -> float:
    """Give an error of stiffness, as a share of it, in JNDs."""
    return abs(error_share) / STIFFNESS_JND_SHARE


def jnds_of(name: str, value: float, error: float) -> float | None:
    """Give the error of a quantity in JNDs, by the unit in its name.

    Returns
    -------
    None where no JND is known, or if a stiffness of 0 has an error.
    """
    if name.endswith("_nm"):
        return torque_jnds(error)
    if name.endswith("stiffness_nm_per_rad") and value != 0.0:
        return stiffness_jnds(error / value)
    if name == "brake_gain":
        # A share of every torque that the brake gives, as the JND is one.
        return abs(error) / TORQUE_JND_SHARE
    return None


def wall_jnds(
    *, peak_nm: float, tracking_in: float, tracking_out: float, torque_gap_nm: float
) -> dict[str, float]:
    """Give the errors of a visit to a wall in JNDs.

    Parameters
    ----------
    peak_nm
        Peak of the wall's torque.
    tracking_in, tracking_out
        As shares of it.
    """
    return {
        "tracking_in": torque_jnds(tracking_in * peak_nm),
        "tracking_out": torque_jnds(tracking_out * peak_nm),
        "torque_gap": torque_jnds(torque_gap_nm),
    }


def count_step_nm(stiffness_nm_per_rad: float, counts_per_rev: int) -> float:
    """Give the jump of torque from one count of the encoder to the next, in a wall of 0 to 1e6."""
    checks.number("stiffness_nm_per_rad", stiffness_nm_per_rad, 0.0, 1e6)
    checks.positive("counts_per_rev", counts_per_rev)
    return stiffness_nm_per_rad * 2.0 * math.pi / counts_per_rev


def smooth_stiffness_nm_per_rad(counts_per_rev: int) -> float:
    """Give the stiffest wall in which one count of the encoder is no more than one JND."""
    return TORQUE_JND_NM / count_step_nm(1.0, counts_per_rev)


def counts_for(stiffness_nm_per_rad: float, *, jnds: float = 1.0) -> int:
    """Give the least counts per turn that a wall needs.

    Parameters
    ----------
    stiffness_nm_per_rad
        Stiffness of the wall; 0 to 1e6.
    jnds
        Largest torque of one count; > 0.
    """
    checks.positive("jnds", jnds)
    return max(math.ceil(count_step_nm(stiffness_nm_per_rad, 1) / (jnds * TORQUE_JND_NM)), 1)


def text(jnds: float) -> str:
    """Give a number of JNDs with as many digits as they mean something."""
    return f"{jnds:.0f} JND" if jnds >= 9.95 else f"{jnds:.2g} JND"
