"""The law and the actuator in pictures: characterisation, torques, limits, better laws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from torsio.common.drawing import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    RED,
    WALL_FILL,
    caption,
    headline,
    label,
)
from torsio.telemetry import Record
from torsio_studies.common import Study
from torsio_studies.paper import critical, runs


def characterisation(
    study: Study, linear: runs.Characterisation, hardened: runs.Characterisation
) -> None:
    """Motor torque over measured angle, with the fitted line."""
    with study.figure("characterisation", size=(13.5, 6.0)) as figure:
        headline(
            figure,
            "Measuring the shaft with the knob's own parts",
            "The brake holds with all its torque while the motor's torque rises "
            "slowly to its limit "
            "and falls again. The encoder counts how far the shaft gives way: the slope is the "
            "stiffness that the sensor needs, the distance between up and down is friction.",
        )
        axes = figure.subplots(1, 2, sharey=True)
        figure.subplots_adjust(left=0.055, right=0.985, top=0.78, bottom=0.2, wspace=0.06)
        titles = (
            "A shaft with a linear spring",
            "One that hardens beyond 15 mrad, as in the paper",
        )
        for panel, one, title in zip(axes, (linear, hardened), titles, strict=True):
            half = len(one.torque_nm) // 2
            panel.set_title(title)
            panel.axvspan(0, 1e3 * runs.LINEAR_RAD, color=WALL_FILL, lw=0, zorder=0)
            angle, torque = 1e3 * one.measured_rad, 1e3 * one.torque_nm
            panel.plot(angle[:half], torque[:half], color=BLUE, lw=1.6)
            panel.plot(angle[half:], torque[half:], color=ORANGE, lw=1.6)
            line = np.array([0.0, 0.03])
            fit = 1e3 * (one.offset_nm + one.slope_nm_per_rad * line)
            panel.plot(1e3 * line, fit, color=BLACK, lw=1.2, ls="--")
            panel.set_xlim(0, 31)
            panel.set_ylim(0, 100)
            panel.set_xlabel("measured angle of the knob (mrad)")
            label(panel, 0.6, 95, "fitted here", GREY, va="top", bold=False)
            middle = 0.55 * half
            at = int(middle)
            label(panel, angle[at] - 1.2, torque[at] + 4, "rising", BLUE, ha="right")
            at = half + int(0.55 * half)
            label(panel, angle[at] + 0.9, torque[at] - 4, "falling", ORANGE)
            error = 100 * (one.slope_nm_per_rad / runs.SHAFT_NM_PER_RAD - 1)
            caption(
                panel,
                f"Fitted: {one.slope_nm_per_rad:.3f} N·m/rad ({error:+.1f} % of the true "
                f"{runs.SHAFT_NM_PER_RAD} N·m/rad), offset {1e3 * one.offset_nm:.1f} mN·m: the "
                "friction on the knob, 6 mN·m.",
                width=90,
            )
        axes[0].set_ylabel("motor torque (mN·m)")


def torque_diagrams(study: Study, panels: Sequence[tuple[float, Record]], beta: float) -> None:
    """Torques over depth on the ideal plant, a stiff wall and a soft one."""
    with study.figure("torque_diagrams", size=(13.5, 6.6)) as figure:
        headline(
            figure,
            "Who carries the torque, in theory",
            "An ideal actuator, without lag, friction and drag, slides into a wall and out again. "
            f"Brake and shaft are meant to carry {100 * beta:.0f} % of the torque, the motor the "
            "rest. Solid: on the way in. Dashed: on the way out.",
        )
        axes = figure.subplots(1, len(panels), sharey=True)
        figure.subplots_adjust(left=0.055, right=0.985, top=0.79, bottom=0.24, wspace=0.06)
        for panel, (stiffness, rows) in zip(axes, panels, strict=True):
            ratio = stiffness / runs.SHAFT_NM_PER_RAD
            depth = 1e3 * (rows["angle_rad"] - 0.01)
            turn = int(np.argmax(depth))
            inside = depth > 1e-3
            for name, color, text in (
                ("desired_torque_nm", BLACK, "wanted"),
                ("motor_torque_nm", ORANGE, "motor"),
                ("spring_torque_nm", GREEN, "spring"),
            ):
                torque = -1e3 * rows[name]
                ways = ((slice(0, turn), "-"), (slice(turn, None), (0, (4, 2))))
                for way, dashes in ways:
                    keep = inside[way]
                    # Wide, where the spring's line lies upon the motor's.
                    wide = ratio < 1 and name == "motor_torque_nm" and dashes == "-"
                    width = 4.5 if wide else 1.8
                    panel.plot(
                        depth[way][keep], torque[way][keep], color=color, ls=dashes, lw=width
                    )
                where = int(0.6 * turn)
                if ratio < 1 and name == "motor_torque_nm":
                    out = turn + int(0.12 * turn)
                    label(panel, depth[out], torque[out] + 5, "motor, out", color)
                elif ratio < 1 and name == "spring_torque_nm":
                    label(panel, depth[where] - 19, 11, "motor and spring, in", BLACK)
                    out = turn + int(0.18 * turn)
                    label(panel, depth[out] + 1.5, torque[out] - 6, "spring, out", color)
                else:
                    label(panel, depth[where], torque[where] + 5, text, color, ha="right")
            panel.axhline(1e3 * runs.MOTOR_NM, color=ORANGE, lw=0.9, ls=":")
            panel.axhline(0, color=GREY, lw=0.8)
            label(
                panel,
                0.02 * depth.max(),
                1e3 * runs.MOTOR_NM + 4,
                "limit of the motor",
                ORANGE,
                bold=False,
            )
            panel.set_xlim(0, 1.04 * float(depth.max()))
            panel.set_ylim(-8, 140)
            panel.set_xlabel("depth in the wall (mrad)")
            which = "stiffer" if ratio > 1 else "softer"
            panel.set_title(f"Wall {which} than the shaft ({ratio:.1f} times)")
            caption(panel, _diagram_text(ratio, beta), width=88)
        axes[0].set_ylabel("torque against the hand (mN·m)")


def _diagram_text(ratio: float, beta: float) -> str:
    if beta * ratio > 1:
        return (
            "The shaft cannot wind as fast as its share grows. The motor fills up, and reaches its "
            "limit at the deepest point: this is the critical torque. In and out are the same."
        )
    return (
        "The shaft unwinds faster than the wall and is empty at "
        f"{1 - beta * ratio:.2f} of the depth. "
        "The motor has to fill up on the way out and reaches its limit just there; then the brake "
        "is off and the motor carries all."
    )


def critical_torques(study: Study, rows: Sequence[Mapping[str, Any]]) -> None:
    """Found and calculated critical torque over stiffness."""
    betas = sorted({float(row["beta"]) for row in rows})
    colors = dict(zip(betas, (GREY, GREEN, BLUE, ORANGE, PURPLE, RED), strict=False))
    with study.figure("critical_torque", size=(13.5, 6.4)) as figure:
        headline(
            figure,
            "The largest torque that is rendered without the motor at its limit",
            "For each stiffness of the wall and each share of the brake (beta): lines are the "
            "formula, dots were found by pushing an ideal actuator into a wall, deeper and deeper.",
        )
        axes = figure.subplots()
        figure.subplots_adjust(left=0.06, right=0.86, top=0.84, bottom=0.2)
        grid = np.geomspace(0.08, 5.0, 400)
        for beta in betas:
            line = [1e3 * critical.critical_torque(x * runs.SHAFT_NM_PER_RAD, beta) for x in grid]
            axes.plot(grid, line, color=colors[beta], lw=1.6)
            mine = [row for row in rows if row["beta"] == beta]
            axes.plot(
                [row["stiffness_ratio"] for row in mine],
                [1e3 * row["found_nm"] for row in mine],
                "o",
                color=colors[beta],
                ms=5.5,
                label=f"beta = {beta:g}",
            )
        axes.axhline(1e3 * runs.MOTOR_NM, color=BLACK, lw=0.9, ls=":")
        axes.axhline(1e3 * (runs.MOTOR_NM + runs.BRAKE_NM), color=BLACK, lw=0.9, ls=":")
        axes.axvline(1.0, color=BLACK, lw=0.9, ls=":")
        label(axes, 5.1, 1e3 * runs.MOTOR_NM, "motor alone", BLACK, bold=False)
        top = 1e3 * (runs.MOTOR_NM + runs.BRAKE_NM)
        label(axes, 5.1, top, "motor and\nbrake together", BLACK, bold=False)
        label(axes, 1.02, 76, "as stiff as the shaft", BLACK, bold=False)
        axes.set_xscale("log")
        ticks = [0.1, 0.2, 0.5, 1, 2, 5]
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
        axes.set_xlim(0.08, 5.0)
        axes.set_ylim(70, 205)
        axes.set_xlabel("stiffness of the wall / stiffness of the shaft")
        axes.set_ylabel("critical torque (mN·m)")
        axes.legend(frameon=False, loc="upper left", fontsize=10)
        caption(
            axes,
            "Soft walls are limited on the way out, where the shaft is empty; stiff "
            "ones on the way "
            "in, where the shaft winds too slowly. A large beta is limited by the "
            "brake's own torque, "
            "which the paper leaves out.",
            width=150,
        )


def better(study: Study, rows: Sequence[Mapping[str, Any]]) -> None:
    """Bars: error out, gap and sensor error for the paper's law and better ones."""
    with study.figure("better", size=(13.5, 5.2)) as figure:
        headline(
            figure,
            "Better than the paper",
            "The same visit to a wall of 30 mN·m per degree, with one change after the other.",
        )
        axes = figure.subplots(1, 3, sharey=True)
        figure.subplots_adjust(left=0.27, right=0.985, top=0.78, bottom=0.13, wspace=0.08)
        names = [str(row["variant"]) for row in rows]
        places = np.arange(len(names))[::-1]
        columns = (
            ("tracking_rms_out", 100, "error, way out (% of the peak)", BLUE),
            ("torque_gap_nm", 1e3, "largest missing torque (mN·m)", ORANGE),
            ("sensor_rms_nm", 1e3, "error of the sensor (mN·m)", GREEN),
        )
        for panel, (key, factor, title, color) in zip(axes, columns, strict=True):
            values = [factor * float(row[key]) for row in rows]
            panel.barh(places, values, color=color, height=0.62)
            for place, value in zip(places, values, strict=True):
                label(panel, value + 0.01 * max(values), place, f"{value:.1f}", BLACK, bold=False)
            panel.set_xlim(0, 1.16 * max(values))
            panel.set_title(title, fontsize=11)
            panel.grid(visible=False, axis="y")
            panel.set_yticks(places, names)
