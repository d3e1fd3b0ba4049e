"""A planar flexure between hub and rim: its shape, and how it bends by rods and by closed form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

_CLOSE = 1e-5  # of the rods


def rotation(angle_rad: float) -> Any:
    """Give the matrix that turns points by an angle."""
    cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cosine, -sine], [sine, cosine]])


@dataclass(frozen=True)
class Flexure:
    """Arms of one thickness from a stiff hub to a stiff rim, printed flat.

    Arm k begins at the angle 2 pi k / arms. At the share s of the way out its centre line has the
    radius hub + s (rim - hub), and is turned by wrap s + swing sin(2 pi waves s) sin^2(pi s).
    Without both it is a straight spoke; with a wrap alone a spiral; with a swing alone a meander,
    which leaves hub and rim at right angles. Its odd arms are mirrored: both ways are alike.
    """

    arms: int = 6  # even for a meander
    hub_radius_m: float = 6e-3  # the arms are clamped there; 0 < hub < rim
    rim_radius_m: float = 18e-3
    thickness_m: float = 0.605e-3  # thickness of an arm, in the plane; > 0
    width_m: float = 8e-3  # width of an arm, along the axis; > 0
    wrap_rad: float = 0.0  # angle that a spiral's arm turns on its way out
    swing_rad: float = 0.0  # amplitude and number of a meander's waves
    waves: int = 0

    def __post_init__(self) -> None:
        """Refuse what is no flexure."""
        if not 0 < self.hub_radius_m < self.rim_radius_m:
            raise ValueError("hub_radius_m must be more than 0 and less than rim_radius_m")
        if self.thickness_m <= 0 or self.width_m <= 0 or self.arms < 2:
            raise ValueError("thickness_m and width_m must be more than 0, and arms 2 or more")
        if self.swing_rad and (self.arms % 2 or self.waves < 1):
            raise ValueError("a meander needs an even number of arms, and a wave or more")

    @property
    def family(self) -> str:
        """Name the shape: spoke, spiral or meander."""
        return "meander" if self.swing_rad else "spiral" if self.wrap_rad else "spoke"

    @property
    def length_m(self) -> float:
        """Return what a straight arm measures from hub to rim."""
        return self.rim_radius_m - self.hub_radius_m

    def centre_line(self, points: int, *, mirrored: bool = False) -> Any:
        """Give points of arm 0 from hub to rim at equal steps of radius; shape (points, 2)."""
        share = np.linspace(0.0, 1.0, points)
        radius = self.hub_radius_m + share * self.length_m
        window = np.sin(np.pi * share) ** 2
        swing = self.swing_rad * np.sin(2 * np.pi * self.waves * share) * window
        turn = self.wrap_rad * share + swing
        turn = -turn if mirrored else turn
        return np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=1)

    @property
    def sides(self) -> tuple[bool, ...]:
        """Return whether arms are mirrored: of arm 0, and of arm 1 if it differs."""
        return (False, True) if self.family == "meander" else (False,)

    def grid(self, along: int, across: int, *, mirrored: bool = False) -> Any:
        """Give points all over arm 0, in m; shape (along + 1, across + 1, 2).

        The ends are cut square to the arm, as a beam is clamped.
        """
        line = self.centre_line(along + 1, mirrored=mirrored)
        fine = self.centre_line(20 * along + 1, mirrored=mirrored)
        slope = np.gradient(fine, axis=0)[::20]
        slope /= np.linalg.norm(slope, axis=1)[:, None]
        normal = np.stack([-slope[:, 1], slope[:, 0]], axis=1)
        share = np.linspace(-0.5, 0.5, across + 1) * self.thickness_m
        return line[:, None, :] + share[None, :, None] * normal[:, None, :]

    def outlines(self, pieces: int, into_m: float = 0.0) -> list[Any]:
        """Give each arm's outline, which reaches so far into hub and rim; shape (points, 2)."""
        found = []
        for arm in range(self.arms):
            nodes = self.grid(pieces, 1, mirrored=self.sides[arm % len(self.sides)])
            for end, inward in ((0, 1), (-1, -2)):
                along = nodes[end].mean(axis=0) - nodes[inward].mean(axis=0)
                nodes[end] += into_m * along / np.linalg.norm(along)
            edge = np.concatenate([nodes[:, 0], nodes[::-1, 1]])
            found.append(edge @ rotation(-2 * math.pi * arm / self.arms))
        return found

    def gap_m(self, points: int = 200) -> float:
        """Return the narrowest gap between neighbouring arms, and of an arm to itself."""
        first, second = (self.centre_line(points, mirrored=self.sides[k]) for k in (0, -1))
        turn = rotation(-2 * math.pi / self.arms)
        # Hub and rim join neighbours, so the ends do not count.
        both = np.concatenate([second @ turn, (second @ turn.T)])[5:-5]
        apart = np.linalg.norm(first[5:-5, None, :] - both[None, :, :], axis=2)
        return float(apart.min()) - self.thickness_m

    def bend_radius_m(self, points: int = 400) -> float:
        """Return the smallest radius that an arm is curved with; infinite for straight spokes."""
        first = np.gradient(self.centre_line(points), axis=0)
        second = np.gradient(first, axis=0)
        turn = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
        most = float(np.max((turn / np.linalg.norm(first, axis=1) ** 3)[3:-3]))
        return 1 / most if most > 1e-6 else math.inf


