"""The picture of the extremes: six that one can see."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.axes import Axes

from torsio.common.drawing import BLUE, GREY, RED, caption, headline, label
from torsio_studies.common import Study
from torsio_studies.extremes import dynamics, numbers
from torsio_studies.paper import runs

_caption = partial(caption, width=52, below=0.62)


def overview(study: Study) -> None:
    """Draw six extremes, naive in red, guarded in blue."""
    with study.figure("overview", size=(13.5, 10.4), dpi=78) as figure:
        headline(
            figure,
            "Where numbers break",
            "Red: how it is usually written. Blue: how the device and its emulator do "
            "it. Each panel "
            "is one extreme; the study has more of them, with numbers.",
        )
        axes = figure.subplots(2, 3)
        figure.subplots_adjust(
            left=0.06, right=0.985, top=0.86, bottom=0.13, wspace=0.27, hspace=0.62
        )
        _turning(axes[0, 0])
        _wrap(axes[0, 1])
        _brake(axes[0, 2])
        _free_air(axes[1, 0])
        _inertia(axes[1, 1])
        _precision(axes[1, 2])


def _turning(axes: Axes) -> None:
    hours = np.geomspace(0.01, 1000.0, 16)
    errors = np.array([numbers.turning_error_nm(float(h)) for h in hours])
    axes.set_title("Hours of turning")
    axes.loglog(hours, 1e3 * np.maximum(errors[:, 0], 1e-9), color=RED)
    axes.loglog(hours, 1e3 * np.maximum(errors[:, 1], 1e-9), color=BLUE)
    axes.axhline(1e3 * runs.SHAFT_NM_PER_RAD * runs.COUNT_RAD, color=GREY, lw=1, ls=":")
    label(axes, 2.0, 0.6, "one count of encoder", GREY, bold=False)
    label(axes, 3.0, 120, "float angle", RED)
    label(axes, 0.3, 3e-5, "integer counts", BLUE)
    axes.set_xlabel("hours at 10 turns a second")
    axes.set_ylabel("error of the sensor (mN·m)")
    axes.set_ylim(1e-7, 1e3)
    _caption(
        axes,
        "A 32-bit float angle loses the encoder's counts within minutes; the sensor, which adds up "
        "differences, goes with them.",
    )


def _wrap(axes: Axes) -> None:
    time, naive, guarded = numbers.wrap_traces(16)
    axes.set_title("A 16-bit counter wraps")
    axes.plot(time, 1e3 * naive, color=RED)
    axes.plot(time, 1e3 * guarded, color=BLUE)
    axes.set_xlim(0, 2.2)
    axes.set_xlabel("time (s), into a wall and out")
    axes.set_ylabel("sensed torque (mN·m)")
    wrap = int(np.argmax(np.abs(naive - guarded) > 1e-4))
    axes.axvline(time[wrap], color=GREY, lw=1, ls=":")
    axes.set_ylim(-38, 22)
    label(axes, float(time[wrap]) - 0.03, 19, "wraps here", GREY, ha="right", bold=False)
    label(axes, float(time[wrap]) + 0.05, 12, "plain difference", RED)
    label(axes, 1.28, -26, "modulo 2^16", BLUE)
    _caption(
        axes,
        "The plain difference jumps by 65,536 counts: the sensor believes that the "
        "spring pulls the "
        "other way, as hard as the brake holds just then.",
    )


def _brake(axes: Axes) -> None:
    euler, model, exact = dynamics.brake_step(2.5, ticks=12)
    ticks = np.arange(len(exact))
    axes.set_title("A brake faster than the tick")
    axes.plot(ticks, 1e3 * euler, "o-", color=RED, ms=4, lw=1.4)
    axes.plot(ticks, 1e3 * model, "o-", color=BLUE, ms=4, lw=1.4)
    axes.set_ylim(-400, 800)
    axes.set_xlabel("control ticks after the command")
    axes.set_ylabel("modelled brake torque (mN·m)")
    label(axes, 0.2, -300, "explicit Euler", RED)
    label(axes, 0.2, 640, "exponential:\n50 mN·m, at once", BLUE)
    _caption(
        axes,
        "The control period is 2.5 times the brake's time constant. The Euler step overshoots more "
        "each time; the exponential is right for any step.",
    )


def _free_air(axes: Axes) -> None:
    time, naive = dynamics.free_air(False)
    _, guarded = dynamics.free_air(True)
    axes.set_title("A flick in free air")
    axes.plot(time, naive / (2 * np.pi), color=RED)
    axes.plot(time, guarded / (2 * np.pi), color=BLUE)
    axes.set_xlim(0, 1)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("turns of the knob")
    top = float(naive[-1]) / (2 * np.pi)
    label(axes, 0.62, 0.78 * top, "law as printed", RED, ha="right")
    label(axes, 0.98, float(guarded[-1]) / (2 * np.pi) + 0.07 * top, "rests", BLUE, ha="right")
    _caption(
        axes,
        "With nothing to render the printed law still lets the motor answer to the sensor. If the "
        "sensor's floor is above friction and drag, the knob drives itself.",
    )


def _inertia(axes: Axes) -> None:
    ratios = np.array(dynamics.INERTIA_RATIOS)
    naive = np.array([dynamics.energy_error(float(r), "regularised") for r in ratios])
    exact = np.array([dynamics.energy_error(float(r), "exact") for r in ratios])
    axes.set_title("Light and heavy brakes")
    top = 1e6
    axes.loglog(ratios, np.clip(naive, 1e-16, top), "o-", color=RED, ms=4)
    axes.loglog(ratios, np.maximum(exact, 1e-16), "o-", color=BLUE, ms=4)
    axes.set_ylim(1e-17, 1e8)
    axes.set_xlabel("inertia of the brake / of the knob")
    axes.set_ylabel("energy from nothing (relative)")
    label(axes, 2e4, 1e4, "Runge-Kutta 4, one step a tick", RED, ha="right")
    label(axes, 1.0, 1e-9, "matrix exponential", BLUE, ha="center")
    _caption(
        axes,
        "Knob and brake swing freely on their spring without any loss, simulated in steps of 1 ms. "
        "(Values above 1e6 are drawn at 1e6.)",
    )


def _precision(axes: Axes) -> None:
    options = runs.push_options(runs.per_degree(30))
    time, difference = numbers.precision_trace(options, runs.PUSH_DURATION_S)
    axes.set_title("32 bits or 64?")
    axes.semilogy(time, np.maximum(1e3 * np.abs(difference), 1e-9), color=BLUE, lw=1.2)
    axes.axhline(1e3 * runs.SHAFT_NM_PER_RAD * runs.COUNT_RAD, color=GREY, lw=1, ls=":")
    axes.axhline(1e3 * numbers.turning_error_nm(1.0)[0], color=RED, lw=1.4)
    label(axes, 0.05, 0.6, "one count of the encoder", GREY, bold=False)
    label(axes, 2.3, 120, "float angle after 1 h", RED, ha="right")
    label(axes, 2.3, 1e-4, "the device's 32 bits", BLUE, ha="right")
    axes.set_xlim(0, 2.4)
    axes.set_ylim(1e-9, 1e3)
    axes.set_xlabel("time (s), into a wall and out")
    axes.set_ylabel("difference to 64 bits (mN·m)")
    _caption(
        axes,
        "The motor's torque of the device's 32-bit controller, against the same sources compiled "
        "with 64 bits, on the same counts.",
    )
