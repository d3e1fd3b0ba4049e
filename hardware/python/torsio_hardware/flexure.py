"""A planar flexure between hub and rim: its shape, and the closed form of straight spokes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np


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
