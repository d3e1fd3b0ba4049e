"""The paper's three scenarios in pictures, for somebody who has not read it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes

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
    caption,
    headline,
    label,
)
from torsio.telemetry import Record
from torsio_studies.common import Study
from torsio_studies.paper import runs

LAW_COLOR = {
    "paper": BLUE,
    "compensated": GREEN,
    "calibrated": PURPLE,
    "motor_only": GREY,
    "parallel": ORANGE,
}


def scenario_1(
    study: Study,
    examples: Mapping[float, Record],
    sweeps: Sequence[tuple[str, str, runs.Array, Sequence[runs.Bounces]]],
) -> None:
    """Traces of a calm and an unstable spring; bounces over stiffness, for several loops."""
    with study.figure("scenario_1", size=(13.5, 6.2)) as figure:
        headline(
            figure,
            "How stiff can a virtual spring be?",
            "The knob is spun up to 18 rad/s and let go; a virtual spring catches it. If motor and "
            "brake render the spring well, the swinging dies away within a few "
            "bounces. Beyond some "
            "stiffness the control loop feeds it instead.",
        )
        grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.25))
        figure.subplots_adjust(
            left=0.055, right=0.985, top=0.78, bottom=0.22, wspace=0.17, hspace=0.3
        )
        right = figure.add_subplot(grid[:, 1])
        for row, ((stiffness, rows), color) in enumerate(
            zip(examples.items(), (BLUE, RED), strict=True)
        ):
            left = figure.add_subplot(grid[row, 0])
            left.plot(rows["time_s"], np.degrees(rows["angle_rad"]), color=color, lw=1.4)
            word = "never stops" if row else "comes to rest"
            left.set_title(f"A spring of {stiffness:g} N·m/rad: the knob {word}")
            left.set_xlim(0, 1)
            left.set_ylim(-6, 12)
            left.set_ylabel("angle (degrees)")
            left.tick_params(labelbottom=row == 1)
        left.set_xlabel("time after the release (s)")
        caption(left, "The paper's law, at 1 kHz. Angle 0 is the middle of the spring.", width=70)

        right.set_title("How often the knob goes through the middle in 1 s")
        for name, color, swept, bounces in sweeps:
            crossings = [one.crossings for one in bounces]
            right.plot(swept, crossings, color=color, lw=1.8, label=name)
            limit = runs.largest_stable(swept, bounces)
            index = int(np.searchsorted(swept, limit))
            right.plot(limit, crossings[index], "o", color=color, ms=8)
        right.set_yscale("symlog", linthresh=10)
        right.set_yticks(
            [0, 2, 5, 10, 20, 50, 100, 200], ["0", "2", "5", "10", "20", "50", "100", "200"]
        )
        right.minorticks_off()
        right.axvline(runs.SHAFT_NM_PER_RAD, color=GREY, lw=1, ls=":")
        right.set_xscale("log")
        ticks = [0.5, 1, 2, 5, 10, 20, 40]
        right.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        right.set_xlabel("stiffness of the virtual spring (N·m/rad)")
        right.legend(frameon=False, fontsize=9.5, loc="upper left")
        label(right, 1.03 * runs.SHAFT_NM_PER_RAD, 0.6, "shaft's own", GREY, bold=False)
        caption(
            right,
            "A dot marks the last stiffness up to which every run came to rest. Faster control "
            "pushes the limit up, a delay of a single sample takes a good part of it "
            "away. With the "
            "motor alone the swinging is damped by friction only: more bounces, and a lower limit.",
            width=98,
        )


def scenario_2(study: Study, visits: Mapping[float, tuple[Record, runs.Push]]) -> None:
    """Torque over depth, in and out, mirrored at the deepest point, for each stiffness."""
    with study.figure("scenario_2", size=(13.5, 9.6), dpi=80) as figure:
        headline(
            figure,
            "Into virtual walls, and out again",
            "A hand pushes the knob into a wall until it pushes back with 75 mN·m, "
            "holds, and comes "
            "out. Each panel reads from left to right: deeper and deeper up to the "
            "dashed line, then "
            "out again. What the hand feels should lie on what a perfect wall would give.",
        )
        axes = figure.subplots(2, 3).ravel()
        figure.subplots_adjust(
            left=0.055, right=0.985, top=0.84, bottom=0.145, wspace=0.16, hspace=0.42
        )
        for panel, (stiffness, (rows, push)) in zip(axes, visits.items(), strict=False):
            _mirrored(panel, stiffness, rows, push)
        axes[0].set_ylabel("torque against the hand (mN·m)")
        axes[3].set_ylabel("torque against the hand (mN·m)")
        names = (
            ("what the hand feels", BLUE, 2.4),
            ("a perfect wall", BLACK, 1.2),
            ("motor", ORANGE, 1.4),
            ("spring of the shaft", GREEN, 1.4),
        )
        handles = [
            axes[0].plot([], [], color=color, lw=width, ls="--" if color == BLACK else "-")[0]
            for _, color, width in names
        ]
        figure.legend(
            handles,
            [name for name, _, _ in names],
            loc="lower center",
            ncols=4,
            frameon=False,
            fontsize=11,
            bbox_to_anchor=(0.5, 0.045),
        )
        figure.text(
            0.05,
            0.018,
            "Where the shaft's spring is empty inside the wall, it begins to pull the wrong way "
            "until the brake has let go: the dip on the way out is the torque gap.",
            fontsize=10,
            color=TEXT,
        )


def _mirrored(panel: Axes, stiffness: float, rows: Record, push: runs.Push) -> None:
    depth = np.degrees(rows["angle_rad"] - runs.WALL_RAD)
    deepest = float(depth[push.first : push.last].max())
    turn = push.first + int(np.argmax(depth[push.first : push.last]))
    path = np.concatenate([depth[push.first : turn], 2 * deepest - depth[turn : push.last + 1]])
    span = slice(push.first, push.last + 1)
    ideal = -1e3 * runs.ideal_nm(rows, stiffness)[span]
    panel.axvline(deepest, color=GREY, lw=1, ls="--")
    panel.plot(path, -1e3 * rows["motor_torque_nm"][span], color=ORANGE, lw=1.4)
    panel.plot(path, -1e3 * rows["spring_torque_nm"][span], color=GREEN, lw=1.4)
    panel.plot(path, -1e3 * runs.rendered_nm(rows)[span], color=BLUE, lw=2.4)
    panel.plot(path, ideal, color=BLACK, lw=1.2, ls="--")
    panel.set_title(f"{1e3 * math.radians(stiffness):.0f} mN·m per degree")
    panel.set_xlim(0, 2 * deepest)
    panel.set_ylim(-25, 95)
    ticks = _round_ticks(deepest)
    places = [*ticks, *(2 * deepest - tick for tick in reversed(ticks))]
    panel.set_xticks(places, [f"{tick:g}" for tick in [*ticks, *reversed(ticks)]])
    panel.set_xlabel("depth in the wall (degrees): in, then out")
    text = (
        f"error {100 * push.tracking_rms_in:.1f} % in, {100 * push.tracking_rms_out:.1f} % out\n"
        f"largest gap {1e3 * push.torque_gap_nm:.0f} mN·m"
    )
    panel.text(0.03, 0.97, text, transform=panel.transAxes, fontsize=9, va="top", color=TEXT)


def _round_ticks(top: float) -> list[float]:
    step = next(s for s in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0) if top / s < 4.5)
    return [round(step * i, 3) for i in range(int(top / step) + 1) if step * i < top - 0.35 * step]


def scenario_3(study: Study, cuts: Mapping[str, tuple[Record, runs.Cut]], stiffness: float) -> None:
    """Knob position after the cut for each law; torques of the paper's law."""
    with study.figure("scenario_3", size=(13.5, 6.2)) as figure:
        headline(
            figure,
            "The string is cut: does the knob come out of the wall by itself?",
            f"A weight of {1e3 * runs.WEIGHT_NM:.0f} mN·m hangs on the knob and has "
            f"sunk into a wall "
            f"of {1e3 * math.radians(stiffness):.0f} mN·m per degree. At time 0 its string is cut. "
            "A brake can only hold: unless it lets go in time, the knob stays where it is.",
        )
        left, right = figure.subplots(1, 2)
        figure.subplots_adjust(left=0.055, right=0.985, top=0.79, bottom=0.22, wspace=0.15)
        names = {
            "paper": "the paper's law",
            "compensated": "the law 'compensated'",
            "calibrated": "the law 'calibrated'",
            "parallel": "brake and motor without sensor: stuck",
            "motor_only": "motor alone: thrown out",
        }
        left.set_title("Where the knob is")
        left.axhspan(0, 3, facecolor=WALL_FILL, edgecolor="#d2d2d2", hatch="///", lw=0, zorder=0)
        left.axhline(0, color=BLACK, lw=1.4)
        for law, (rows, _) in cuts.items():
            time = 1e3 * (rows["time_s"] - runs.CUT_S)
            depth = np.degrees(rows["angle_rad"] - runs.WALL_RAD)
            left.plot(time, depth, color=LAW_COLOR[law])
            level = float(np.interp(240.0, time, depth))
            label(left, 246, level + 0.22, names[law], LAW_COLOR[law], ha="right")
        left.set_xlim(-30, 250)
        left.set_ylim(-3.4, 2.6)
        left.set_xlabel("time after the cut (ms)")
        left.set_ylabel("depth in the wall (degrees)")
        label(left, 245, 2.4, "inside the wall", BLACK, ha="right", va="top")

        rows, _ = cuts["paper"]
        time = 1e3 * (rows["time_s"] - runs.CUT_S)
        right.set_title("Torques on the knob, the paper's law")
        right.axhline(0, color=GREY, lw=0.8)
        _torques(right, time, rows)
        right.set_xlim(-15, 80)
        right.set_xlabel("time after the cut (ms)")
        right.set_ylabel("out of the wall (mN·m)")
        right.legend(frameon=False, fontsize=10, loc="upper right")
        caption(
            right,
            "The shaft's spring throws the knob back and swings over. The sensor sees it pull the "
            "wrong way and lets the brake go, which takes its 60 ms, while the motor pushes out.",
            width=82,
        )
        caption(
            left,
            "Without the sensor the brake goes on holding half of the torque, and the knob sticks "
            "deep in the wall.",
            width=82,
        )


