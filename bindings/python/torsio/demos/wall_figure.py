"""The picture of a visit to the wall, for somebody who knows nothing of the device."""

from __future__ import annotations

from functools import partial
from pathlib import Path

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
    caption,
    drawn,
    headline,
    label,
)
from torsio.demos.wall import Array, WallMeasures, WallVisit, phases

_caption = partial(caption, width=82, below=0.58)


def save_figure(visit: WallVisit, measures: WallMeasures, path: Path) -> None:
    """Draw the four panels and write them as PNG."""
    with drawn((13.5, 10.4), dpi=150) as figure:
        axes = figure.subplots(2, 2)
        figure.subplots_adjust(
            left=0.055, right=0.98, top=0.862, bottom=0.115, wspace=0.15, hspace=0.5
        )
        _headline(figure, visit, measures)
        _position(axes[0, 0], visit)
        _torques(axes[0, 1], visit)
        _loop(axes[1, 0], visit, measures)
        _sensor(axes[1, 1], visit, measures)
        figure.savefig(path)


def _headline(figure: Figure, visit: WallVisit, measures: WallMeasures) -> None:
    who = "an emulated Torsio knob" if visit.truth is not None else f"Torsio knob {visit.device}"
    stiffness = visit.wall_stiffness_nm_per_rad * 1e3 * np.pi / 180
    text = (
        f"A hand turns {who} into a virtual wall of {stiffness:.0f} mN·m per degree, holds, and "
        "comes out again. Motor and brake share the work of pushing back. The torque stays within "
        f"{100 * measures.tracking_rms_in:.1f} % of the wall's on the way in and "
        f"{100 * measures.tracking_rms_out:.1f} % on the way out (RMS, of the peak)."
    )
    headline(figure, "A wall you can feel", text, width=146, left=0.055)


def _at(time: Array, values: Array, when: float) -> float:
    return float(np.interp(when, time, values))


def _shade_visit(axes: Axes, visit: WallVisit) -> tuple[float, float]:
    """Mark the time spent inside the wall."""
    way_in, way_out = phases(visit)
    begin, end = visit.time_s[way_in.start], visit.time_s[way_out.stop - 1]
    axes.axvspan(begin, end, color=WALL_FILL, lw=0, zorder=0)
    return float(begin), float(end)


def _position(axes: Axes, visit: WallVisit) -> None:
    angle, wall = np.degrees(visit.angle_rad), np.degrees(visit.wall_angle_rad)
    time = visit.time_s
    top = float(angle.max()) * 1.22
    bottom = min(0.0, float(angle.min())) - 0.3
    axes.set_title("Where the knob is")
    axes.axhspan(wall, top, facecolor=WALL_FILL, edgecolor="#d2d2d2", hatch="///", lw=0, zorder=0)
    axes.axhline(wall, color=BLACK, lw=1.6)
    axes.plot(time, angle, color=BLUE)
    axes.set_xlim(0, time[-1])
    axes.set_ylim(bottom, top)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("knob angle (degrees)")
    edge = 0.985 * time[-1]
    label(axes, edge, top - 0.3, "inside the wall", BLACK, ha="right", va="top")
    label(axes, edge, wall + 0.12, "its surface", BLACK, ha="right", va="bottom")
    label(axes, 0.015 * time[-1], wall - 0.12, "free", GREY, va="top")
    way_in, way_out = phases(visit)
    start, arrive = time[way_in.start], time[way_in.stop - 1]
    leave, end = time[way_out.start], time[way_out.stop - 1]
    middle = 0.5 * (start + arrive)
    label(axes, middle - 0.03, _at(time, angle, middle) + 0.2, "pushing in", BLUE, ha="right")
    label(axes, 0.5 * (arrive + leave), float(angle.max()) + 0.4, "holding", BLUE, ha="center")
    middle = 0.5 * (leave + end)
    label(axes, middle + 0.05, _at(time, angle, middle) + 0.2, "coming out", BLUE)
    _caption(
        axes,
        "The knob turns freely until it meets the wall, gives way by a few degrees under the hand "
        "and leaves the wall again without sticking.",
    )


def _torques(axes: Axes, visit: WallVisit) -> None:
    time = visit.time_s
    _, end = _shade_visit(axes, visit)
    truth = visit.truth
    spring = visit.spring_torque_nm if truth is None else truth["spring_torque_nm"]
    brake = visit.brake_capacity_nm if truth is None else truth["brake_capacity_nm"]
    desired, motor = -1e3 * visit.desired_torque_nm, -1e3 * visit.motor_command_nm
    spring, brake = -1e3 * spring, 1e3 * brake
    axes.set_title("Who pushes back")
    axes.axhline(0, color=GREY, lw=0.8)
    axes.plot(time, brake, color=GREEN, lw=1.5, ls=(0, (5, 1.5)))
    axes.plot(time, spring, color=ORANGE)
    axes.plot(time, motor, color=BLUE)
    axes.plot(time, desired, color=BLACK, lw=2.2)
    axes.set_xlim(0, time[-1])
    peak = float(desired.max())
    axes.set_ylim(min(float(spring.min()), 0) - 0.08 * peak, 1.18 * peak)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("torque against the push (mN·m)")
    way_in, way_out = phases(visit)
    hold = 0.5 * (time[way_in.stop - 1] + time[way_out.start])
    label(axes, hold, 1.07 * peak, "wanted by the wall", BLACK, ha="center")
    label(axes, hold, _at(time, motor, hold) + 0.08 * peak, "motor", BLUE, ha="center")
    label(axes, hold, _at(time, spring, hold) - 0.09 * peak, "shaft spring", ORANGE, ha="center")
    label(
        axes,
        end + 0.01,
        0.2 * peak,
        "what the\nbrake can\nhold",
        GREEN,
    )
    axes.annotate(
        "",
        xy=(end - 0.06, _at(time, brake, end - 0.06)),
        xytext=(end + 0.01, 0.17 * peak),
        arrowprops={"arrowstyle": "-", "color": GREEN, "lw": 1.0},
    )
    _caption(
        axes,
        "Motor and shaft spring together give the wall's torque. On the way in the brake holds the "
        "spring's far end. On the way out it lets go, and the motor takes over.",
    )


