"""The printed parts of the reference knob as solids, by build123d; lengths here are in metres.

Coordinates: the axis of motor and knob is z; z = 0 is the top of the plate, on which all stands.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from torsio_hardware.flexure import Flexure
from torsio_hardware.plane import grid

BORE_M = 3.0e-3  # radius, of the motor's shaft
RIM_M = 29e-3
_SCREW_CIRCLE_M, _SCREW_M = 27e-3, 1.1e-3
SCREWS = tuple(
    (
        _SCREW_M,
        _SCREW_CIRCLE_M * math.cos(math.pi * (2 * n + 1) / 6),
        _SCREW_CIRCLE_M * math.sin(math.pi * (2 * n + 1) / 6),
    )
    for n in range(6)
)
_MM = 1e3
_INTO_M = 0.3e-3  # so far an arm reaches into hub and rim, so that they are one


def spring(flexure: Flexure) -> Any:
    """Give the spring as one solid, in mm, its lower face at z = 0.

    Raises
    ------
    ModuleNotFoundError
        Without build123d.
    """
    from build123d import Circle, Face, Polyline, Pos, Rot, extrude, make_face

    def disc(radius_m: float) -> Any:
        return Circle(_MM * radius_m)

    flat = disc(RIM_M) - disc(flexure.rim_radius_m) + disc(flexure.hub_radius_m)
    for arm in range(flexure.arms):
        nodes = grid(flexure, 60, 1, mirrored=flexure.is_mirrored(arm))
        for end, inward in ((0, 1), (-1, -2)):
            along = nodes[end].mean(axis=0) - nodes[inward].mean(axis=0)
            nodes[end] += _INTO_M * along / np.linalg.norm(along)
        edge = _MM * np.concatenate([nodes[:, 0], nodes[::-1, 1]])
        face: Face = make_face(Polyline(*map(tuple, edge), close=True))
        flat += Rot(0, 0, 360 * arm / flexure.arms) * face
    flat -= disc(BORE_M)
    for radius, x, y in SCREWS:
        flat -= Pos(_MM * x, _MM * y) * disc(radius)
    return extrude(flat, _MM * flexure.width_m)
