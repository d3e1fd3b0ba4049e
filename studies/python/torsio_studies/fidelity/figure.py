"""The picture of the study `fidelity`: error against speed."""

from __future__ import annotations

import math
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from torsio.common.drawing import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    RED,
    TEXT,
    WALL_FILL,
    headline,
)

Rows = list[dict[str, Any]]

LOWEST: Final = 1e-14
HIGHEST: Final = 1e1
SERIES: Final = (
    ("exact", "exact", BLUE, "o"),
    ("exact_single", "exact, in single precision", RED, "P"),
    ("trapezoid", "trapezoid", GREEN, "s"),
    ("semi_implicit", "semi-implicit", PURPLE, "^"),
    ("regularised", "smoothed friction (RK4)", GREY, "v"),
    ("mujoco", "MuJoCo, best settings found", ORANGE, "D"),
    ("mujoco_default", "MuJoCo, defaults", BLACK, "x"),
    ("drake", "Drake, best settings found", BLACK, "d"),
    ("scipy", "SciPy, best settings found", TEXT, "*"),
)


def draw(figure: Figure, rows: Rows, summaries: list[dict[str, Any]]) -> None:
    """Draw one panel a scenario."""
    axes = figure.subplots(1, len(summaries), sharex=True, sharey=True)
    for i, (ax, summary) in enumerate(zip(axes, summaries, strict=True)):
        _panel(ax, [row for row in rows if row["scenario"] == summary["scenario"]], summary)
        if i == 0:
            ax.set_ylabel("largest error of knob angle and spring torque, relative")
    headline(
        figure,
        "How fast a simulation of the knob is, and how wrong",
        "Each point simulates one visit to a virtual wall with one method and one step. Right "
        "is faster, low is truer: one wants to be at the bottom right.",
    )
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=4, frameon=False)
    figure.subplots_adjust(left=0.07, right=0.985, top=0.76, bottom=0.2, wspace=0.06)


def _panel(ax: Axes, rows: Rows, summary: dict[str, Any]) -> None:
    ax.set_xscale("log")
    ax.set_yscale("log")
    target = summary["target_error"]
    ax.axhspan(LOWEST, target, color=WALL_FILL, zorder=0)
    ax.text(
        0.015, 3 * LOWEST, "good enough: error below 0.1 %", transform=ax.get_yaxis_transform(),
        ha="left", va="bottom", fontsize=9, color=TEXT,
    )  # fmt: skip
    for method, label, colour, marker in SERIES:
        points = sorted(
            (row["realtime_factor"], _shown(row["error"])) for row in _front(rows, method)
        )
        ax.plot(
            [x for x, _ in points],
            [y for _, y in points],
            color=colour,
            marker=marker,
            markersize=6 if method in ("exact", "mujoco") else 4.5,
            linewidth=1.8 if method in ("exact", "mujoco") else 1.0,
            linestyle="-" if method != "mujoco_default" else "--",
            label=label,
        )
    if summary["ratio"] is not None:
        start, end = summary["mujoco"]["realtime_factor"], summary["exact"]["realtime_factor"]
        ax.annotate(
            "", xy=(end, 1e-8), xytext=(start, 1e-8),
            arrowprops={"arrowstyle": "<->", "color": TEXT},
        )  # fmt: skip
        ax.text(
            math.sqrt(start * end), 6e-9, f"{summary['ratio']:,.0f} times as fast",
            ha="center", va="top", color=TEXT,
            bbox={"facecolor": WALL_FILL, "edgecolor": "none", "pad": 1.5},
        )  # fmt: skip
    ax.set_ylim(LOWEST, HIGHEST)
    ax.set_xlabel("seconds simulated in a second of one core")
    events = summary["friction_events"]
    ax.set_title(
        f"Scenario {summary['scenario']}: {summary['about']}\n"
        f"friction catches or lets go {events} times in {summary['duration_s']:g} s",
        loc="left",
        fontsize=11,
        color=TEXT,
    )


def _shown(error: float | None) -> float:
    """Put values off the scale at its end."""
    if error is None or not math.isfinite(error):
        return HIGHEST
    return min(max(error, LOWEST), HIGHEST)


def _front(rows: Rows, method: str) -> Rows:
    """Give the settings that no other beats in both ways."""
    own = [row for row in rows if row["method"] == method]
    if method not in ("mujoco", "drake", "scipy"):
        return own
    own.sort(key=lambda row: -float(row["realtime_factor"]))
    best = math.inf
    front = []
    for row in own:
        if _shown(row["error"]) < best:
            best = _shown(row["error"])
            front.append(row)
    return front
