"""Commands of `torsio` about recordings: record, export, replay, report."""

from __future__ import annotations

import sys
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

import typer

import torsio
from torsio import bug_report, screen
from torsio.commands.shared import Device, choose, complain, opened, plainly, value_of
from torsio.emulated import selects_emulated
from torsio.knob_configuration import CONFIGS
from torsio.screen import err, line, out

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
    paced = not selects_emulated(choose(device)) or duration_s is None
    with opened(device, err, torsio.EmulatorOptions(paced=paced, log_inputs=True)) as knob:
        recording = knob.record_to(file)
        try:
            knob.sleep(1e9 if duration_s is None else duration_s)
        except KeyboardInterrupt:
            err.print("torsio: the recording ends here")
        finally:
            recording.close()
        lost = knob.statistics().samples_lost
    out.print(f"{recording.samples} samples, {lost} lost")
    line(out, f"recording  {file}")


def export_command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A recording.")],
    table: Annotated[Path, typer.Argument(metavar="TABLE", help="Ends in .csv or .parquet.")],
) -> None:
    """Write the telemetry of a recording as a table, one row a sample."""
    recorded = torsio.load(file)
    recorded.save(table)
    if not recorded.whole:
        err.print("torsio: the recording was torn; its end is missing")
    line(out, f"{len(recorded.telemetry)} rows  {table}")


def _changes(given: list[str]) -> dict[str, Any]:
    """Read NAME=VALUE by the kind of the field."""
    kinds = {
        field.name: type(field.default) for config in CONFIGS.values() for field in fields(config)
    }
    changes: dict[str, Any] = {}
    for pair in given:
        name, equals, text = pair.partition("=")
        if not equals or ("." not in name and name not in kinds):
            raise torsio.Error(
                f"--set takes NAME=VALUE, a field of the configuration, or one of an effect as in "
                f"wall.stiffness_nm_per_rad, not {pair!r}; `torsio config get` shows the fields"
            )
        changes[name] = value_of(name, text, kinds.get(name, float))
    return changes


def replay_command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A recording.")],
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="To change: law=motor_only, wall.stiffness_nm_per_rad=0.7; may be repeated.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Run the inputs of a recording through this version's firmware again, and compare.

    Ends with 0 if all samples and answers are the same to the bit, or if something was to change.
    """
    recorded = torsio.load(file)
    wanted = _changes(changes or [])
    if recorded.inputs and not recorded.has_all_inputs:
        err.print(
            "torsio: its inputs do not begin at power-up, because an earlier recording of the same "
            "knob has those: it is replayed from the counts in the telemetry",
        )
    replayed = torsio.replay(recorded, **wanted)
    source = "inputs of the emulated device" if replayed.from_inputs else "counts in the telemetry"
    out.print(
        f"{len(replayed.recorded)} samples and {replayed.answers} answers, from the {source}",
    )
    if replayed.identical:
        out.print("the same, to the bit")
        return
    line(out, f"first difference: {replayed.first_difference}")
    differences = screen.table("largest difference", "", words=1)
    for name, value in replayed.largest_differences().items():
        differences.add_row(name, f"{value:.6g}")
    out.print(differences)
    if not wanted and replayed.from_inputs:
        version = recorded.metadata["versions"].get("torsio", "another version")
        complain(f"not the same: recorded with {version}, replayed with {torsio.__version__}")
        raise typer.Exit(1)


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
        err.print("torsio: no knob could be recorded; doctor.json says why")
    sys.stdout.write(f"report  {file} ({', '.join(names)})\n")


def add_to(app: typer.Typer) -> None:
    """Add the commands."""
    app.command("record")(plainly(record_command))
    app.command("export")(plainly(export_command))
    app.command("replay")(plainly(replay_command))
    app.command("report")(plainly(report_command))
