"""Commands of `torsio` about recordings: record, export, replay, report."""

from __future__ import annotations

import sys
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

import typer

import torsio
from torsio.apps import bug_report
from torsio.apps.commands.shared import (
    AsJson,
    Device,
    assignment,
    choose,
    complain,
    opened,
    option,
    plainly,
    print_json,
    value_of,
)
from torsio.common import screen
from torsio.common.emulated import selects_emulated
from torsio.common.screen import err, line, out
from torsio.printed.config import CONFIGS
from torsio.recordings.replaying import Replayed

__all__ = ["add_to"]

_TOLD_EVERY_S = 0.25


def record_command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File to write; ends in .mcap.")],
    device: Device = "",
    duration_s: Annotated[
        float | None,
        option("--seconds", "S", "End after so long; otherwise Ctrl-C.", min=0.1, max=1e6),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Record a knob to FILE, for `torsio.load`, Foxglove and PlotJuggler.

    Whatever happens, the file is whole up to the last second. The knob is not armed.
    """
    paced = not selects_emulated(choose(device)) or duration_s is None
    with opened(device, err, torsio.EmulatorOptions(paced=paced, log_inputs=True)) as knob:
        recording = knob.record_to(file)
        try:
            _wait(knob, recording, duration_s)
        except KeyboardInterrupt:
            err.print("torsio: the recording ends here")
        finally:
            recording.close()
    lost = recording.samples_lost
    if as_json:
        print_json({"file": str(file), "samples": recording.samples, "samples_lost": lost})
        return
    out.print(f"{recording.samples} samples, {lost} lost")
    line(out, f"recording  {file}")


def _wait(knob: torsio.Knob, recording: torsio.RecordingFile, duration_s: float | None) -> None:
    """Let the recording go on, and say on a terminal how it does and how it ends."""
    err.print("recording; Ctrl-C ends it" + ("" if duration_s is None else " earlier"))
    left_s = 1e9 if duration_s is None else duration_s
    with err.status("") as status:
        while left_s > 0.0:
            ends = "" if duration_s is None else f", {left_s:.0f} s left"
            status.update(f"{recording.samples} samples, {recording.samples_lost} lost{ends}")
            slice_s = min(left_s, _TOLD_EVERY_S)
            knob.sleep(slice_s)
            left_s -= slice_s


def export_command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A recording.")],
    table: Annotated[
        Path, typer.Argument(metavar="TABLE", help="File to write; ends in .csv or .parquet.")
    ],
    separator: Annotated[
        str, typer.Option("--separator", help="Separator of columns in CSV.")
    ] = ",",
    decimal: Annotated[str, typer.Option("--decimal", help="Point or comma in CSV.")] = ".",
) -> None:
    """Write the telemetry of a recording as a table, one row a sample."""
    recorded = torsio.load(file)
    recorded.save(table, separator=separator, decimal=decimal)
    if not recorded.whole:
        err.print("torsio: the recording was torn; its end is missing")
    line(out, f"{len(recorded.telemetry)} rows  {table}")


def _changes(given: list[str]) -> dict[str, Any]:
    """Read FIELD=VALUE by the kind of the field."""
    kinds = {
        field.name: type(field.default) for config in CONFIGS.values() for field in fields(config)
    }
    changes: dict[str, Any] = {}
    for pair in given:
        name, text = assignment(pair)
        changes[name] = value_of(name, text, float if "." in name else kinds.get(name, str))
    return changes


def replay_command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A recording.")],
    changes: Annotated[
        list[str] | None,
        option(
            "--set",
            "FIELD=VALUE",
            "Change, as law=motor_only or wall.stiffness_nm_per_rad=0.7; may be repeated.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run the inputs of a recording through this version's firmware again, and compare.

    The exit status is 0 if all samples and answers are the same to the bit, or with --set.
    """
    recorded = torsio.load(file)
    wanted = _changes(changes or [])
    if recorded.inputs and not recorded.has_all_inputs:
        err.print(
            "torsio: its inputs do not begin at power-up; an earlier recording of the knob has "
            "those. The replay uses the counts in the telemetry",
        )
    replayed = torsio.replay(recorded, **wanted)
    differences = {} if replayed.identical else replayed.largest_differences()
    if as_json:
        print_json(
            {
                "identical": replayed.identical,
                "from_inputs": replayed.from_inputs,
                "samples": len(replayed.recorded),
                "answers": replayed.answers,
                "first_difference": replayed.first_difference,
                "largest_differences": differences,
            }
        )
    else:
        _print_replayed(replayed, differences)
    if not replayed.identical and not wanted and replayed.from_inputs:
        version = recorded.metadata["versions"].get("torsio", "another version")
        complain(f"not the same: recorded with {version}, replayed with {torsio.__version__}")
        raise typer.Exit(1)


def _print_replayed(replayed: Replayed, differences: dict[str, float]) -> None:
    source = "inputs of the emulated device" if replayed.from_inputs else "counts in the telemetry"
    out.print(
        f"{len(replayed.recorded)} samples and {replayed.answers} answers, from the {source}",
    )
    if replayed.identical:
        out.print("the same, to the bit")
        return
    line(out, f"first difference: {replayed.first_difference}")
    table = screen.table("largest difference", "", words=1)
    for name, value in differences.items():
        table.add_row(name, f"{value:.6g}")
    out.print(table)


def report_command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File to write; ends in .zip.")],
    device: Device = "",
    recording: Annotated[
        Path | None, option("--recording", "FILE", "An earlier recording.")
    ] = None,
    duration_s: Annotated[
        float, typer.Option("--seconds", min=0.1, max=600.0, help="Length of a new recording.")
    ] = 2.0,
    as_json: AsJson = False,
) -> None:
    """Make one FILE for a fault report: findings of doctor, versions, a recording.

    It has the serial number; no user, computer or folder, unless notes of the recording do.
    """
    names = bug_report.collect(choose(device), file, recording=recording, duration_s=duration_s)
    if "recording.mcap" not in names:
        err.print("torsio: no knob could be recorded; doctor.json says why")
    if as_json:
        print_json({"file": str(file), "contents": list(names)})
        return
    sys.stdout.write(f"report  {file} ({', '.join(names)})\n")


def add_to(app: typer.Typer) -> None:
    """Add the commands."""
    app.command("record")(plainly(record_command))
    app.command("export")(plainly(export_command))
    app.command("replay")(plainly(replay_command))
    app.command("report")(plainly(report_command))
