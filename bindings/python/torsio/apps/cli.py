"""The `torsio` command."""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table
from rich.text import Text

import torsio
from torsio.apps import doctor
from torsio.apps.commands import (
    calibrate,
    demo,
    firmware,
    games,
    live,
    orders,
    other,
    recordings,
    settings,
    stability,
    trade,
)
from torsio.apps.commands.shared import (
    AsJson,
    Device,
    device_option,
    opened,
    option,
    plainly,
    print_json,
    value_text,
)
from torsio.common.extras import need_matplotlib
from torsio.common.screen import asks, err, out
from torsio.printed.config import CONFIGS
from torsio.virtual_knob import cli as virtual_knob

app: typer.Typer = typer.Typer(
    help="A USB knob that pushes back.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
demo.add_to(app)
games.add_to(app)
settings.add_to(app)
app.add_typer(firmware.app, name="firmware")
other.add_commands(app)


def _version(wanted: bool) -> None:
    if wanted:
        sys.stdout.write(f"torsio {torsio.__version__}\n")
        raise typer.Exit


@app.callback()
def main(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Find, ask and feel Torsio knobs: USB knobs that push back."""


@app.command("list")
@plainly
def list_command(as_json: AsJson = False) -> None:
    """List the knobs that can be opened; the emulated one is always there."""
    devices = torsio.list_devices()
    if as_json:
        print_json([asdict(device) for device in devices])
        return
    columns = ("path", "serial", "product", "board", "transport")
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("device", *columns[1:], "ready"):
        table.add_column(column, overflow="fold")
    for device in devices:
        table.add_row(*(getattr(device, name) for name in columns), device.problem or "yes")
    out.print(table)


@app.command("info")
@plainly
def info_command(device: Device = "", as_json: AsJson = False) -> None:
    """Show a knob's identity, state and configuration."""
    with opened(device, err if as_json else out) as knob:
        groups = {
            "info": asdict(knob.info),
            "health": asdict(knob.health()),
            "limits": asdict(knob.limits()),
            "clock": asdict(knob.clock()),
            **{f"{name}_config": asdict(getattr(knob, f"{name}_config")()) for name in CONFIGS},
        }
        words = calibrate.words_of(knob)
    if as_json:
        print_json(groups)
        return
    # A person reads each uncertainty beside its value.
    del groups["calibration_config"]
    groups["calibration"] = words
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column()
    table.add_column()
    for name, values in groups.items():
        table.add_row(f"[bold]{name.replace('_', ' ')}[/bold]")
        for key, value in values.items():
            table.add_row(f"  {key}", value_text(key, value))
    out.print(table)


@app.command("doctor")
@plainly
def doctor_command(
    device: Annotated[
        str,
        device_option(
            "Path, serial number, or 'emulated'. Default: every knob that is plugged in, "
            "or the emulated one if none is."
        ),
    ] = "",
    drift: Annotated[
        bool,
        typer.Option(
            "--drift",
            help="Also look for drift with a quick calibration. The knob of --device turns.",
        ),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Check the knobs, and say what to do about each problem.

    The exit status is 0 only if all is well. It takes three seconds a knob and changes nothing.
    With --drift it takes ten more, and the knob turns by itself: take your hand off.
    """
    if drift and not device:
        raise typer.BadParameter("it turns a knob: name it with --device", param_hint="--drift")
    reports = doctor.diagnose_any(device)
    if drift and reports[0].reaches_knob:
        reports[0].findings.append(doctor.examine_drift(device))
    ok = all(report.ok for report in reports)
    if as_json:
        print_json({"ok": ok, "reports": [report.as_dict() for report in reports]})
    else:
        for report in reports:
            _print_report(report)
    if not ok:
        raise typer.Exit(1)


def _print_report(report: doctor.Report) -> None:
    if report.device:
        out.print(report.device, style="bold", markup=False)
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column(min_width=7)
    table.add_column(min_width=10)
    table.add_column(overflow="fold")
    for finding in report.findings:
        verdict = "[green]ok[/green]" if not finding.advice else "[yellow]note[/yellow]"
        if not finding.ok:
            verdict = "[bold red]problem[/bold red]"
        table.add_row(verdict, finding.check.replace("_", " "), Text(finding.text))
        if finding.advice:
            table.add_row("", "", Text(f"-> {finding.advice}"))
            for link in finding.links:
                table.add_row("", "", Text(f"   more in {link}", style=f"dim link {link}"))
    out.print(table)


@app.command("calibrate")
@plainly
def calibrate_command(
    device: Device = "",
    drift: Annotated[
        bool, typer.Option("--drift", help="Only compare with the kept values, in 13 seconds.")
    ] = False,
    keep: Annotated[
        bool, typer.Option("--save", help="Keep the findings, without asking.")
    ] = False,
    picture: Annotated[
        Path | None, option("--picture", "FILE", "PNG of all fits and their residuals.")
    ] = None,
    ambient_c: Annotated[
        float | None, option("--ambient", "CELSIUS", "Ambient temperature, for the record.")
    ] = None,
    supply_v: Annotated[
        float | None, option("--supply", "VOLTS", "Voltage of the motor's supply, from a meter.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Measure the knob: friction, inertia, shaft, brake. Take your hand off; it turns by itself.

    Nothing is saved unless you say so. The exit status is 0 only if every step could be trusted
    and, with --drift, nothing has drifted.
    """
    if picture is not None:
        need_matplotlib(picture)
    say = err if as_json else out
    with opened(device, say, changes=keep) as knob:
        measured = calibrate.measure(knob, say, drift=drift, ambient_c=ambient_c, supply_v=supply_v)
        found = measured["calibration"]
        if as_json:
            changed = [asdict(drift) for drift in measured["changed"]]
            print_json(found.as_dict() | {"changed": changed})
        else:
            calibrate.show(knob, measured, out)
        if keep or (not drift and not as_json and asks(say, "Keep this on the device?")):
            calibrate.save(knob, found, say)
    if picture is not None:  # last: it may fail
        calibrate.draw(found, picture, say)
    if drift and measured["changed"]:
        raise typer.Exit(1)


app.command("emulate")(plainly(virtual_knob.emulate_command))
live.add_to(app)
orders.add_to(app)
recordings.add_to(app)
stability.add_to(app)
trade.add_to(app)
