"""`torsio stability`: which springs and dampers a knob can render, predicted and tried."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.progress import BarColumn, Progress, TextColumn

import torsio
from torsio import perception, stability
from torsio.apps.commands.shared import AsJson, Device, opened, option, plainly, print_json
from torsio.common.extras import need_matplotlib
from torsio.common.screen import err, line, out
from torsio.printed.config import ActuatorConfig, ControlConfig
from torsio.printed.told import StableStiffness

__all__ = ["add_to"]

_SPRINGS, _QUICK_SPRINGS = 41, 13
_DAMPINGS, _QUICK_DAMPINGS = 11, 3
# Around what is predicted, of a scene without a damper.
_SOFTEST, _STIFFEST = 0.2, 5.0
_MOST_DAMPING = 1.3


def _told(actuator: ActuatorConfig, control: ControlConfig, rate_hz: float) -> StableStiffness:
    # The knob itself knows only the law that it has.
    options = torsio.EmulatorOptions(control_rate_hz=rate_hz)
    with torsio.open("emulated", emulator=options) as knob:
        knob.configure(actuator)
        knob.configure(control)
        return knob.stable_stiffness()


def stability_command(
    device: Device = "",
    law: Annotated[
        str, typer.Option("--law", metavar="LAW", help="Law in place of the knob's.")
    ] = "",
    picture: Annotated[Path | None, option("--picture", "FILE", "PNG of the map.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="A coarse map.")] = False,
    as_json: AsJson = False,
) -> None:
    """Map the springs and dampers that a knob can render: predicted, and tried on an emulated one.

    The emulated knob follows the configuration. A real knob is only asked for it.
    """
    if picture is not None:
        need_matplotlib(picture)
    say = err if as_json else out
    with opened(device, say) as knob:
        actuator, control, rate_hz = (
            knob.actuator_config(), knob.control_config(), knob.info.control_rate_hz,
        )  # fmt: skip
        if law:
            control = replace(control, law=law)  # type: ignore[arg-type]
    told = _told(actuator, control, rate_hz)
    predicted = stability.boundary(actuator, control, rate_hz)
    most = _MOST_DAMPING * float(np.max(predicted[0], initial=1e-4))
    with Progress(
        TextColumn("thrown into springs"), BarColumn(), TextColumn("{task.completed}/{task.total}"),
        console=err, transient=True,
    ) as bar:  # fmt: skip
        task = bar.add_task("map")
        found = stability.measure(
            stability.plant_of(actuator), actuator, control, rate_hz,
            stiffness_nm_per_rad=told.stiffness_nm_per_rad
            * np.geomspace(_SOFTEST, _STIFFEST, _QUICK_SPRINGS if quick else _SPRINGS),
            damping_nm_s_per_rad=np.linspace(0.0, most, _QUICK_DAMPINGS if quick else _DAMPINGS),
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )  # fmt: skip
    stable = found.stable_to_nm_per_rad
    step_nm = perception.count_step_nm(told.stiffness_nm_per_rad, actuator.counts_per_rev)
    count_step = {
        "torque_nm": step_nm,
        "jnds": perception.torque_jnds(step_nm),
        "one_jnd_nm_per_rad": perception.smooth_stiffness_nm_per_rad(actuator.counts_per_rev),
    }
    if as_json:
        values = {
            "stable_stiffness": asdict(told),
            "count_step": count_step,
            "law": control.law,
            "control_rate_hz": rate_hz,
            "stiffness_nm_per_rad": found.stiffness_nm_per_rad.tolist(),
            "damping_nm_s_per_rad": found.damping_nm_s_per_rad.tolist(),
            "is_stable": found.is_stable.tolist(),
            "stable_to_nm_per_rad": stable.tolist(),
            "boundary": {
                "damping_nm_s_per_rad": predicted[0].tolist(),
                "stiffness_nm_per_rad": predicted[1].tolist(),
            },
        }
        print_json(values)
    else:
        say.print(
            f"told     springs up to {told.stiffness_nm_per_rad:.3g} N m/rad come to rest, "
            f"{stability.LIMITS[told.limited_by]}",
        )  # fmt: skip
        say.print(
            f"finger   there one count is {1e3 * step_nm:.2g} mN m, "
            f"{perception.text(count_step['jnds'])}; one JND up to "
            f"{count_step['one_jnd_nm_per_rad']:.3g} N m/rad at {actuator.counts_per_rev} counts",
        )
        for damping, upto in zip(found.damping_nm_s_per_rad, stable, strict=True):
            most_tried = "or more " if upto == found.stiffness_nm_per_rad[-1] else ""
            damper = f"with a damper of {1e3 * damping:.2f} mN m s/rad" if damping else "alone"
            say.print(f"tried    up to {upto:.3g} N m/rad {most_tried}{damper}")
    if picture is not None:  # last: it may fail
        from torsio.apps.stability_figure import save_figure

        title = f"Springs and dampers on this knob, law '{control.law}', {1e-3 * rate_hz:g} kHz"
        save_figure(found, predicted, told, title, picture)
        line(say, f"picture  {picture}")


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("stability")(plainly(stability_command))
