"""Dimensions that parts share, in mm; needs nothing that draws."""

from __future__ import annotations

import math

BORE_MM = 3.0  # radius, of the motor's shaft
SLEEVE_MM = 5.0  # radius, inside the bearings
RIM_MM = 29.0  # radius, of the spring: the knob covers it
TEETH = 50  # of both pulleys, pitch 2 mm
PULLEY_MM = TEETH * 2.0 / math.tau  # radius, of the belt's cords
LAND_MM = PULLEY_MM - 0.254  # radius between the grooves of both pulleys, for a belt GT2
BELT_MM = 0.63  # of the belt's back; its teeth are in the grooves
BELT_LENGTH_MM = 300.0
CENTRES_MM = (BELT_LENGTH_MM - TEETH * 2.0) / 2
_SCREW_CIRCLE_MM, _SCREW_MM = 27.0, 1.1
SCREWS_MM = tuple(
    (
        _SCREW_MM,
        _SCREW_CIRCLE_MM * math.cos(math.pi * (2 * n + 1) / 6),
        _SCREW_CIRCLE_MM * math.sin(math.pi * (2 * n + 1) / 6),
    )
    for n in range(6)
)
