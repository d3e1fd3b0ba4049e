"""Commands of `torsio games` and `torsio config`: what a knob may do and is made of."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from torsio.commands import games
from torsio.commands.shared import (
    AsJson,
    Device,
    Seconds,
    opened,
    plainly,
    print_json,
    value_of,
    value_text,
)
from torsio.config_file import dump_config, load_config
from torsio.errors import InvalidArgument
from torsio.knob import Knob
from torsio.screen import err, out

__all__ = ["add_to"]


def games_command(
    context: typer.Context,
    device: Device = "",
    seconds: Seconds = None,
    as_json: AsJson = False,
) -> None:
    """Show the effects of games live: what each gives, how often it changes, who has the actuator.

    Ctrl-C ends it. With --json, or without a terminal, it shows one moment and ends.
    """
    if context.invoked_subcommand is not None:
        return
    with opened(device, err if as_json else out) as knob:
        if as_json:
            print_json(games.as_dict(games.measure(knob)))
        else:
            games.show(knob, out, seconds=seconds)


def games_set_command(
    context: typer.Context,
    device: Device = "",
    range_deg: Annotated[
        float | None, typer.Option("--range-deg", help="From end to end of the axis.")
    ] = None,
    gain: Annotated[
        float | None, typer.Option("--gain", help="On top of the games' own, 0 to 1.")
    ] = None,
    torque_max_nm: Annotated[
        float | None, typer.Option("--torque-max-nm", help="Of all effects together.")
    ] = None,
    spring_gain: Annotated[
        float | None, typer.Option("--spring-gain", help="1: full torque at the end of the axis.")
    ] = None,
    end_stiffness_nm_per_rad: Annotated[
        float | None,
        typer.Option("--end-stiffness", help="Of walls at the ends, in N m/rad; 0: none."),
    ] = None,
    join_updates: Annotated[
        bool | None,
        typer.Option("--join-updates/--hold-updates", help="Lines or steps between updates."),
    ] = None,
    enabled: Annotated[
        bool | None, typer.Option("--allow/--shut-out", help="Whether games get the actuator.")
    ] = None,
    personality: Annotated[
        str | None,
        typer.Option("--personality", help="game_controller or dial, from its next start on."),
    ] = None,
    dial_use: Annotated[
        str | None, typer.Option("--dial-use", help="Of a dial: wheel, pan or volume.")
    ] = None,
    dial_detents: Annotated[
        int | None, typer.Option("--dial-detents", help="Of a dial, in a turn.")
    ] = None,
    dial_torque_nm: Annotated[
        float | None, typer.Option("--dial-torque-nm", help="Of a dial's detents; 0: none.")
    ] = None,
) -> None:
    """Set a player's settings, and keep them on the knob. What is not named stays as it is."""
    changes: dict[str, float | bool | str] = {
        name: value
        for name, value in context.params.items()
        if name != "device" and value is not None
    }
    if not changes:
        raise typer.BadParameter("name at least one setting; see torsio games set --help")
    with opened(device, out) as knob:
        config = games.change(knob, changes)
    for name in changes:
        out.print(f"{name}  {value_text(name, getattr(config, name))}")


def _fields(knob: Knob, names: list[str]) -> dict[str, tuple[str, Any]]:
    """Give the configurations and the values of some fields, or all."""
    fields = {
        name: (part, value)
        for part, values in json.loads(dump_config(knob)).items()
        for name, value in values.items()
    }
    if unknown := [name for name in names if name not in fields]:
        raise InvalidArgument(
            f"no configuration has a field {unknown[0]!r}; `torsio config get` shows all"
        )
    return {name: fields[name] for name in names} if names else fields


def _show_fields(knob: Knob, names: list[str]) -> None:
    for name, (_, value) in _fields(knob, names).items():
        out.print(f"{name}  {value_text(name, value)}")


def config_get_command(
    names: Annotated[list[str] | None, typer.Argument(metavar="[FIELD]...")] = None,
    device: Device = "",
) -> None:
    """Show fields of the configuration, one a line; all unless some are named."""
    with opened(device, err) as knob:
        _show_fields(knob, names or [])


def config_set_command(
    assignments: Annotated[list[str], typer.Argument(metavar="FIELD=VALUE...")],
    device: Device = "",
) -> None:
    """Set fields, and keep them on the knob. Wiring takes effect at its next start."""
    pairs = [assignment.partition("=") for assignment in assignments]
    for name, equals, _ in pairs:
        if not equals:
            raise InvalidArgument(f"{name!r} is not of the form NAME=VALUE")
    with opened(device, err) as knob:
        now = _fields(knob, [name for name, _, _ in pairs])
        changes: dict[str, dict[str, Any]] = {}
        for name, _, text in pairs:
            part, value = now[name]
            changes.setdefault(part, {})[name] = value_of(name, text, type(value))
        load_config(knob, json.dumps(changes))
        _show_fields(knob, list(now))


def config_dump_command(device: Device = "") -> None:
    """Print the whole configuration as JSON, for `load`."""
    with opened(device, err) as knob:
        sys.stdout.write(dump_config(knob))


def config_load_command(file: Path, device: Device = "") -> None:
    """Set what a file of `dump` has, all or nothing, and keep it on the knob."""
    # What is no UTF-8 is no name of a field either, and told as that.
    text = file.read_text(encoding="utf-8", errors="replace")
    with opened(device, err) as knob:
        try:
            load_config(knob, text)
        except InvalidArgument as error:
            raise InvalidArgument(f"{file}: {error}") from None


def add_to(app: typer.Typer) -> None:
    """Add both groups."""
    about_games = typer.Typer(help="See what games do, and set what they may do.")
    about_games.callback(invoke_without_command=True)(plainly(games_command))
    about_games.command("set")(plainly(games_set_command))
    app.add_typer(about_games, name="games")
    config = typer.Typer(help="Read and set what a knob is made of.", no_args_is_help=True)
    config.command("get")(plainly(config_get_command))
    config.command("set")(plainly(config_set_command))
    config.command("dump")(plainly(config_dump_command))
    config.command("load")(plainly(config_load_command))
    app.add_typer(config, name="config")
