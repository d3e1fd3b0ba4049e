"""Small pictures for notebooks, as SVG, without other packages."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable, Mapping
from math import cos, sin
from typing import TYPE_CHECKING, Any

import numpy as np

from torsio.common.extras import need_matplotlib
from torsio.errors import Error
from torsio.telemetry import Record

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Telemetry", "curve", "dial", "knob", "picture", "table"]

_WIDTH, _HEIGHT, _LINE, _POINTS = 480, 120, 15, 480
_CURVES = (("angle_rad", "#CC79A7"), ("desired_torque_nm", "#0072B2"))


class Telemetry(np.ndarray[tuple[Any, ...], np.dtype[np.void]]):
    """Samples of a knob: a structured array that can show itself.

    A column, ``log["angle_rad"]``, is an ordinary array.
    """

    # For type checkers it is indexed as any array.
    if not TYPE_CHECKING:

        def __getitem__(self, key):
            """Give a column as an ordinary array, and samples as samples."""
            names = self.dtype.names or ()
            if isinstance(key, str) and key not in names:
                raise ValueError(f"no column {key!r}; there are {', '.join(names)}")
            found = super().__getitem__(key)
            if isinstance(found, Telemetry) and found.dtype.names is None:
                return found.view(np.ndarray)
            return found

        def __getattr__(self, name):
            """Say how a column is written."""
            said = f"{type(self).__name__!r} object has no attribute {name!r}"
            if name in (self.dtype.names or ()):
                said += f'; its column is log["{name}"]'
            raise AttributeError(said)

    def __repr__(self) -> str:
        """Show the first and the last samples."""
        with np.printoptions(threshold=8, edgeitems=3):
            return super().__repr__()

    def __str__(self) -> str:
        """Show the first and the last samples, as rows alone."""
        with np.printoptions(threshold=8, edgeitems=3):
            return super().__str__()

    def plot(self) -> Figure:
        """Draw angle and torques over time.

        A notebook shows the figure; ``savefig(path)`` writes it. Needs the extra ``plot``.
        """
        need_matplotlib()
        from torsio.common.plots import plot_samples

        return plot_samples(self)

    def _repr_html_(self) -> str | None:
        drawn = {name for name, _ in _CURVES} | {"time_s"}
        if self.ndim != 1 or not drawn <= set(self.dtype.names or ()):
            return None
        spans_s = float(np.ptp(self["time_s"])) if len(self) else 0.0
        return f"<p>{len(self)} samples, {spans_s:.3g} s</p>{picture(self)}"


def picture(log: Record) -> str:
    """Draw angle and wanted torque over time, each over its own range; nothing of no samples."""
    if len(log) < 2:
        return ""
    rows = log[:: -(-len(log) // _POINTS)]
    x = np.arange(len(rows))
    return _curves(
        (x, rows[name], f"{name}: {log[name].min():.3g} to {log[name].max():.3g}", colour)
        for name, colour in _CURVES
    )


def curve(x: Any, y: Any, x_label: str, y_label: str) -> str:
    """Draw one curve, and say over which ranges."""
    title = f"{y_label}: {min(y):.3g} to {max(y):.3g}; {x_label}: {min(x):.3g} to {max(x):.3g}"
    return _curves([(x, y, title, "#0072B2")])


def dial(angle_rad: float) -> str:
    """Draw a knob whose pointer is up at 0 and turns clockwise with the angle."""
    x, y = 50 + 36 * sin(angle_rad), 50 - 36 * cos(angle_rad)
    return (
        '<svg width="100" height="100" style="display:block">'
        '<circle cx="50" cy="50" r="44" fill="none" stroke="#222" '
        f'stroke-width="3"/><line x1="50" y1="50" x2="{x:.1f}" y2="{y:.1f}" stroke="#D55E00" '
        'stroke-width="5" stroke-linecap="round"/></svg>'
    )


def knob(words: str, info: Mapping[str, object], ask: Callable[[], float]) -> str:
    """Show what a knob says of itself, and where it stands, if it is there to be asked."""
    shown = html.escape(words)
    try:
        drawn = dial(ask()) if info else ""
    except Error:
        drawn = ""
    return (
        shown
        + drawn
        + table(
            (name, f"{value:g}" if isinstance(value, float) else str(value))
            for name, value in info.items()
        )
    )


def table(rows: Iterable[tuple[str, ...]]) -> str:
    """Write rows of words as a table."""
    written = ("".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows)
    return f"<table>{''.join(f'<tr>{row}</tr>' for row in written)}</table>"


def _curves(curves: Iterable[tuple[Any, Any, str, str]]) -> str:
    words, lines, top = "", "", 0
    for top, (x, y, title, colour) in enumerate(curves, 1):
        across, up = _WIDTH * _shares(x), _HEIGHT * (1.0 - _shares(y))
        points = " ".join(f"{a:.0f},{b:.1f}" for a, b in zip(across, up, strict=True))
        lines += f'<polyline points="{points}" fill="none" stroke="{colour}"/>'
        words += f'<text y="{_LINE * top - 4}" font-size="11" fill="{colour}">{title}</text>'
    height = _LINE * top + _HEIGHT + 2
    return (
        f'<svg width="{_WIDTH}" height="{height}" style="display:block">{words}'
        f'<g transform="translate(0 {_LINE * top + 1})">{lines}</g></svg>'
    )


def _shares(values: Any) -> Any:
    """Give where values lie between the lowest and the highest."""
    values = np.asarray(values, dtype=float)
    low = values.min()
    return (values - low) / (np.ptp(values) or 1.0)
