"""A picture of a knob as pixels: the dial, and the torques on it as bars. Needs NumPy alone."""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

__all__ = ["BARS", "FULL_NM", "draw"]

BARS: Final = {
    "motor_torque_nm": (0, 114, 178),
    "spring_torque_nm": (0, 158, 115),
    "hand_torque_nm": (213, 94, 0),
}
"""The torques of the bars below the dial, from top to bottom, and their colours."""
FULL_NM: Final = 0.1
"""Torque of a bar that reaches the edge; positive to the right."""

_SIZE, _BAR, _RADIUS = 240, 12, 96.0
_DARK, _PALE = (34, 34, 34), (227, 227, 227)

Image = npt.NDArray[np.uint8]


def draw(state: np.void) -> Image:
    """Draw a row of `torsio.telemetry.LOOP_DTYPE`: RGB, shape (300, 240, 3).

    The pointer is up at angle 0 and turns clockwise with it, as on the page.
    """
    image = np.full((_SIZE + 5 * _BAR, _SIZE, 3), 255.0)
    y, x = np.mgrid[:_SIZE, :_SIZE] - 0.5 * (_SIZE - 1)
    _paint(image[:_SIZE], np.abs(np.hypot(x, y) - _RADIUS) - 3.0, _DARK)
    sine, cosine = np.sin(state["angle_rad"]), np.cos(state["angle_rad"])
    along, across = x * sine - y * cosine, x * cosine + y * sine
    past = np.maximum(np.maximum(0.3 * _RADIUS - along, along - 0.9 * _RADIUS), 0.0)
    _paint(image[:_SIZE], np.hypot(across, past) - 4.0, BARS["hand_torque_nm"])
    middle = _SIZE // 2
    for place, (name, colour) in enumerate(BARS.items()):
        top = _SIZE + place * (_BAR + _BAR // 2)
        end = middle + round(middle * float(np.clip(state[name] / FULL_NM, -1.0, 1.0)))
        image[top : top + _BAR] = _PALE
        image[top : top + _BAR, min(middle, end) : max(middle, end)] = colour
        image[top : top + _BAR, middle - 1 : middle + 1] = _DARK
    return image.astype(np.uint8)


def _paint(
    image: npt.NDArray[np.float64], outside: npt.NDArray[np.float64], colour: object
) -> None:
    """Cover what lies so many pixels outside an edge, or inside where that is negative."""
    cover = np.clip(0.5 - outside, 0.0, 1.0)[..., np.newaxis]
    image += cover * (np.asarray(colour, dtype=float) - image)
