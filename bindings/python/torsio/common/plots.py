"""The pictures of `plot` methods; needs the extra `plot`."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from torsio.common.drawing import BLUE, GREEN, GREY, ORANGE, PURPLE, drawn

__all__ = ["plot_curve", "plot_samples"]


def plot_curve(x: Any, y: Any, x_label: str, y_label: str) -> Figure:
    """Draw one curve."""
    with drawn((8.0, 4.0), dpi=110, layout="constrained") as figure:
        axes = figure.subplots()
        axes.axhline(0.0, color=GREY, linewidth=1.0)
        axes.plot(x, y, color=BLUE)
        axes.set_xlabel(x_label)
        axes.set_ylabel(y_label)
    return figure


def plot_samples(log: Any) -> Figure:
    """Draw angle and torques of telemetry over time."""
    with drawn((9.0, 6.0), dpi=110, layout="constrained") as figure:
        above, below = figure.subplots(2, sharex=True)
        above.plot(log["time_s"], log["angle_rad"], color=PURPLE)
        above.set_ylabel("angle, rad")
        for name, colour, words in (
            ("desired_torque_nm", BLUE, "the scene asks"),
            ("motor_command_nm", ORANGE, "motor, commanded"),
            ("spring_torque_nm", GREEN, "shaft, sensed"),
        ):
            below.plot(log["time_s"], 1e3 * log[name], color=colour, label=words, linewidth=1.4)
        below.set_ylabel("torque on the knob, mN m")
        below.set_xlabel("time, s")
        below.legend(frameon=False, ncols=3)
    return figure
