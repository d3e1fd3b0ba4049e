"""The picture of a trade: error against cost; needs the extra `plot`."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes

from torsio.common.drawing import BLACK, BLUE, GREY, ORANGE, TEXT, WALL_FILL, drawn
from torsio.common.whole_file import beside
from torsio.trading.found import Row, Trade

__all__ = ["panel", "save_figure"]

_LEAST_JNDS = 1e-3
_NAMES_AT, _ROOM, _APART = 2.0, 25.0, 1.6  # of names right of all points, and between names


def _shown(row: Row) -> tuple[float, float]:
    return 1e3 * row.cpu_s, max(row.difference.jnds, _LEAST_JNDS)


def panel(axes: Axes, found: Trade, title: str) -> None:
    """Draw one trade: right costs more, low is truer."""
    may = [row for row in found.rows if row.variant.may_be_proposed]
    tried = [row for row in may if row.name == row.variant.name]
    axes.set(xscale="log", yscale="log", title=title)
    axes.axhspan(_LEAST_JNDS / 2, found.wanted_jnds, color=WALL_FILL, zorder=0, label="wanted")
    axes.plot(*zip(*map(_shown, tried), strict=True), ".", color=GREY, label="tried")
    front = sorted(_shown(row) for row in tried if row.is_on_front)
    axes.plot(*zip(*front, strict=True), "o-", color=BLUE, ms=5, lw=1.2, label="front")
    device = _shown(found.on_device)
    axes.plot(*device, "s", color=ORANGE, ms=6, label="whole device, other visit")
    axes.plot(*_shown(found.proposal), "D", color=BLACK, ms=8, label="proposed")
    axes.set_ylim(_LEAST_JNDS / 2, 5.0 * max(_shown(row)[1] for row in tried))
    alone = [
        (_shown(row), name) for name, row in found.alone.items() if row.variant.may_be_proposed
    ]
    # From the largest change downwards, so far apart that each can be read.
    place, dearest = axes.get_ylim()[1], max(_shown(row)[0] for row in tried)
    axes.set_xlim(right=_ROOM * dearest)
    for (x, y), name in sorted(alone, key=lambda one: -one[0][1]):
        place = min(place / _APART, y)
        axes.annotate(
            f"no {name}", (x, y), (_NAMES_AT * dearest, place), fontsize=8, color=TEXT,
            va="center", ha="left", arrowprops={"arrowstyle": "-", "color": GREY, "lw": 0.5},
        )  # fmt: skip
    axes.set_xlabel("CPU time for a second of the knob, ms")


def save_figure(found: Trade, path: Path, title: str = "What this scene needs") -> None:
    """Draw it and save a PNG."""
    with drawn((8.5, 6.0), dpi=120, layout="constrained") as figure:
        axes = figure.subplots()
        panel(axes, found, title)
        axes.set_ylabel(f"largest change of the felt torque, JND ({_LEAST_JNDS:g}: that or less)")
        figure.legend(loc="outside lower center", ncols=5, frameon=False, labelcolor=TEXT)
        with beside(path) as part:
            figure.savefig(part)
