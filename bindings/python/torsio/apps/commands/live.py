"""Commands of `torsio` that show what a knob does: monitor and studio."""

from __future__ import annotations

import json
import math
import time
from contextlib import nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import RenderableType
from rich.live import Live
from rich.table import Table
from rich.text import Text

import torsio
from torsio.apps.commands.shared import AsJson, Device, Seconds, choose, opened, option, plainly
from torsio.common.documents import entry
from torsio.common.extras import lacking
from torsio.common.screen import err, out
from torsio.printed.statuses import FAULT_ADVICE
from torsio.studio.page import page_folder

__all__ = ["add_to", "monitor_table"]

_BAR_CELLS = 31
_FULL_TORQUE_NM = 0.1


def _bar(torque_nm: float) -> Text:
    """Draw a torque about a middle, 0.1 N m at either end."""
    middle = _BAR_CELLS // 2
    cells = round(max(-1.0, min(1.0, torque_nm / _FULL_TORQUE_NM)) * middle)
    left, right = (middle + min(cells, 0), middle + max(cells, 0))
    return Text(
        "".join(
            "|" if i == middle else "=" if left <= i <= right else "." for i in range(_BAR_CELLS)
        )
    )


def monitor_table(knob: torsio.Knob, samples: torsio.telemetry.Record) -> RenderableType:
    """Show a knob's state now, with its newest samples."""
    health, statistics = knob.health(), knob.statistics()
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column(min_width=16)
    table.add_column(min_width=14, justify="right")
    table.add_column()
    style = {"armed": "bold green", "fault": "bold red"}.get(health.state, "bold")
    table.add_row("state", Text(health.state, style=style), "")
    for fault in health.faults:
        words = Text(f"{fault}: {FAULT_ADVICE.get(fault, 'update the library')}")
        words.append(f"\nmore in {entry(fault)}", style=f"dim link {entry(fault)}")
        table.add_row("fault", "", words)
    if len(samples):
        newest = samples[-1]
        table.add_row("angle", f"{math.degrees(newest['angle_rad']):.2f} deg", "")
        table.add_row("speed", f"{newest['speed_rad_s']:.2f} rad/s", "")
        for title, name in (
            ("torque wanted", "desired_torque_nm"),
            ("motor command", "motor_command_nm"),
            ("brake capacity", "brake_capacity_nm"),
            ("spring, sensed", "spring_torque_nm"),
        ):
            value = float(newest[name])
            table.add_row(title, f"{1e3 * value:.1f} mN·m", _bar(value))
    energies = knob.energies()
    if energies.kept:
        told = ("motor", energies.motor_j), ("felt", energies.felt_j), ("brake", energies.brake_j)
        table.add_row(
            "energy", "", ", ".join(f"{name} {1e3 * value:+.2f} mJ" for name, value in told)
        )
        bound = energies.bound_nm_per_rad
        table.add_row("stiffest now", f"{bound:.1f} N·m/rad" if bound else "as asked", "")
    table.add_row("samples", f"{statistics.samples_received}", f"{statistics.samples_lost} lost")
    table.add_row("longest tick", f"{1e6 * health.tick_time_max_s:.1f} us", "")
    return table


def _monitor_json(knob: torsio.Knob, samples: torsio.telemetry.Record) -> None:
    """Print a line of JSON: the knob as it is now, and its newest sample."""
    newest = {name: samples[name][-1].item() for name in samples.dtype.names or () if len(samples)}
    told = {"health": asdict(knob.health()), "statistics": asdict(knob.statistics())}
    print(json.dumps({**told, "newest": newest or None}, allow_nan=False), flush=True)


def monitor_command(device: Device = "", seconds: Seconds = None, as_json: AsJson = False) -> None:
    """Show a knob live in the terminal, also over ssh. Ctrl-C ends it; the knob stays as it is.

    With --json it prints an object a line, twenty a second.
    """
    with opened(device, err, torsio.EmulatorOptions(paced=True)) as knob:
        end = math.inf if seconds is None else time.monotonic() + seconds
        knob.start_telemetry()
        live = None if as_json else Live(console=out, refresh_per_second=20)
        with live or nullcontext():
            while time.monotonic() < end:
                knob.sleep(0.05)
                samples = knob.read(max_samples=65536, timeout_s=0.0)
                if live is None:
                    _monitor_json(knob, samples)
                else:
                    live.update(monitor_table(knob, samples))


def studio_command(
    device: Device = "",
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="0 takes a free one.")] = 0,
    page: Annotated[Path | None, option("--page", "FOLDER", "A built page.")] = None,
) -> None:
    """Show and drive a knob in a browser: prints the address of a page on this machine.

    It is for browsers without WebHID. Ctrl-C ends it and disarms the knob.
    """
    try:
        from torsio.studio.server import serve
    except ModuleNotFoundError as error:
        raise torsio.Error(lacking("the studio", "studio", error)) from None

    def ready(address: str) -> None:
        print(f"studio  {address}", flush=True)

    serve(choose(device), page_folder(page), port, ready)


def add_to(app: typer.Typer) -> None:
    """Add the commands."""
    app.command("monitor")(plainly(monitor_command))
    app.command("studio")(plainly(studio_command))
