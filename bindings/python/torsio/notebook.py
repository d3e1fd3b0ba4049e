"""A small picture of telemetry for notebooks, as SVG, without other packages."""

from __future__ import annotations

import numpy as np

from torsio.telemetry import Record

__all__ = ["picture"]

_WIDTH, _HEIGHT, _POINTS = 480, 120, 480
_CURVES = (("angle_rad", "#CC79A7"), ("desired_torque_nm", "#0072B2"))


def picture(log: Record) -> str:
    """Draw angle and wanted torque over time, each over its own range; nothing of no samples."""
    if len(log) < 2:
        return ""
    rows = log[:: -(-len(log) // _POINTS)]
    x = np.linspace(0.0, _WIDTH, len(rows))
    drawn: list[str] = []
    for name, colour in _CURVES:
        low, high = float(log[name].min()), float(log[name].max())
        y = _HEIGHT * (1.0 - (rows[name] - low) / (high - low or 1.0))
        points = " ".join(f"{a:.0f},{b:.1f}" for a, b in zip(x, y, strict=True))
        title = f"{name}: {low:.3g} to {high:.3g}"
        drawn.append(
            f'<polyline points="{points}" fill="none" stroke="{colour}"><title>{title}</title>'
            f'</polyline><text y="{14 * len(drawn) + 12}" font-size="11" fill="{colour}">'
            f"{title}</text>"
        )
    return f'<svg width="{_WIDTH}" height="{_HEIGHT}">{"".join(drawn)}</svg>'
