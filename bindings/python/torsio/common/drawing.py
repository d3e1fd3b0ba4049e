"""The look of all pictures, and the words in them; needs the extra `plot`."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Literal, cast

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

# Okabe and Ito's palette: told apart with every kind of colour vision.
BLACK, GREY, RED = "#222222", "#8a8a8a", "#c0392b"
BLUE, ORANGE, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#9b4f86"
WALL_FILL, TEXT = "#ececec", "#444444"

_STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 10.5,
    "axes.titlesize": 12.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": GREY,
    "axes.labelcolor": BLACK,
    "xtick.color": BLACK,
    "ytick.color": BLACK,
    "axes.grid": True,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.8,
    "axes.axisbelow": True,
    "lines.linewidth": 2.0,
    "lines.solid_capstyle": "round",
}


class _Shown(Figure):
    """A figure that a notebook shows without `matplotlib.pyplot`."""

    def _repr_png_(self) -> bytes:
        data = io.BytesIO()
        self.savefig(data, format="png")
        return data.getvalue()


@contextmanager
def drawn(size: tuple[float, float], dpi: int, **options: Any) -> Iterator[Figure]:
    """Give a figure to draw on, and to save, in the project's look."""
    with mpl.rc_context(_STYLE):
        figure = _Shown(figsize=size, dpi=dpi, facecolor="white", **options)
        FigureCanvasAgg(figure)
        yield figure


def headline(
    figure: Figure, title: str, text: str, *, width: int = 150, left: float = 0.05
) -> None:
    """Write what the figure is about over it, within the top 1.15 inches."""
    inch = 1.0 / figure.get_size_inches()[1]
    figure.text(left, 1 - 0.42 * inch, title, fontsize=19, fontweight="bold", color=BLACK)
    _paragraph(figure, left, 1 - 0.56 * inch, text, width, fontsize=11)


def caption(axes: Axes, text: str, *, width: int = 80, below: float = 0.52) -> None:
    """Write a few lines under the axes, so many inches below them."""
    inches = axes.get_window_extent().height / cast(Figure, axes.figure).dpi
    _paragraph(axes, 0.0, -below / inches, text, width, fontsize=9.5, transform=axes.transAxes)


def _paragraph(
    place: Figure | Axes, x: float, y: float, text: str, width: int, **look: Any
) -> None:
    place.text(x, y, textwrap.fill(text, width), color=TEXT, va="top", linespacing=1.4, **look)


def label(
    axes: Axes,
    x: float,
    y: float,
    text: str,
    color: str,
    *,
    ha: Literal["left", "center", "right"] = "left",
    va: Literal["top", "center", "bottom"] = "center",
    bold: bool = True,
) -> None:
    """Name a line where it is."""
    axes.text(
        x,
        y,
        text,
        color=color,
        ha=ha,
        va=va,
        fontsize=10,
        fontweight="bold" if bold else "normal",
        bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 1.0},
    )


def coloured_table(
    axes: Axes,
    headings: Sequence[str],
    rows: Sequence[Sequence[tuple[str, Any, float]]],
    left: float,
) -> None:
    """Draw cells of (text, colour, alpha) under headings; row r is at r to r + 1."""
    axes.set_axis_off()
    axes.set_xlim(0, 1)
    axes.set_ylim(len(rows), -1.0)
    width = (1 - left) / len(headings)
    for i, heading in enumerate(headings):
        x = left + (i + 0.5) * width
        axes.text(x, -0.12, heading, ha="center", va="bottom", fontweight="bold", linespacing=1.25)
    for r, row in enumerate(rows):
        for i, (text, colour, alpha) in enumerate(row):
            edges = [left + i * width + 0.002, left + (i + 1) * width - 0.002]
            axes.fill_between(edges, r + 0.05, r + 0.95, color=colour, alpha=alpha, lw=0)
            axes.text(0.5 * sum(edges), r + 0.5, text, ha="center", va="center")
