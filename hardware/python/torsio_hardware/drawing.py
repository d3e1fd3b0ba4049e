"""A drawing of the spring with the dimensions that decide, as SVG, 4 to 1."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from torsio_hardware.design import FULL_NM, Spring
from torsio_hardware.layout import BORE_MM, RIM_MM, SCREWS_MM

_SCALE = 4e3  # drawing units a metre
_MIDDLE = (150.0, 150.0)


def page(width: int, height: int, shapes: Iterable[str]) -> str:
    """Put shapes on a white sheet, as SVG."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}">'
        "<style>rect{fill:#eef3f7;stroke:#345}polyline{fill:none;stroke-width:2}.dot{fill:#ccc}"
        "text{font:12px sans-serif}.small{font-size:10px;fill:#333}.part{fill:#c9d6e2}.hole{"
        "fill:#fff}.part,.hole{stroke:#123;stroke-width:.6}.edge{fill:none;stroke:#123}.letter{"
        "font-weight:bold;fill:#b22}</style>"
        f'<rect width="{width}" height="{height}" style="fill:#fff;stroke:none"/>'
        f"{''.join(shapes)}</svg>\n"
    )


def _outline(points: Any) -> str:
    words = (f"{_MIDDLE[0] + _SCALE * x:.2f},{_MIDDLE[1] - _SCALE * y:.2f}" for x, y in points)
    return f'<polygon class="part" points="{" ".join(words)}"/>'


def _circle(radius_m: float, x: float = 0.0, y: float = 0.0, kind: str = "edge") -> str:
    return (
        f'<circle class="{kind}" cx="{_MIDDLE[0] + _SCALE * x:.2f}" '
        f'cy="{_MIDDLE[1] - _SCALE * y:.2f}" r="{_SCALE * radius_m:.2f}"/>'
    )


def words(spring: Spring) -> list[str]:
    """Say what a maker measures on the printed part, by the drawing's letters, and what it does."""
    shape, of, nominal = spring.flexure, spring.material, spring.stiffness_nm_per_rad
    low, high = (nominal * (1 + k * 1.96 * spring.relative_uncertainty) for k in (-1, 1))
    off_mm, creep = 1e3 * spring.within_m, of.creep(1.0)
    softest = spring.strain_at(FULL_NM * nominal / low)  # it is twisted so far
    return [
        f"Spring of {of.name}: print flat, 100 % of walls",
        f"A: wall of every arm {1e3 * shape.thickness_m:.2f} mm ± {off_mm:.2f}: stiffness, the "
        "third power",
        f"B: hub, outside Ø {2e3 * shape.hub_radius_m:.1f} mm ± 0.1: where the arms begin",
        f"C: rim, inside Ø {2e3 * shape.rim_radius_m:.1f} mm ± 0.1: where the arms end",
        f"D: rim, outside Ø {2 * RIM_MM:.1f} mm: lies on the drum",
        f"E: bore Ø {2 * BORE_MM + 4:.1f} mm, ream to the sleeve: the hub must not slip",
        f"Height {1e3 * shape.width_m:.2f} mm ± 0.1: stiffness, in proportion",
        f"{shape.arms} arms, {shape.family}; of a meander every second one is mirrored",
        f"Stiffness {nominal:.3f} N m/rad, 95 %: {low:.2f} to {high:.2f}",
        f"Walls {off_mm:.2f} mm off: {100 * (spring.thinner - 1):+.0f} or "
        f"{100 * (spring.thicker - 1):+.0f} %",
        f"Straight within {100 * spring.deviation:.2f} % to 0.04 rad",
        f"Strain there {100 * spring.strain:.2f} %; limit {100 * of.strain_limit:.1f} %, safety "
        f"{spring.safety:.2f}",
        f"Softest, at {1e3 * FULL_NM:.0f} mN m: {100 * softest:.2f} %, safety "
        f"{of.strain_limit / softest:.2f}; below 1: cap the torque",
        f"A wall held for an hour: {100 * (creep.value - 1):.0f} % more twist, assumed "
        f"{100 * (creep.low - 1):.0f} to {100 * (creep.high - 1):.0f}",
        f"ShaftConfig: {spring.shaft_config() or 'one straight line'}",
        "Computed, not printed: calibrate it.",
    ]


def _letters(spring: Spring) -> str:
    """Point at what is measured."""
    shape = spring.flexure
    places = {"A": shape.centre_line(3)[1] + 1.5e-3}
    hub, inside = shape.hub_radius_m + 5e-4, shape.rim_radius_m - 3e-3
    radii = (hub, inside, 1e-3 * RIM_MM + 5e-4, 1e-3 * BORE_MM)
    for letter, radius, turn in zip("BCDE", radii, (1.6, 1.5, 0.8, 4.7), strict=True):
        places[letter] = radius * np.array([np.cos(turn), np.sin(turn)])
    return "".join(
        f'<text class="letter" x="{_MIDDLE[0] + _SCALE * x:.1f}" y="{_MIDDLE[1] - _SCALE * y:.1f}">'
        f"{letter}</text>"
        for letter, (x, y) in places.items()
    )


def svg(spring: Spring) -> str:
    """Draw the spring from above, with its critical dimensions and what to expect of it."""
    shape = spring.flexure
    parts = [_circle(1e-3 * RIM_MM, kind="part"), _circle(shape.rim_radius_m, kind="hole")]
    parts += map(_outline, shape.outlines(80))
    parts += [_circle(shape.hub_radius_m, kind="part"), _circle(1e-3 * (BORE_MM + 2), kind="hole")]
    parts += [_circle(1e-3 * radius, 1e-3 * x, 1e-3 * y, "hole") for radius, x, y in SCREWS_MM]
    lines = "".join(
        f'<text x="310" y="{30 + 19 * n}">{line}</text>' for n, line in enumerate(words(spring))
    )
    rule = f'<line class="edge" x1="150" y1="285" x2="{150 + 1e-2 * _SCALE:.0f}" y2="285"/>'
    letters = f'{_letters(spring)}<text x="150" y="300">10 mm</text>'
    return page(720, 320, [*parts, rule, letters, lines])
