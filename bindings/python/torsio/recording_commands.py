"""Commands of `torsio` about recordings: record, export, report."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

import torsio
from torsio import bug_report
from torsio.command import Device, choose, err, is_emulated, opened, out, plainly

__all__ = ["add_to"]


def record_command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="To be written; ends in .mcap.")],
    device: Device = "",
    duration_s: Annotated[
        float | None,
        typer.Option("--seconds", min=0.1, help="End by itself; else Ctrl-C.", show_default=False),
    ] = None,
) -> None:
    """Record what a knob does to FILE, which `torsio.load`, Foxglove and PlotJuggler open.

    The file is whole up to the last second whatever happens. The knob is not armed by this.
    """
    paced = not is_emulated(choose(device)) or duration_s is None
    with opened(device, err, torsio.EmulatorOptions(paced=paced)) as knob:
        recording = knob.record_to(file)
        try:
            knob.sleep(1e9 if duration_s is None else duration_s)
        except KeyboardInterrupt:
            err.print("torsio: the recording ends here")
        finally:
            recording.close()
        lost = knob.statistics().samples_lost
    out.print(f"{recording.samples} samples, {lost} lost", highlight=False)
    out.print(f"recording  {file}", highlight=False, markup=False, soft_wrap=True)


def export_command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A recording.")],
    table: Annotated[Path, typer.Argument(metavar="TABLE", help="Ends in .csv or .parquet.")],
) -> None:
    """Write the telemetry of a recording as a table, one row a sample."""
    recorded = torsio.load(file)
    recorded.save(table)
    if not recorded.whole:
        err.print("torsio: the recording was torn; its end is missing", highlight=False)
    out.print(f"{len(recorded.telemetry)} rows  {table}", highlight=False, soft_wrap=True)


def report_command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="To be written; ends in .zip.")],
    device: Device = "",
    recording: Annotated[
        Path | None,
        typer.Option("--recording", metavar="FILE", help="Made before.", show_default=False),
    ] = None,
    duration_s: Annotated[
        float, typer.Option("--seconds", min=0.1, max=600.0, help="To record, unless one is given.")
    ] = 2.0,
) -> None:
    """Put what somebody needs to look into a fault into one FILE: doctor, versions, a recording.

    Nothing personal is in it; what is, it says itself.
    """
    names = bug_report.collect(choose(device), file, recording=recording, duration_s=duration_s)
    if "recording.mcap" not in names:
        err.print("torsio: no knob could be recorded; doctor.json says why", highlight=False)
    sys.stdout.write(f"report  {file} ({', '.join(names)})\n")


def add_to(app: typer.Typer) -> None:
    """Add the commands."""
    app.command("record")(plainly(record_command))
    app.command("export")(plainly(export_command))
    app.command("report")(plainly(report_command))