def _torques(axes: Axes, time: runs.Array, rows: Record) -> None:
    """Draw what is wanted, who gives it, and what the brake could hold, against the hand."""
    for name, sign, color, text in (
        ("desired_torque_nm", -1e3, BLACK, "wanted"),
        ("motor_torque_nm", -1e3, ORANGE, "motor"),
        ("spring_torque_nm", -1e3, GREEN, "spring of the shaft"),
        ("brake_capacity_nm", 1e3, PURPLE, "what the brake can hold"),
    ):
        axes.plot(time, sign * rows[name], color=color, lw=1.6, label=text)


def wall_events(
    study: Study, rows: Record, push: runs.Push, stiffness: float, indices: tuple[int, ...]
) -> None:
    """One visit to a soft wall, its events numbered in their order."""
    time = rows["time_s"]
    texts = (
        "the drag has wound the shaft: the\nbrake slips, and the knob is free",
        "it meets the wall: the brake\nis switched on, and lags",
        "the motor makes up most for what\nthe shaft does not carry yet",
        "at rest: motor and shaft\ncarry about half each",
        "the hand turns round: the shaft\nunwinds faster than the wall,\nthe motor fills up",
        "the shaft is empty: the sensor\nsees it, the brake is let go",
        "the brake has let go: the\nmotor alone pushes out",
        "out of the wall: no torque",
    )
    events = tuple(zip(indices, texts, strict=True))
    with study.figure("wall_events", size=(13.5, 8.6)) as figure:
        headline(
            figure,
            "A visit to a wall, in its order of events",
            f"A wall of {1e3 * math.radians(stiffness):.0f} mN·m per degree, softer than the shaft "
            "(50), with the paper's law.",
        )
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(1, 1.5))
        figure.subplots_adjust(left=0.06, right=0.985, top=0.885, bottom=0.205, hspace=0.08)
        depth = np.degrees(rows["angle_rad"] - runs.WALL_RAD)
        high = 1.25 * float(depth.max())
        top.axhspan(0, high, facecolor=WALL_FILL, edgecolor="#d2d2d2", hatch="///", lw=0, zorder=0)
        top.axhline(0, color=BLACK, lw=1.4)
        top.plot(time, depth, color=BLUE)
        top.set_ylim(1.1 * float(depth.min()), high)
        top.set_ylabel("depth of the knob (degrees)")
        bottom.axhline(0, color=GREY, lw=0.8)
        _torques(bottom, time, rows)
        bottom.set_ylabel("torque against the hand (mN·m)")
        bottom.set_xlabel("time (s)")
        bottom.set_xlim(0, float(time[push.last]) + 0.12)
        bottom.set_ylim(-22, 92)
        bottom.legend(frameon=False, loc="upper left", bbox_to_anchor=(0.0, 0.88), fontsize=10)
        for number, (index, text) in enumerate(events, 1):
            when = float(time[index])
            for panel in (top, bottom):
                panel.axvline(when, color=GREY, lw=0.8, ls=":")
            bottom.text(
                when,
                86,
                str(number),
                ha="center",
                va="center",
                color="white",
                fontweight="bold",
                fontsize=10,
                bbox={"boxstyle": "circle,pad=0.25", "facecolor": BLACK, "edgecolor": "none"},
            )
            column, line = (number - 1) % 4, (number - 1) // 4
            figure.text(
                0.06 + 0.235 * column,
                0.125 - 0.068 * line,
                f"{number}  {text}".replace("\n", "\n    "),
                fontsize=9.5,
                color=TEXT,
                va="top",
                linespacing=1.3,
            )
