"""Methods of the printed classes of effects: show themselves."""

from __future__ import annotations

import html
from dataclasses import replace
from math import pi
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from torsio import _torsio
from torsio._torsio.core import MotionParams, MotionState, Scene, SceneState, evaluate_scene_record
from torsio.common import checks, notebook
from torsio.common.extras import need_matplotlib
from torsio.errors import InvalidArgument
from torsio.printed.config import EMULATED_CONTROL_PERIOD_NS, ControlConfig
from torsio.printed.plant import PlantParams

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FELT_IN_MOTION = ("Damper", "Friction", "Impact", "Inertia")
_POINTS, _MARGIN_RAD, _SHOWN_S = 481, 0.5, 1.0


class EffectMethods(checks.ByName):
    """An effect's picture: its torque over the angle or over time."""

    __slots__ = ()

    def plot(self) -> Figure:
        """Draw the torque on the knob over the angle; of an effect with a timing, over time.

        A notebook shows the figure; ``savefig(path)`` writes it. Needs the extra ``plot``.
        """
        if type(self).__name__ in _FELT_IN_MOTION:
            raise InvalidArgument(f"{type(self).__name__} gives torque in motion alone")
        need_matplotlib()
        from torsio.common.plots import plot_curve

        return plot_curve(*self._course(), "torque on the knob, N m")

    def _repr_html_(self) -> str:
        words = f"<code>{html.escape(repr(self))}</code>"
        if type(self).__name__ in _FELT_IN_MOTION:
            return words
        try:
            return words + notebook.curve(*self._course(), "torque, N m")
        except InvalidArgument as error:  # ranges are asked when it is played, or drawn
            return f"{words}<p>{html.escape(str(error))}</p>"

    def _course(self) -> tuple[Any, Any, str]:
        """Give angle or time and the torque there, by the device's own code."""
        if hasattr(self, "timing"):
            ticks = round(_SHOWN_S * 1e9 / EMULATED_CONTROL_PERIOD_NS)
            time_s = np.arange(ticks) * 1e-9 * EMULATED_CONTROL_PERIOD_NS
            return time_s, _torque_nm(self, np.zeros(ticks)), "time, s"
        at = [getattr(self, name, 0.0) for name in ("angle_rad", "lower_rad", "upper_rad")]
        last_rad = max(at) + getattr(self, "span_rad", 0.0)
        angle_rad = np.linspace(min(at) - _MARGIN_RAD, last_rad + _MARGIN_RAD, _POINTS)
        return angle_rad, _torque_nm(self, angle_rad), "angle, rad"


def _torque_nm(effect: EffectMethods, angle_rad: Any) -> Any:
    if hasattr(effect, "damping_nm_s_per_rad"):
        effect = replace(effect, damping_nm_s_per_rad=0.0)  # type: ignore[type-var]
    plant = PlantParams()
    told = SimpleNamespace(
        plant=plant,
        actuator=None,
        shaft=None,
        control=ControlConfig(),
        control_period_ns=EMULATED_CONTROL_PERIOD_NS,
        scene=effect,
    )
    configs = 3
    scene = Scene(_torsio.emulator.loop_reports(told)[configs:])  # type: ignore[arg-type]
    # The first count is where the knob is at 0.
    counts = np.round(np.append(0.0, angle_rad) * plant.counts_per_rev / (2.0 * pi))
    motion, state = MotionState(), SceneState()
    torque_nm = evaluate_scene_record(
        scene, state, MotionParams(), motion, counts.astype(np.int64).astype(np.uint32)
    )
    return torque_nm[1:]
