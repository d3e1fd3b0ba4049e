"""Pictures of the study `actuators`, for somebody who has not read the paper."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from torsio.common.drawing import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    WALL_FILL,
    coloured_table,
    headline,
)
from torsio.demos import wall as demo
from torsio_studies.actuators import trials
from torsio_studies.actuators.trials import ACTUATORS, Actuator, Measures
from torsio_studies.common import Study

GOOD, FAIR, POOR = "#cfe8dc", "#fbeec2", "#f6cfb8"


@dataclass(frozen=True)
class Column:
    """A column of the scoreboard: up to `good` is green, up to `fair` yellow (or down to)."""

    heading: str
    value: Callable[[Measures], float]
    text: Callable[[float], str]
    good: float
    fair: float
    more_is_better: bool = False
    note: Callable[[Measures], str | None] = lambda _: None  # instead of the value's text

    def cell(self, row: Measures) -> str:
        """Give what is written in a cell."""
        return self.note(row) or self.text(self.value(row))

    def colour(self, row: Measures) -> str:
        """Give the colour of a cell."""
        value = self.value(row)
        side = -1 if self.more_is_better else 1
        if side * value <= side * self.good:
            return GOOD
        return FAIR if side * value <= side * self.fair else POOR


def _stable(row: Measures) -> float:
    limit = row.stable_stiffness_nm_per_rad
    return math.inf if limit is None else limit * trials.NM_PER_RAD


LATE_MS = 100.0


def _exit(row: Measures) -> float:
    if row.exit_time_s is not None:
        return 1e3 * row.exit_time_s
    # A knob that friction holds has not left: give it the worst fair mark.
    return LATE_MS if row.outcome == "held by friction" else math.inf


def _kept(row: Measures) -> str | None:
    """Say what keeps the knob in the wall, if anything does."""
    return {"leaves": None, "held by friction": "friction holds", "stays": "sticks"}[row.outcome]


COLUMNS: Final = (
    Column(
        "error\ngoing in", lambda r: 100 * r.walls[1].tracking_in, lambda v: f"{v:.1f} %", 7, 15
    ),
    Column(
        "error\ncoming out", lambda r: 100 * r.walls[1].tracking_out, lambda v: f"{v:.1f} %", 9, 20
    ),
    Column(
        "largest gap\ncoming out",
        lambda r: 1e3 * r.walls[1].torque_gap_nm,
        lambda v: f"{v:.0f} mN·m",
        10,
        20,
    ),
    Column(
        "leaves a wall,\nlet go, after",
        _exit,
        lambda v: f"{v:.0f} ms",
        30,
        LATE_MS,
        note=_kept,
    ),
    Column(
        "stiffest wall\nwithout buzz",
        _stable,
        lambda v: f"{v:.0f} mN·m/°" if math.isfinite(v) else "never buzzes",
        120,
        50,
        more_is_better=True,
    ),
    Column("drag in\nfree air", lambda r: 1e3 * r.drag_nm, lambda v: f"{v:.1f} mN·m", 4, 8.5),
    Column(
        "largest true\ntorque",
        lambda r: 1e3 * r.peak_torque_nm,
        lambda v: f"{v:.0f} mN·m",
        100,
        80,
        more_is_better=True,
    ),
    Column("motor heat\nin the wall", lambda r: 100 * r.motor_heat, lambda v: f"{v:.0f} %", 10, 30),
)


def name(actuator: Actuator | Measures) -> str:
    """Give the title of an actuator with its letter in the paper."""
    letter = actuator.letter if isinstance(actuator, Actuator) else actuator.figure
    title = actuator.title.replace("`", "")
    return f"({letter}) {title}" if letter else title


def draw(study: Study, rows: Sequence[Measures]) -> None:
    """Draw all pictures."""
    with study.figure("scoreboard", size=(14.6, 7.3)) as figure:
        scoreboard(figure, rows)
    with study.figure("walls", size=(15.5, 10.6)) as figure:
        walls(figure)
    with study.figure("string", size=(13.5, 6.4)) as figure:
        string(figure, rows)


def scoreboard(figure: Figure, rows: Sequence[Measures]) -> None:
    """Draw all numbers as a coloured table."""
    headline(
        figure,
        "Thirteen ways to build a knob that pushes back",
        "The same motor, brake, encoder and virtual wall (30 mN·m per degree) for all; what "
        "differs is how the parts are put together and controlled. Green is good, orange is poor. "
        "Letters are those of the paper's Fig. 1.",
        width=165,
        left=0.03,
    )
    axes = figure.add_axes((0.03, 0.02, 0.94, 0.8))
    cells = [[(one.cell(row), one.colour(row), 1.0) for one in COLUMNS] for row in rows]
    coloured_table(axes, [column.heading for column in COLUMNS], cells, left=0.265)
    for r, row in enumerate(rows):
        own = row.figure == "f"
        axes.text(0.0, r + 0.5, name(row), va="center", fontweight="bold" if own else "normal")


def walls(figure: Figure) -> None:
    """Draw what the hand feels on the way in and out, one panel an actuator."""
    headline(
        figure,
        "What the hand feels in the same wall",
        "A hand presses every actuator into a wall of 30 mN·m per degree (blue), holds, and comes "
        "out again (orange). A perfect device would follow the dashed line both ways. Below zero "
        "the device holds the hand back: it sticks.",
        left=0.03,
    )
    axes_grid = figure.subplots(3, 5, sharex=True, sharey=True)
    figure.subplots_adjust(left=0.06, right=0.985, top=0.85, bottom=0.06, hspace=0.3, wspace=0.07)
    stiffness = trials.WALLS_MNM_PER_DEG[1] / trials.NM_PER_RAD
    for axes, actuator in zip(axes_grid.flat, ACTUATORS, strict=False):
        _wall(axes, actuator, stiffness)
    for axes in axes_grid.flat[len(ACTUATORS) :]:
        axes.set_axis_off()
    for axes in axes_grid[-1]:
        axes.set_xlabel("knob angle (degrees)")
    for axes in axes_grid[:, 0]:
        axes.set_ylabel("torque (mN·m)")


def _wall(axes: Axes, actuator: Actuator, stiffness_nm_per_rad: float) -> None:
    log = trials.visit_wall(actuator.key, stiffness_nm_per_rad)
    degrees, felt = np.degrees(log["angle_rad"]), -1e3 * log["rendered_torque_nm"]
    top = int(np.searchsorted(log["time_s"], demo.PUSH_S))
    leave = int(np.searchsorted(log["time_s"], demo.PUSH_S + demo.HOLD_S))
    wall = math.degrees(demo.WALL_ANGLE_RAD)
    ideal = np.array([0.0, 0.0, 120.0])
    axes.axvspan(wall, 8, color=WALL_FILL, lw=0, zorder=0)
    axes.axhline(0, color=GREY, lw=0.8)
    axes.plot([0, wall, wall + ideal[2] / 30], ideal, color=BLACK, lw=1.4, ls=(0, (4, 2)))
    axes.plot(degrees[: top + 1], felt[: top + 1], color=BLUE, lw=1.8)
    axes.plot(degrees[leave:], felt[leave:], color=ORANGE, lw=1.8)
    axes.set_xlim(0, 7.2)
    axes.set_ylim(-95, 105)
    own = actuator.letter == "f"
    axes.set_title(name(actuator), fontsize=11, fontweight="bold" if own else "normal")


def string(figure: Figure, rows: Sequence[Measures]) -> None:
    """Draw the knob's way out after the string is cut."""
    headline(
        figure,
        "Let go: does it leave the wall by itself?",
        "A weight holds the knob in a wall of 25 mN·m per degree; at time 0 its string is cut. "
        "What does not come out by itself feels sticky in the hand. Depths differ at first, as "
        "motor, brake, friction and springs carry the weight in different shares; (d) swings all "
        "the time, because all its torque comes through a clutch that lags.",
        left=0.03,
    )
    leaving, held, staying = (
        [row for row in rows if row.outcome == outcome]
        for outcome in ("leaves", "held by friction", "stays")
    )
    left = figure.add_axes((0.06, 0.1, 0.3, 0.64))
    middle = figure.add_axes((0.57, 0.46, 0.16, 0.28))
    right = figure.add_axes((0.57, 0.1, 0.16, 0.22))
    _paths(left, leaving, "These leave", (-0.02, 0.08))
    _paths(middle, staying, "These stay", (-0.1, 0.4))
    _paths(right, held, "Dry friction holds this", (-0.02, 0.08))
    left.set_ylabel("depth in the wall (degrees)")


