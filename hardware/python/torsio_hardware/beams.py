"""An arm as a chain of beams that may turn far: quick enough to search with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from torsio_hardware.flexure import Flexure, rotation

_STEPS = 40
_SETTLED = 1e-6  # of the largest force


@dataclass(frozen=True)
class Bent:
    """A flexure at some twists."""

    twist_rad: Any
    torque_nm: Any  # of the whole flexure, both ways alike for spokes and meanders
    strain: Any  # largest of all arms at each twist: stretch and bending together

    @property
    def stiffness_nm_per_rad(self) -> Any:
        """Return the secant stiffness at each twist."""
        return self.torque_nm / self.twist_rad


def _gather(line: Any, moved: Any, stretch: Any, bending: Any) -> tuple[Any, Any, Any]:
    """Give the forces at all nodes, their change, and what bends and stretches each piece."""
    pieces = len(line) - 1
    before = np.diff(line, axis=0)
    length0 = np.hypot(before[:, 0], before[:, 1])
    now = np.diff(line + moved[:, :2], axis=0)
    length = np.hypot(now[:, 0], now[:, 1])
    turned = np.arctan2(
        before[:, 0] * now[:, 1] - before[:, 1] * now[:, 0], np.sum(before * now, axis=1)
    )
    ends = [moved[:-1, 2] - turned, moved[1:, 2] - turned]
    normal = stretch / length0 * (length - length0)
    moments = [2 * bending / length0 * (2 * ends[k] + ends[1 - k]) for k in (0, 1)]
    cosine, sine, none = now[:, 0] / length, now[:, 1] / length, np.zeros(pieces)
    along = np.stack([-cosine, -sine, none, cosine, sine, none], axis=1)
    across = np.stack([sine, -cosine, none, -sine, cosine, none], axis=1)
    turns = [np.eye(6)[at] - across / length[:, None] for at in (2, 5)]

    def outer(one: Any, other: Any, factor: Any) -> Any:
        return factor[:, None, None] * one[:, :, None] * other[:, None, :]

    force = normal[:, None] * along + sum(
        m[:, None] * t for m, t in zip(moments, turns, strict=True)
    )
    change = outer(along, along, stretch / length0) + outer(across, across, normal / length)
    for k in (0, 1):
        change += outer(turns[k], turns[k], 4 * bending / length0)
        change += outer(turns[k], turns[1 - k], 2 * bending / length0)
    swing = sum(moments) / length**2
    change += outer(along, across, swing) + outer(across, along, swing)
    size = 3 * (pieces + 1)
    forces, changes = np.zeros(size), np.zeros((size, size))
    for piece in range(pieces):
        at = slice(3 * piece, 3 * piece + 6)
        forces[at] += force[piece]
        changes[at, at] += change[piece]
    strained = np.abs(normal / stretch)
    bent = np.maximum(np.abs(moments[0]), np.abs(moments[1])) / bending
    return forces, changes, (strained, bent)


def _bend_arm(
    line: Any, thickness_m: float, width_m: float, modulus_pa: float, twists: Sequence[float]
) -> tuple[list[float], list[float]]:
    """Turn an arm's outer end rigidly about the centre; give torque and strain at each twist."""
    stretch = modulus_pa * width_m * thickness_m
    bending = stretch * thickness_m**2 / 12
    moved = np.zeros((len(line), 3))
    inner, outer = slice(3, 3 * len(line) - 3), slice(3 * len(line) - 3, None)
    torques, strains = [], []
    for twist in twists:
        goal = np.append(rotation(twist) @ line[-1] - line[-1], twist)
        for attempt in range(_STEPS):
            forces, changes, parts = _gather(line, moved, stretch, bending)
            missing = -forces[inner]
            if attempt and np.abs(missing).max() < _SETTLED * np.abs(forces).max():
                break
            if not attempt:
                missing = missing - changes[inner, outer] @ (goal - moved[-1])
                moved[-1] = goal
            moved.reshape(-1)[inner] += np.linalg.solve(changes[inner, inner], missing)
        else:
            raise ArithmeticError(f"the arm finds no rest at a twist of {twist:g} rad")
        x, y = line[-1] + moved[-1, :2]
        torques.append(x * forces[-2] - y * forces[-3] + forces[-1])
        strains.append(float(np.max(parts[0] + parts[1] * thickness_m / 2)))
    return torques, strains


def bend(
    flexure: Flexure, modulus_pa: float, twists_rad: Sequence[float], *, pieces: int = 60
) -> Bent:
    """Twist a flexure; the twists must grow from near 0 so that each helps to find the next.

    A mirrored arm is the arm itself turned the other way. Raises `ArithmeticError` if an arm finds
    no rest.
    """
    line = flexure.centre_line(pieces + 1)
    twists = np.asarray(twists_rad, dtype=float)
    torques, strains = [], []
    for mirrored in flexure.sides:
        sign = -1 if mirrored else 1
        torque, strain = _bend_arm(
            line, flexure.thickness_m, flexure.width_m, modulus_pa, list(sign * twists)
        )
        torques.append(sign * np.array(torque))
        strains.append(strain)
    return Bent(twists, flexure.arms * np.mean(torques, axis=0), np.max(strains, axis=0))
