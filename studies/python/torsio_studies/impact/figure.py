"""The picture of the study `impact`."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from torsio.common.drawing import BLACK, BLUE, GREY, ORANGE, headline, label
from torsio_studies.common import Results, Study
from torsio_studies.impact import trials


def draw(study: Study, tap: trials.Tap, rows: Sequence[Results]) -> None:
    """Draw one tap in time and over frequency, and all taps against what was asked for."""
    with study.figure("knock", size=(13.5, 5.6)) as figure:
        headline(
            figure,
            "How a wall sounds hard",
            f"A finger taps a wall of {trials.WALL_NM_PER_RAD:.0f} N·m/rad at "
            f"{tap.speed_rad_s:.1f} rad/s, with the effect Impact (300 Hz, 5 ms) and without: "
            "acceleration of the knob. Dashed: what the sine that was asked for does to a free "
            "mass.",
        )
        left, middle, right = figure.subplots(1, 3, width_ratios=[1.5, 1.2, 1.0])
        figure.subplots_adjust(left=0.06, right=0.985, top=0.72, bottom=0.12, wspace=0.27)
        _in_time(left, tap)
        _over_frequency(middle, tap)
        _amplitudes(right, rows)


def _in_time(axes: Axes, tap: trials.Tap) -> None:
    time_ms = 1e3 * tap.time_s
    axes.plot(time_ms, tap.plain_rad_s2, color=GREY, lw=1.6)
    axes.plot(time_ms, tap.acceleration_rad_s2, color=BLUE, lw=1.6)
    together = tap.plain_rad_s2 + trials.closed_form_rad_s2(tap)
    axes.plot(time_ms, together, color=BLACK, lw=1.1, ls=(0, (4, 2)))
    axes.set_xlim(0, 25)
    axes.set_xlabel("time since contact (ms)")
    axes.set_ylabel("acceleration (rad/s²)")
    low, high = axes.get_ylim()
    label(axes, 13, low + 0.9 * (high - low), "with Impact", BLUE)
    label(axes, 13, low + 0.82 * (high - low), "without", GREY)


def _over_frequency(axes: Axes, tap: trials.Tap) -> None:
    for signal, colour, width, style in (
        (tap.plain_rad_s2, GREY, 1.6, "-"),
        (tap.acceleration_rad_s2, BLUE, 1.6, "-"),
        (trials.closed_form_rad_s2(tap), BLACK, 1.1, (0, (4, 2))),
    ):
        frequency_hz, values = trials.spectrum(signal)
        axes.plot(frequency_hz, values, color=colour, lw=width, ls=style)
    axes.axvline(tap.impact.frequency_hz, color=ORANGE, lw=0.9, zorder=0)
    axes.set_xlim(0, 800)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("frequency (Hz)")
    axes.set_ylabel("acceleration per Hz (rad/s)")
    label(axes, 320, 0.93 * axes.get_ylim()[1], "as set", ORANGE)


def _amplitudes(axes: Axes, rows: Sequence[Results]) -> None:
    asked = [row["expected_rad_s2"] for row in rows]
    found = [row["found"]["amplitude_rad_s2"] for row in rows]
    most = 1.1 * max(*asked, *found)
    axes.plot([0, most], [0, most], color=BLACK, lw=1.1, ls=(0, (4, 2)))
    axes.plot(asked, found, "o", color=BLUE, ms=6)
    axes.set_xlim(0, most)
    axes.set_ylim(0, most)
    axes.set_xlabel("asked for: strength · speed / inertia (rad/s²)")
    axes.set_ylabel("found at the knob (rad/s²)")
