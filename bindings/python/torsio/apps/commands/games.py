"""The commands `torsio games ...`: effects of games on a knob, and their permissions."""

from __future__ import annotations

import json
import math
import re
import time
from dataclasses import asdict, replace
from inspect import Parameter, Signature
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.live import Live
from rich.table import Table

from torsio.apps.commands.shared import (
    AsJson,
    Device,
    Seconds,
    opened,
    plainly,
    print_json,
    value_text,
)
from torsio.common.screen import err, line, out
from torsio.common.whole_file import keep_text, text_of, user_folder
from torsio.errors import InvalidArgument, Refused
from torsio.games import GameMonitor, GameReading
from torsio.knob import Knob
from torsio.knob.config_file import dump_config, load_config
from torsio.printed.config import GameConfig

__all__ = ["add_to", "as_dict", "change", "show"]

_PERIOD_S = 0.25
_OWNERS = {
    "none": "nobody",
    "sdk": "a program, over the SDK",
    "game": "a game or your own feel",
    "dial": "the dial that somebody turns",
}


def as_dict(reading: GameReading) -> dict[str, Any]:
    """Give a reading as JSON has it."""
    return {
        "status": asdict(reading.status)
        | {
            "updates_per_s": reading.updates_per_s,
            "clipped_share": reading.clipped_share,
            "asked_most_percent": reading.asked_most_percent,
        },
        "effects": [
            asdict(effect) | {"updates_per_s": rate}
            for effect, rate in zip(reading.effects, reading.effect_updates_per_s, strict=True)
        ],
    }


def _clipping(reading: GameReading, gain: float) -> str:
    """Say how far effects go beyond what all together get, and which gain they would fit with."""
    asked = reading.asked_most_percent
    if asked <= 100:
        return ""
    fits = math.floor(1e4 * gain / asked) / 100
    return (
        f"together, effects ask for up to {asked} % of their torque limit; "
        f"clipped {100 * reading.clipped_share:.0f} % of the time; "
        f"torsio games set --gain {fits:g} fits them in"
    )


def _table(reading: GameReading, gain: float) -> Table:
    status = reading.status
    notes = [f"actuator: {_OWNERS[status.owner]}", f"torque {1e3 * status.torque_nm:+.1f} mN·m"]
    notes.append(f"gain {100 * status.gain:.0f} %")
    notes.append(f"{reading.updates_per_s:.0f} updates/s")
    notes += ["paused by the game"] if status.paused else []
    notes += [] if status.enabled else ["switched off by the game"]
    table = Table(
        box=None,
        pad_edge=False,
        header_style="bold",
        title=", ".join(notes),
        title_justify="left",
        caption=_clipping(reading, gain) or None,
        caption_justify="left",
    )
    for column in ("effect", "kind", "state", "torque", "updates/s", "last update"):
        left = column in ("kind", "state")
        table.add_column(column, justify="left" if left else "right")
    for effect, rate in zip(reading.effects, reading.effect_updates_per_s, strict=True):
        silent = f"{effect.silent_s:.1f} s ago" if effect.silent_s < 65 else "over a minute ago"
        table.add_row(
            str(effect.block),
            effect.kind.replace("_", " "),
            effect.state.replace("_", " "),
            f"{1e3 * effect.torque_nm:+.1f} mN·m",
            f"{rate:.0f}",
            silent,
        )
    if not reading.effects:
        table.add_row("none")
    return table


def show(knob: Knob, console: Console, *, seconds: float | None) -> None:
    """Show what games do until the time is over, or Ctrl-C; without a terminal once."""
    monitor = GameMonitor(knob)
    monitor.read()
    gain = knob.game_config().gain
    end = None if seconds is None else time.monotonic() + seconds
    knob.sleep(_PERIOD_S)
    if not console.is_terminal:
        console.print(_table(monitor.read(), gain))
        return
    with Live(_table(monitor.read(), gain), console=console, auto_refresh=False) as live:
        while end is None or time.monotonic() < end:
            knob.sleep(_PERIOD_S)
            live.update(_table(monitor.read(), gain), refresh=True)


def measure(knob: Knob) -> GameReading:
    """Give what games do, with the rates of a quarter of a second."""
    monitor = GameMonitor(knob)
    monitor.read()
    knob.sleep(_PERIOD_S)
    return monitor.read()


def change(knob: Knob, changes: dict[str, float | bool | str]) -> GameConfig:
    """Set fields of the game configuration and keep them on the device.

    Raises
    ------
    Refused
        Somebody has the actuator.
    InvalidArgument
        A value is outside its range; nothing has changed.
    """
    config = replace(knob.game_config(), **changes)  # type: ignore[arg-type]
    owner = knob.health().owner
    if owner != "none":
        raise Refused(
            f"{_OWNERS[owner]} has the actuator: end it, let go, wait 2 s, and set it again"
        )
    knob.configure(config)
    knob.save()
    return config


def games_command(
    context: typer.Context,
    device: Device = "",
    seconds: Seconds = None,
    as_json: AsJson = False,
) -> None:
    """Show the effects of games live: torque, rate of updates, owner of the actuator.

    Ctrl-C ends it. With --json, or without a terminal, it shows one moment and ends.
    """
    if context.invoked_subcommand is not None:
        return
    with opened(device, err if as_json else out) as knob:
        if as_json:
            print_json(as_dict(measure(knob)))
        else:
            if knob.health().centre == "awaits_index":
                line(out, "middle   not found yet: turn the knob slowly, two turns")
            show(knob, out, seconds=seconds)


