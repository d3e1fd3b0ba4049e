"""What `torsio games` shows and sets."""

from __future__ import annotations

import time
from dataclasses import asdict, replace
from typing import Any

from rich.console import Console
from rich.live import Live
from rich.table import Table

from torsio.config import GameConfig
from torsio.errors import Refused
from torsio.games import GameMonitor, GameReading
from torsio.knob import Knob

__all__ = ["as_dict", "change", "show"]

_PERIOD_S = 0.25
_OWNERS = {
    "none": "nobody",
    "sdk": "a program, over the SDK",
    "game": "a game",
    "dial": "the dial, which somebody turns,",
}


def as_dict(reading: GameReading) -> dict[str, Any]:
    """Give a reading as JSON has it."""
    return {
        "status": asdict(reading.status) | {"updates_per_s": reading.updates_per_s},
        "effects": [
            asdict(effect) | {"updates_per_s": rate}
            for effect, rate in zip(reading.effects, reading.effect_updates_per_s, strict=True)
        ],
    }


def _table(reading: GameReading) -> Table:
    status = reading.status
    notes = [f"actuator: {_OWNERS[status.owner]}", f"torque {1e3 * status.torque_nm:+.1f} mN·m"]
    notes.append(f"gain {100 * status.gain:.0f} %")
    notes.append(f"{reading.updates_per_s:.0f} updates/s")
    notes += ["paused by the game"] if status.paused else []
    notes += [] if status.enabled else ["switched off by the game"]
    table = Table(
        box=None, pad_edge=False, header_style="bold", title=", ".join(notes), title_justify="left"
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


def show(knob: Knob, out: Console, *, seconds: float | None) -> None:
    """Show what games do until the time is over, or Ctrl-C; without a terminal once."""
    monitor = GameMonitor(knob)
    monitor.read()
    end = None if seconds is None else time.monotonic() + seconds
    knob.sleep(_PERIOD_S)
    if not out.is_terminal:
        out.print(_table(monitor.read()))
        return
    with Live(_table(monitor.read()), console=out, auto_refresh=False) as live:
        while end is None or time.monotonic() < end:
            knob.sleep(_PERIOD_S)
            live.update(_table(monitor.read()), refresh=True)


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
        raise Refused(f"{_OWNERS[owner]} has the actuator: end it, wait a second, and set it again")
    knob.configure(config)
    knob.save()
    return config
