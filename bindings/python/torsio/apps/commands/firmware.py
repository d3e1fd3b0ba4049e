"""`torsio firmware`: looks into a file, and puts it on a knob."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

import torsio
from torsio.apps.commands.shared import AsJson, device_option, option, plainly, print_json
from torsio.common.screen import asks, err, line, out
from torsio.common.whole_file import beside

__all__ = ["app"]

app: typer.Typer = typer.Typer(
    help="Look into firmware files, and put them on a knob.", no_args_is_help=True
)

FirmwareFile = Annotated[Path, typer.Argument(metavar="FILE", help="Ends in .uf2.")]


@app.command("show")
@plainly
def show_command(file: FirmwareFile, as_json: AsJson = False) -> None:
    """Check a file, and show its board, version and protocol."""
    found = {**asdict(torsio.read_firmware(file)), "path": str(file)}
    if as_json:
        print_json(found)
        return
    found["fingerprint"] = f"0x{found['fingerprint']:08x}"
    for name, value in found.items():
        line(out, f"{name}  {value}")


@app.command("update")
@plainly
def update_command(
    file: FirmwareFile,
    device: Annotated[
        str, device_option("Path or serial number; needed if more than one knob is plugged in.")
    ] = "",
    drive: Annotated[
        Path | None,
        option("--drive", "FOLDER", "Folder of the boot loader's drive, if it cannot be found."),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Do not ask.")] = False,
) -> None:
    """Put new firmware on a knob: check the file, disarm, copy, wait, and see that it runs.

    The saved configuration stays, unless the reports of the two releases differ. You are told
    first.
    """
    plan = torsio.prepare_update(
        file, device or None, drive=drive, say=lambda text: line(out, f"  {text}")
    )
    line(out, str(plan))
    if plan.loses_configuration:
        line(
            out,
            "its configuration will be lost, because the new firmware cannot read it. The knob "
            "then gives little torque until its parts are confirmed and its values known. `torsio "
            "config dump` of the old release keeps the values, but not how well they are known",
        )
    if not yes and not asks(err, "Write it?"):
        raise torsio.Error("nothing was changed; --yes does it without asking")
    done = torsio.carry_out(plan)
    line(
        out,
        f"{done.after.serial} runs firmware {done.after.firmware_version} of board "
        f"{done.after.board}, fingerprint 0x{done.after.fingerprint:08x}",
    )
    if done.kept:
        line(out, "its configuration is as before")
    elif done.kept is not None:
        kept = Path(f"torsio-{done.after.serial}.json")
        with beside(kept) as part:
            part.write_text(done.configuration, encoding="utf-8")
        line(
            out,
            "its configuration is the saved one; values that were not saved are in "
            f"{kept}, for `torsio config load`",
        )
    else:
        line(out, "look at its configuration: `torsio doctor` tells whether it holds the knob low")
