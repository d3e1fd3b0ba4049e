"""Pictures of the study `design`, for somebody who has not read the paper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter
from scipy.stats import spearmanr

from torsio.common.drawing import GREY, coloured_table, headline
from torsio.printed.plant import PlantParams
from torsio_studies.actuators import trials
from torsio_studies.common import Study
from torsio_studies.design.devices import MAPS, SPACE

Array = npt.NDArray[np.float64]
Table = dict[str, Array]

#: measure: what it is called, and whether more of it is better
OUTCOMES: Final = {
    "stable_stiffness_nm_per_rad": ("stiffest wall\nwithout buzz", True),
    "critical_torque_nm": ("largest\ntrue torque", True),
    "tracking_in": ("error\ngoing in", False),
    "tracking_out": ("error\ncoming out", False),
    "torque_gap_nm": ("torque gap\ncoming out", False),
    "sensor_rms_nm": ("error of the\nsensed torque", False),
}


def influences(sample: Table) -> list[dict[str, Any]]:
    """Give Spearman's rank correlation of every parameter with every measure.

    1: more of the parameter always means more of the measure; -1: always less; 0: no such relation.
    A parameter or measure that is the same for all devices has 0.
    """
    rows = []
    for parameter in SPACE:
        row: dict[str, Any] = {"parameter": parameter}
        for outcome in OUTCOMES:
            row[outcome] = rank_correlation(sample[parameter], sample[outcome])
        rows.append(row)
    return rows


def rank_correlation(a: Array, b: Array) -> float:
    """Give Spearman's rank correlation, pairs with NaN left out."""
    known = np.isfinite(a) & np.isfinite(b)
    if known.sum() < 2 or any(np.ptp(values[known]) == 0 for values in (a, b)):
        return 0.0
    return float(spearmanr(a[known], b[known]).statistic)


def draw(study: Study, table: dict[str, Table], side: int) -> None:
    """Draw all pictures."""
    with study.figure("maps", size=(14.0, 6.6)) as figure:
        maps(figure, {name: table[f"map_{name}_{side}"] for name in MAPS}, side)
    with study.figure("influence", size=(13.0, 6.4)) as figure:
        influence(figure, table["sample"])


@dataclass(frozen=True)
class _Map:
    name: str
    measure: str
    title: str
    unit: str
    scale: float
    logarithmic: bool


_PANELS = (
    _Map(
        "rate",
        "stable_stiffness_nm_per_rad",
        "How stiff can a wall be?",
        "mN·m per degree before it buzzes",
        trials.NM_PER_RAD,
        True,
    ),
    _Map(
        "beta",
        "stable_stiffness_nm_per_rad",
        "... with another share for the brake?",
        "mN·m per degree before it buzzes",
        trials.NM_PER_RAD,
        True,
    ),
    _Map(
        "beta",
        "critical_torque_nm",
        "How much torque is true?",
        "mN·m with the motor below its limit",
        1e3,
        False,
    ),
)

_AXES = {
    "shaft_stiffness_nm_per_rad": (
        "stiffness of the shaft (mN·m per degree)",
        trials.NM_PER_RAD,
    ),
    "control_rate_hz": ("control rate (kHz)", 1e-3),
    "beta": ("brake's share of the torque, β", 1.0),
}


def maps(figure: Figure, tables: dict[str, Table], side: int) -> None:
    """Draw the stability and critical-torque maps."""
    headline(
        figure,
        "Choosing shaft, control rate and the brake's share",
        "Each square, at the borders half of one, is a simulated device; the ring marks the "
        "paper's. Left and middle: the "
        "stiffest virtual wall that does not start to buzz. Right: the largest torque that motor "
        "and brake give truly, in a wall of 30 mN·m per degree, going in and coming out again.",
        width=165,
    )
    for i, panel in enumerate(_PANELS):
        axes = figure.add_axes((0.055 + i * 0.325, 0.2, 0.275, 0.56))
        _draw_map(figure, axes, panel, tables[panel.name], side)