# Fields of `GameConfig`, each with its option and help.
_SETTINGS = {
    "range_deg": ("--range-deg", "Degrees from end to end of the axis."),
    "gain": ("--gain", "Factor on the games' own gain, 0 to 1."),
    "torque_max_nm": ("--torque-max-nm", "Limit of all effects together."),
    "spring_gain": ("--spring-gain", "1: full torque at the end of the axis."),
    "end_stiffness_nm_per_rad": (
        "--end-stiffness",
        "Stiffness of walls at the ends, in N m/rad; 0: none.",
    ),
    "join_updates": ("--join-updates/--hold-updates", "Join updates by lines, or hold each."),
    "torque_max_percent": ("--torque-max-percent", "Largest torque, % of the motor's."),
    "own_damper_percent": ("--own-damper", "A damper that is always felt, in %."),
    "own_friction_percent": ("--own-friction", "Friction that is always felt, in %."),
    "own_inertia_percent": ("--own-inertia", "An inertia that is always felt, in %."),
    "own_spring_percent": ("--own-spring", "A spring while no game plays, in %."),
    "constants_gain_percent": ("--constants-gain", "Gain of constant forces, in %."),
    "waves_gain_percent": ("--waves-gain", "Gain of waves, in %."),
    "springs_gain_percent": ("--springs-gain", "Gain of springs, in %."),
    "dampers_gain_percent": ("--dampers-gain", "Gain of dampers, in %."),
    "inertias_gain_percent": ("--inertias-gain", "Gain of inertias, in %."),
    "frictions_gain_percent": ("--frictions-gain", "Gain of frictions, in %."),
    "reversed": ("--reversed/--forward", "Axis, games' forces and dial the other way."),
    "enabled": ("--allow/--shut-out", "Let games use the actuator, or not."),
    "personality": ("--personality", "game_controller or dial, from the next start on."),
    "dial_use": ("--dial-use", "Use of a dial, such as wheel, volume or radial."),
    "dial_detents": ("--dial-detents", "Detents of a dial, in a turn."),
    "dial_torque_nm": ("--dial-torque-nm", "Torque of a dial's detents; 0: none."),
    "dial_coarse": ("--dial-coarse/--dial-fine", "Whole detents, or as the host asks."),
    "dial_fast_steps": ("--dial-fast-steps", "Steps of a fast detent; 1: as a slow one."),
    "remote_wakeup": ("--remote-wakeup/--no-remote-wakeup", "A turn wakes the computer."),
}


def games_set_command(device: str = "", **settings: Any) -> None:
    """Set a player's settings, and keep them on the knob. Settings that are not named stay."""
    changes = {name: value for name, value in settings.items() if value is not None}
    if not changes:
        raise typer.BadParameter("name at least one setting; see torsio games set --help")
    with opened(device, out, changes=True) as knob:
        config = change(knob, changes)
    for name in changes:
        out.print(f"{name}  {value_text(name, getattr(config, name))}")


def _keyword(name: str, annotation: Any, default: Any) -> Parameter:
    return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


def _set_options() -> Signature:
    """Give what typer makes the options of `games set` of."""
    config = GameConfig()
    options = [
        _keyword(
            name,
            Annotated[type(getattr(config, name)) | None, typer.Option(option, help=about)],
            None,
        )
        for name, (option, about) in _SETTINGS.items()
    ]
    return Signature([_keyword("device", Device, ""), *options])


games_set_command.__signature__ = _set_options()  # type: ignore[attr-defined]


ProfileName = Annotated[str, typer.Argument(metavar="NAME", help="Letters, digits, - and _.")]


def _profile(name: str) -> Path:
    if re.fullmatch(r"[A-Za-z0-9_-]{1,64}", name) is None:
        raise InvalidArgument(f"{name!r} is no profile's name: use letters, digits, - and _")
    return user_folder("games") / f"{name}.json"


def profile_save_command(name: ProfileName, device: Device = "") -> None:
    """Keep all that `games set` has set, under a name, on this computer."""
    with opened(device, err) as knob:
        settings = json.loads(dump_config(knob))["game_config"]
    path = _profile(name)
    keep_text(path, json.dumps({"game_config": settings}, indent=2) + "\n")
    out.print(f"kept {name}: {path}")


def profile_load_command(name: ProfileName, device: Device = "") -> None:
    """Set what was saved under a name, and keep it on the knob."""
    path = _profile(name)
    try:
        text = text_of(path)
    except FileNotFoundError:
        names = ", ".join(sorted(file.stem for file in path.parent.glob("*.json"))) or "none yet"
        raise InvalidArgument(f"{path}: no such profile; there are: {names}") from None
    with opened(device, err, changes=True) as knob:
        try:
            load_config(knob, text)
        except InvalidArgument as error:
            raise InvalidArgument(f"{path}: {error}") from None
    out.print(f"loaded {name}")


def add_to(app: typer.Typer) -> None:
    """Add the group `games`."""
    about_games = typer.Typer(help="Show effects of games, and set their permissions.")
    about_games.callback(invoke_without_command=True)(plainly(games_command))
    about_games.command("set")(plainly(games_set_command))
    profile = typer.Typer(help="Keep a player's settings by name.", no_args_is_help=True)
    profile.command("save")(plainly(profile_save_command))
    profile.command("load")(plainly(profile_load_command))
    about_games.add_typer(profile, name="profile")
    app.add_typer(about_games, name="games")