def _loop(axes: Axes, visit: WallVisit, measures: WallMeasures) -> None:
    angle = visit.angle_rad if visit.truth is None else visit.truth["angle_rad"]
    degrees = np.degrees(angle)
    wall = np.degrees(visit.wall_angle_rad)
    felt, ideal = -1e3 * visit.rendered_torque_nm, -1e3 * visit.ideal_torque_nm
    way_in, way_out = phases(visit)
    axes.set_title("What the hand feels")
    deepest = float(degrees.max())
    axes.axvspan(wall, deepest * 1.06, color=WALL_FILL, lw=0, zorder=0)
    order = np.argsort(degrees)
    axes.plot(degrees[order], ideal[order], color=BLACK, lw=1.8, ls=(0, (4, 2)))
    axes.plot(degrees[: way_in.stop], felt[: way_in.stop], color=BLUE)
    axes.plot(degrees[way_out.start :], felt[way_out.start :], color=ORANGE)
    peak = float(ideal.max())
    span = (deepest - wall, peak)
    axes.set_xlim(min(0.0, float(degrees.min())) - 0.05, deepest * 1.04)
    axes.set_ylim(min(float(felt.min()), 0.0) - 0.06 * peak, 1.15 * peak)
    axes.set_xlabel("knob angle (degrees)")
    axes.set_ylabel("torque against the push (mN·m)")
    label(axes, wall + 0.36 * span[0], 0.62 * span[1], "pushing in", BLUE, ha="center")
    label(axes, wall + 0.72 * span[0], 0.98 * span[1], "the ideal wall", BLACK, ha="center")
    label(axes, wall - 0.03 * deepest, 0.97 * peak, "free", GREY, ha="right")
    label(axes, wall + 0.015 * deepest, 0.97 * peak, "in the wall", GREY)
    # The torque gap, where it is widest.
    missing = (ideal - felt)[way_out]
    worst = way_out.start + int(np.argmax(missing))
    # The texts stay within the panel even if that is at the very bottom of the wall.
    x = min(float(degrees[worst]) + 0.04 * span[0], wall + 0.76 * span[0])
    label(axes, x, float(felt[worst]) - 0.08 * peak, "coming out", ORANGE)
    axes.annotate(
        f"torque gap: {1e3 * measures.torque_gap_nm:.0f} mN·m missing\nwhile the brake lets go",
        xy=(float(degrees[worst]), float(0.5 * (felt[worst] + ideal[worst]))),
        xytext=(min(float(degrees[worst]), wall + 0.72 * span[0]) - 0.08 * span[0], 0.12 * peak),
        color=BLACK,
        ha="center",
        va="center",
        arrowprops={"arrowstyle": "-", "color": BLACK, "lw": 1.0},
    )
    _caption(
        axes,
        "The further the knob is pressed into the wall, the harder it pushes back; a perfect "
        "device would follow the dashed line both ways.",
    )


def _sensor(axes: Axes, visit: WallVisit, measures: WallMeasures) -> None:
    time = visit.time_s
    _shade_visit(axes, visit)
    sensed = -1e3 * visit.spring_torque_nm
    axes.set_title("The torque sensor that is not there")
    axes.axhline(0, color=GREY, lw=0.8)
    peak = float(np.abs(sensed).max())
    if visit.truth is not None:
        true = -1e3 * visit.truth["spring_torque_nm"]
        axes.plot(time, true, color=ORANGE, lw=4.5, alpha=0.45)
        rising = int(np.argmax(true > 0.75 * true.max()))
        x, y = float(time[rising]) - 0.04, float(true[rising])
        label(axes, x, y, "true shaft torque", ORANGE, ha="right", va="bottom")
    axes.plot(time, sensed, color=PURPLE, lw=1.5)
    middle = 0.3 * time[-1]
    x, y = middle + 0.02 * time[-1], _at(time, sensed, middle) - 0.1 * peak
    label(axes, x, y, "sensed by the knob", PURPLE, va="top")
    axes.set_xlim(0, time[-1])
    axes.set_ylim(min(float(sensed.min()), 0) - 0.1 * peak, 1.25 * peak)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("shaft torque (mN·m)")
    if measures.sensor_rms_nm is None:
        _caption(
            axes,
            "The knob has no torque sensor. It computes the torque from the twist of its slightly "
            "springy shaft. On real hardware the true torque is not known.",
        )
    else:
        _caption(
            axes,
            "The knob has no torque sensor: it infers the torque from how its slightly springy "
            f"shaft twists, here to within {1e3 * measures.sensor_rms_nm:.1f} mN·m (RMS).",
        )
