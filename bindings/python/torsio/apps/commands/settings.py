"""The commands `torsio config ...`: a knob's configuration."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from torsio.apps.commands.shared import Device, assignment, opened, plainly, value_of, value_text
from torsio.common.checks import no_field
from torsio.common.screen import err, out
from torsio.common.whole_file import text_of
from torsio.errors import InvalidArgument
from torsio.knob import Knob
from torsio.knob.config_file import dump_config, load_config
from torsio.printed.config import CONFIGS

__all__ = ["add_to"]


def _fields(knob: Knob, names: list[str]) -> dict[str, tuple[str, Any]]:
    """Give the configurations and the values of some fields, or all."""
    fields = {
        name: (part, value)
        for part, values in json.loads(dump_config(knob)).items()
        for name, value in values.items()
    }
    if unknown := [name for name in names if name not in fields]:
        raise InvalidArgument(no_field(unknown[0], CONFIGS.values()))
    return {name: fields[name] for name in names} if names else fields


def _show_fields(knob: Knob, names: list[str]) -> None:
    for name, (_, value) in _fields(knob, names).items():
        out.print(f"{name}  {value_text(name, value)}")


def config_get_command(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="FIELD", help="By default all.")
    ] = None,
    device: Device = "",
) -> None:
    """Show fields of the configuration, one a line. Without names it shows all."""
    with opened(device, err) as knob:
        _show_fields(knob, names or [])


def config_set_command(
    assignments: Annotated[list[str], typer.Argument(metavar="FIELD=VALUE", help="As law=paper.")],
    device: Device = "",
) -> None:
    """Set fields, and keep them on the knob. Wiring takes effect at its next start."""
    pairs = [assignment(each) for each in assignments]
    with opened(device, err, changes=True) as knob:
        now = _fields(knob, [name for name, _ in pairs])
        changes: dict[str, dict[str, Any]] = {}
        for name, text in pairs:
            part, value = now[name]
            changes.setdefault(part, {})[name] = value_of(name, text, type(value))
        load_config(knob, json.dumps(changes))
        _show_fields(knob, list(now))


def config_dump_command(device: Device = "") -> None:
    """Print the whole configuration as JSON, for `load`."""
    with opened(device, err) as knob:
        sys.stdout.write(dump_config(knob))


def config_load_command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Written by `dump`, or by hand.")],
    device: Device = "",
) -> None:
    """Set the values of a file from `dump`, all or nothing, and keep them on the knob."""
    text = text_of(file)
    with opened(device, err, changes=True) as knob:
        try:
            load_config(knob, text)
        except InvalidArgument as error:
            raise InvalidArgument(f"{file}: {error}") from None


def add_to(app: typer.Typer) -> None:
    """Add the group `config`."""
    config = typer.Typer(help="Read and set a knob's configuration.", no_args_is_help=True)
    config.command("get")(plainly(config_get_command))
    config.command("set")(plainly(config_set_command))
    config.command("dump")(plainly(config_dump_command))
    config.command("load")(plainly(config_load_command))
    app.add_typer(config, name="config")