def _paths(axes: Axes, rows: Sequence[Measures], title: str, limits: tuple[float, float]) -> None:
    colours = [
        BLUE,
        ORANGE,
        GREEN,
        PURPLE,
        "#56B4E9",
        "#E69F00",
        "#5a5a5a",
        "#b07d00",
        "#003f6b",
    ]
    ends = []
    for row, colour in zip(rows, colours, strict=False):
        log = trials.cut_string(row.actuator)
        time, degrees = log["time_s"] - trials.CUT_S, np.degrees(log["angle_rad"])
        shown = (time >= limits[0]) & (time <= limits[1])
        axes.plot(time[shown], degrees[shown], color=colour, lw=2.4 if row.figure == "f" else 1.6)
        ends.append((float(degrees[shown][-1]), row, colour))
    axes.set_title(title)
    axes.set_xlim(*limits)
    axes.set_ylim(-2.6, 3.2)
    axes.axhspan(0, 3.2, color=WALL_FILL, lw=0, zorder=0)
    axes.axhline(0, color=BLACK, lw=1.4)
    axes.axvline(0, color=GREY, lw=0.8)
    axes.set_xlabel("time after the cut (s)")
    axes.locator_params(axis="x", nbins=5)
    # Names at the ends of the lines, pushed apart so that none covers another.
    ends.sort(key=lambda end: end[0])
    height = -2.9
    for value, row, colour in ends:
        height = max(min(max(value, -2.5), 3.0), height + 0.28)
        axes.annotate(
            name(row),
            xy=(limits[1], min(max(value, -2.6), 3.2)),
            xytext=(limits[1] + 0.03 * (limits[1] - limits[0]), height),
            color=colour,
            va="center",
            fontsize=9.5,
            fontweight="bold" if row.figure == "f" else "normal",
            annotation_clip=False,
        )
