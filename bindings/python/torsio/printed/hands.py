"""Hands that hold an emulated knob.

A profile is a piecewise-linear function of time: knots ``(time_s, value)`` as any iterable of pairs
or an array of shape (n, 2), or one number for a constant. The first value holds before the first
knot, the last one after the last. Time 0 is when the hand takes over.
"""

# Printed from the field lists in emulator/definition/ by `./dev generate`;
# change those instead.

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TypeAlias

from torsio.common import checks

__all__ = [
    "FeedbackHand",
    "Hand",
    "HandFunction",
    "ImpedanceHand",
    "NoHand",
    "PrescribedMotion",
    "Profile",
    "TorqueHand",
]

Profile: TypeAlias = float | Iterable[Sequence[float]]
"""Values for the fields of hands, which keep them as a tuple of pairs."""

HandFunction: TypeAlias = Callable[[float, float, float], float]
"""Time since the hand took over in s, the knob's true angle in rad and its speed in rad/s, to the
torque on the knob in N m, -100 to 100.
"""


class Hand(checks.ByName):
    """Base class of all hands."""

    __slots__ = ()


@dataclass(frozen=True, repr=False)
class NoHand(Hand):
    """Nobody touches the knob."""


@dataclass(frozen=True, repr=False)
class TorqueHand(Hand):
    """A torque on the knob that does not depend on its motion, such as a weight on a string.

    Attributes
    ----------
    torque_nm
        Two knots at the same time make a jump.
    """

    _: KW_ONLY
    torque_nm: Profile

    def __post_init__(self) -> None:
        """Ask for the right kinds, and keep sequences so that they compare by value."""
        object.__setattr__(self, "torque_nm", checks.knots("torque_nm", self.torque_nm))


@dataclass(frozen=True, repr=False)
class ImpedanceHand(Hand):
    """A hand that holds the knob and means to move it along a path.

    `torque = stiffness (intended - angle) + damping (intended' - speed)`, with the hand's own
    inertia fixed to the knob.

    Attributes
    ----------
    inertia_kg_m2
        Of the hand; 0 to 10.
    stiffness_nm_per_rad
        Of the hand; 0 to 1e6.
    damping_nm_s_per_rad
        Of the hand; 0 to 1000.
    intended_angle_rad
        Without jumps.
    """

    _: KW_ONLY
    stiffness_nm_per_rad: float
    intended_angle_rad: Profile
    inertia_kg_m2: float = 0.0
    damping_nm_s_per_rad: float = 0.0

    def __post_init__(self) -> None:
        """Ask for the right kinds, and keep sequences so that they compare by value."""
        object.__setattr__(
            self, "intended_angle_rad", checks.knots("intended_angle_rad", self.intended_angle_rad)
        )


@dataclass(frozen=True, repr=False)
class PrescribedMotion(Hand):
    """The knob follows the path whatever torque that takes.

    Attributes
    ----------
    angle_rad
        Without jumps.
    """

    _: KW_ONLY
    angle_rad: Profile

    def __post_init__(self) -> None:
        """Ask for the right kinds, and keep sequences so that they compare by value."""
        object.__setattr__(self, "angle_rad", checks.knots("angle_rad", self.angle_rad))


@dataclass(frozen=True, repr=False)
class FeedbackHand(Hand):
    """A hand whose torque is a function of the knob's motion.

    Such as a controller or a person's model.

    The function is asked when the hand takes over and then once a period. It must not use the knob
    that it holds.

    Attributes
    ----------
    torque_nm
        The torque on the knob; held until it is asked again.
    period_s
        From one asking to the next; 1e-5 to 1.
    """

    torque_nm: HandFunction
    _: KW_ONLY
    period_s: float = 0.001

    def __post_init__(self) -> None:
        """Ask for the right kinds, and keep sequences so that they compare by value."""
        checks.function("torque_nm", self.torque_nm)
