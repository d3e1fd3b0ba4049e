"""Hands that hold an emulated knob.

A profile is a piecewise-linear function of time: knots ``(time_s, value)`` as any iterable of pairs
or an array of shape (n, 2), or one number for a constant. The first value holds before the first
knot, the last one after the last. Time 0 is when the hand takes over.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import KW_ONLY, dataclass
from numbers import Real
from typing import TypeAlias

from torsio import checks
from torsio.errors import InvalidArgument

__all__ = ["Hand", "ImpedanceHand", "NoHand", "PrescribedMotion", "Profile", "TorqueHand"]

Profile: TypeAlias = float | Iterable[Sequence[float]]
"""What the fields of hands take; they keep it as a tuple of pairs."""


def _knots(name: str, profile: Profile) -> tuple[tuple[float, float], ...]:
    if isinstance(profile, Real):
        return ((0.0, float(profile)),)
    knots = []
    for knot in checks.each(name, profile, "a number or knots (time_s, value)"):
        values = checks.numbers(f"{name}, a profile's knot,", knot)
        if len(values) != 2:
            raise InvalidArgument(f"{name}: a profile's knot must be (time_s, value), is {knot!r}")
        knots.append((values[0], values[1]))
    return tuple(knots)


class Hand:
    """Base class of all hands."""

    __slots__ = ()


@dataclass(frozen=True)
class NoHand(Hand):
    """Nobody touches the knob."""


@dataclass(frozen=True)
class TorqueHand(Hand):
    """A torque on the knob that does not depend on its motion, such as a weight on a string.

    Attributes
    ----------
    torque_nm
        Profile; two knots at the same time make a jump.
    """

    _: KW_ONLY
    torque_nm: Profile

    def __post_init__(self) -> None:
        """Keep the profile as a tuple of pairs."""
        object.__setattr__(self, "torque_nm", _knots("torque_nm", self.torque_nm))


@dataclass(frozen=True)
class ImpedanceHand(Hand):
    """A hand that holds the knob and means to move it along a path.

    ``torque = stiffness (intended - angle) + damping (intended' - speed)``, with the hand's own
    inertia fixed to the knob.

    Attributes
    ----------
    intended_angle_rad
        Profile without jumps.
    """

    _: KW_ONLY
    intended_angle_rad: Profile
    stiffness_nm_per_rad: float
    damping_nm_s_per_rad: float = 0.0
    inertia_kg_m2: float = 0.0

    def __post_init__(self) -> None:
        """Keep the profile as a tuple of pairs."""
        object.__setattr__(
            self, "intended_angle_rad", _knots("intended_angle_rad", self.intended_angle_rad)
        )


@dataclass(frozen=True)
class PrescribedMotion(Hand):
    """The knob follows the path whatever torque that takes.

    Attributes
    ----------
    angle_rad
        Profile without jumps.
    """

    _: KW_ONLY
    angle_rad: Profile

    def __post_init__(self) -> None:
        """Keep the profile as a tuple of pairs."""
        object.__setattr__(self, "angle_rad", _knots("angle_rad", self.angle_rad))