REFERENCE = Flexure(6, 7e-3, 25e-3, thickness_m=0.9e-3, width_m=6e-3, swing_rad=0.34, waves=1)
SHAPES = {
    "spoke": (_straight := replace(REFERENCE, swing_rad=0.0, waves=0)),
    "spiral": replace(_straight, wrap_rad=2.0),
    "meander": REFERENCE,
}


class ClosedForm(NamedTuple):
    """Stiffness of straight spokes at small twists, and largest strain over twist, at the hub."""

    stiffness_nm_per_rad: float
    strain_per_rad: float


def closed_form(flexure: Flexure, modulus_pa: float) -> ClosedForm:
    """Solve a spoke clamped at both ends whose far end turns about the hub's centre.

    The far end moves across by w = (r + L) theta and turns by theta. A clamped beam answers with
    the shear force V = 12 EI w / L^3 - 6 EI theta / L^2 and the moment
    M = 4 EI theta / L - 6 EI w / L^2 at the rim. Their torque about the centre is
    V (r + L) + M = (4 EI / L) (1 + 3 r / L + 3 r^2 / L^2) theta, for each spoke. At the hub the
    moment is 2 EI theta / L - 6 EI w / L^2, so the strain is t theta (2 L + 3 r) / L^2.
    Raises `ValueError` if the arms are no straight spokes.
    """
    if flexure.family != "spoke":
        raise ValueError("only straight spokes have a closed form")
    hub, length, thickness = flexure.hub_radius_m, flexure.length_m, flexure.thickness_m
    bending = modulus_pa * flexure.width_m * thickness**3 / 12
    q = hub / length
    return ClosedForm(
        flexure.arms * 4 * bending / length * (1 + 3 * q + 3 * q**2),
        thickness * (2 * length + 3 * hub) / length**2,
    )


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


def _bend_arm(line: Any, thickness: float, twists: Any) -> tuple[Any, Any]:
    """Turn an arm's outer end rigidly about the centre; give torque and strain at each twist.

    Lengths are over any length, forces for E I = 1. All along the arm the force is the same, and so
    is the torque about the centre: these three are found with the place and turn of each section.
    """
    # Every command imports this module, and few need SciPy, which takes a quarter of a second.
    from scipy.integrate import solve_bvp
    from scipy.interpolate import CubicSpline

    share = np.linspace(0.0, 1.0, len(line))
    slope = CubicSpline(share, line).derivative()

    def section(at: Any, now: Any, held: Any) -> tuple[Any, Any, Any]:
        """Give how each section goes on, how much it is stretched, and its moment."""
        x, y, turn = now
        dx, dy = slope(at).T
        way = np.stack(
            [np.cos(turn) * dx - np.sin(turn) * dy, np.sin(turn) * dx + np.cos(turn) * dy]
        )
        stretch = thickness**2 / 12 * (held[:2] @ way) / np.hypot(dx, dy)
        return way, stretch, held[2] - x * held[1] + y * held[0]

    def change(at: Any, now: Any, held: Any) -> Any:
        way, stretch, moment = section(at, now, held)
        return np.vstack([(1 + stretch) * way, moment * np.linalg.norm(way, axis=0)])

    now: Any = np.vstack([line.T, np.zeros_like(share)])
    held: Any = np.zeros(3)
    torques, strains = [], []
    for twist in twists:
        ends = np.append(line[0], 0.0), np.append(rotation(twist) @ line[-1], twist)

        def missing(first: Any, last: Any, _: Any, ends: Any = ends) -> Any:
            return np.concatenate([first - ends[0], last - ends[1]])

        found = solve_bvp(change, missing, share, now, p=held, tol=_CLOSE)
        if not found.success:
            raise ArithmeticError(f"the arm finds no rest at a twist of {twist:g} rad")
        now, held = found.sol(share), found.p
        _, stretch, moment = section(share, now, held)
        torques.append(held[2])
        strains.append(np.max(np.abs(stretch) + np.abs(moment) * thickness / 2))
    return np.array(torques), np.array(strains)


def bend(
    flexure: Flexure, modulus_pa: float, twists_rad: Sequence[float], *, pieces: int = 60
) -> Bent:
    """Twist a flexure; the twists must grow from near 0 so that each helps to find the next.

    A mirrored arm is the arm itself turned the other way. Raises `ArithmeticError` if an arm finds
    no rest.
    """
    size, twists = flexure.length_m, np.asarray(twists_rad, dtype=float)
    bending = modulus_pa * flexure.width_m * flexure.thickness_m**3 / 12
    line, thickness = flexure.centre_line(pieces + 1) / size, flexure.thickness_m / size
    signs = [-1 if mirrored else 1 for mirrored in flexure.sides]
    torques, strains = zip(
        *(_bend_arm(line, thickness, sign * twists) for sign in signs), strict=True
    )
    torque = sum(sign * each for sign, each in zip(signs, torques, strict=True)) / len(signs)
    return Bent(twists, flexure.arms * bending / size * torque, np.max(strains, axis=0))