def _draw_map(figure: Figure, axes: Axes, panel: _Map, table: Table, side: int) -> None:
    x_name, y_name = MAPS[panel.name]
    values = panel.scale * table[panel.measure].reshape(side, side)
    if panel.logarithmic:
        norm: Normalize = LogNorm(20, trials.NM_PER_RAD * 200)
    else:
        norm = Normalize(0, 220)
    x, y = (
        _AXES[name][1] * table[name].reshape(side, side)[index]
        for name, index in ((x_name, (0, slice(None))), (y_name, (slice(None), 0)))
    )
    image = axes.pcolormesh(
        _edges(x, SPACE[x_name].logarithmic),
        _edges(y, SPACE[y_name].logarithmic),
        values,
        norm=norm,
        cmap="viridis",
    )
    axes.grid(False)
    axes.set_title(panel.title)
    for name, axis, set_scale in (
        (x_name, axes.xaxis, axes.set_xscale),
        (y_name, axes.yaxis, axes.set_yscale),
    ):
        axis.set_label_text(_AXES[name][0])
        if SPACE[name].logarithmic:
            set_scale("log")
            axis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
            axis.set_minor_formatter(NullFormatter())
    axes.set_xticks([10, 20, 50, 100, 200])
    if y_name == "control_rate_hz":
        axes.set_yticks([0.5, 1, 2, 5, 10])
    own = (
        PlantParams().shaft_stiffness_nm_per_rad * trials.NM_PER_RAD,
        1.0 if y_name == "control_rate_hz" else 0.5,
    )
    axes.plot(*own, "o", ms=11, mfc="none", mec="white", mew=2.2)
    bar_axes = figure.add_axes((axes.get_position().x0, 0.075, axes.get_position().width, 0.022))
    bar = figure.colorbar(image, cax=bar_axes, orientation="horizontal")
    bar_axes.spines[:].set_visible(False)
    bar.set_label(panel.unit)
    if panel.logarithmic:
        bar.set_ticks([20, 50, 100, 200, 500, 1000, 2000])
        bar.ax.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        bar.ax.xaxis.set_minor_formatter(NullFormatter())


def _edges(centres: Array, logarithmic: bool) -> Array:
    """Give the borders of the squares; the outer ones are halves, so that none leaves the range."""
    values = np.log(centres) if logarithmic else centres
    middles = 0.5 * (values[1:] + values[:-1])
    edges = np.concatenate([values[:1], middles, values[-1:]])
    return np.asarray(np.exp(edges) if logarithmic else edges)


def influence(figure: Figure, sample: Table) -> None:
    """Draw the rank correlations as a coloured table."""
    headline(
        figure,
        "What each choice changes",
        f"{len(sample['beta'])} random devices. A number near +1: more of what is on the left "
        "always means more of what is above; near -1: always less; near 0: it hardly matters. "
        "Green is a change for the better, orange for the worse.",
    )
    axes = figure.add_axes((0.045, 0.03, 0.93, 0.77))
    rows = influences(sample)
    cells = [[_cell(row[outcome], more) for outcome, (_, more) in OUTCOMES.items()] for row in rows]
    coloured_table(axes, [heading for heading, _ in OUTCOMES.values()], cells, left=0.27)
    for r, row in enumerate(rows):
        span = SPACE[row["parameter"]]
        axes.text(0.0, r + 0.4, span.title, va="center", fontweight="bold")
        axes.text(0.0, r + 0.7, _range_text(row["parameter"]), va="center", fontsize=9, color=GREY)


def _cell(value: float, more_is_better: bool) -> tuple[str, tuple[float, float, float], float]:
    is_good = (value if more_is_better else -value) > 0
    colour = (0.0, 0.62, 0.45) if is_good else (0.84, 0.37, 0.0)
    return f"{value:+.2f}", colour, min(1.0, 0.04 + 0.66 * abs(value))


def _range_text(name: str) -> str:
    span = SPACE[name]
    scale, unit = {
        "beta": (1.0, ""),
        "motor_limit_nm": (1e3, " mN·m"),
        "brake_limit_nm": (1e3, " mN·m"),
        "shaft_stiffness_nm_per_rad": (trials.NM_PER_RAD, " mN·m per degree"),
        "control_rate_hz": (1e-3, " kHz"),
        "counts_per_rev": (1.0, " a turn"),
        "knob_inertia_kg_m2": (1e7, " g cm²"),
    }[name]
    low, high = (
        f"{v:,.0f}" if v >= 10 else f"{v:.3g}" for v in (scale * span.low, scale * span.high)
    )
    return f"{low} to {high}{unit}"
