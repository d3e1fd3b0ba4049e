"""Torque of the brake over its command: where each stair settles, on the way up and down."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from torsio.calibration.numeric import linear, play_of
from torsio.calibration.quantity import Array, Quantity
from torsio.common import checks

__all__ = ["BrakeCurve", "BrakePoint", "curve_of"]

_SETTLED_S = 0.2  # the end of a stair
_LAG_BELIEVED = 0.2  # largest share that may still come there
# Nobody feels less than this share of the largest torque.
_STRAIGHT = 0.02


@dataclass(frozen=True)
class BrakePoint:
    """The brake's torque at one command, beyond the friction without current and without loop.

    Attributes
    ----------
    way
        Direction of the command, "up" or "down".
    follows
        False if the torque stayed where it was, within the loop.
    """

    command_nm: float
    way: str
    follows: bool
    torque_nm: float
    sigma_nm: float


@dataclass(frozen=True, repr=False)
class BrakeCurve(checks.ShortRepr):
    """All points, those on the way up and then those on the way down, and half the loop's width."""

    points: tuple[BrakePoint, ...]
    half_width_nm: float

    def with_sigmas(self, sigmas_nm: Sequence[float]) -> BrakeCurve:
        """Give it with other uncertainties, one for each point."""
        both = zip(self.points, sigmas_nm, strict=True)
        return replace(self, points=tuple(replace(one, sigma_nm=sigma) for one, sigma in both))

    def bend(self) -> tuple[float, float, float]:
        """Give where it strays furthest from a straight line through zero.

        Half the width of the loop is added on the way up and taken off on the way down. The line
        goes through zero and fits best.

        Returns
        -------
        command_nm, stray, sigma
            The latter two as shares of the largest torque.
        """
        known = [one for one in self.points if one.follows]
        command = np.array([one.command_nm for one in known])
        side = np.array([1.0 if one.way == "up" else -1.0 for one in known])
        torque = np.array([one.torque_nm for one in known]) + side * self.half_width_nm
        sigma = np.array([one.sigma_nm for one in known])
        slope = float(command @ torque / (command @ command))
        stray = torque - slope * command
        worst = int(np.argmax(np.abs(stray)))
        top = float(np.max(np.abs(torque)))
        return float(command[worst]), float(stray[worst]) / top, float(sigma[worst]) / top

    @property
    def is_straight(self) -> bool:
        """Whether it strays from a straight line by no more than can be felt, or measured."""
        _, stray, sigma = self.bend()
        return abs(stray) < max(_STRAIGHT, 3.0 * sigma)

    def in_words(self) -> str:
        """Say whether it is a straight line, and if not, where."""
        command_nm, stray, sigma = self.bend()
        if self.is_straight:
            return f"straight, within {100 * max(abs(stray), sigma):.1g} %"
        much = f"{100 * abs(stray):.2g} % of its most {'more' if stray > 0 else 'less'}"
        return f"bent: at {1e3 * command_nm:.3g} mN m {much} than a straight line"

    def as_dict(self, nm_per_a: float) -> dict[str, Any]:
        """Give it as JSON has it, with the coil's current for each command."""
        return {
            "in_words": self.in_words(),
            "points": [
                {
                    "command_nm": one.command_nm,
                    "current_a": one.command_nm / nm_per_a,
                    "way": one.way,
                    "follows": one.follows,
                    "torque_nm": one.torque_nm,
                    "standard_uncertainty_nm": one.sigma_nm,
                }
                for one in self.points
            ],
        }


def curve_of(
    time_s: Array,
    measured_nm: Array,
    fitted_nm: Array,
    stairs: tuple[Array, Array],
    *,
    gain: float,
    half_width_nm: float,
    friction: Quantity,
) -> BrakeCurve:
    """Read off where each stair settles.

    Parameters
    ----------
    time_s, measured_nm
        Torque that turns the knob through the brake; shape (n,).
    fitted_nm
        Torque of the brake alone, by the fit of the whole; shape (n,).
    stairs
        When each begins, and its command; the first is what was before.
    gain, half_width_nm
        Values of the fit, for the rest of a stair that was still to come.
    friction
        Friction of all that turns without current, less the loop's rest, by the step before: a
        brake that is no straight line would have the fit of the whole take it for another.
    """
    begins_s, commands = stairs
    loop = play_of(commands, half_width_nm, half_width_nm)
    settled = gain * loop
    ends_s = np.append(begins_s[1:], time_s[-1])
    gathered: dict[tuple[str, float], list[tuple[float, float, bool]]] = {}
    for index in range(1, len(commands)):
        # A stair that was left out may end after all that was measured.
        settling_s = max(ends_s[index] - _SETTLED_S, begins_s[index])
        chosen = (time_s > settling_s) & (time_s < ends_s[index])
        if np.count_nonzero(chosen) < 8:
            continue
        left = measured_nm[chosen] - fitted_nm[chosen]
        mean = linear(np.ones((len(left), 1)), left, lags=len(left) // 4)
        coming = settled[index] - float(np.mean(fitted_nm[chosen]))
        torque = float(mean.value[0]) + settled[index] - friction.value
        sigma = math.hypot(mean.sigma(0), _LAG_BELIEVED * coming)
        way = "up" if commands[index] > commands[index - 1] else "down"
        follows = bool(loop[index] != loop[index - 1])
        gathered.setdefault((way, float(commands[index])), []).append((torque, sigma, follows))
    points = []
    for (way, command_nm), many in gathered.items():
        torque = sum(one for one, _, _ in many) / len(many)
        # A stair that repeats is no better known: it repeats its error.
        settles = sum(one for _, one, _ in many) / len(many)
        sigma = math.hypot(settles, friction.standard_uncertainty)
        follows = all(one for _, _, one in many)
        points.append(BrakePoint(command_nm, way, follows, torque, sigma))
    points.sort(key=lambda one: (one.way != "up", one.command_nm * (1 if one.way == "up" else -1)))
    return BrakeCurve(tuple(points), gain * half_width_nm)
