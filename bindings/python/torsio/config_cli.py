"""What `torsio config` reads, sets and keeps."""

from __future__ import annotations

import json
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

from torsio.config import ActuatorConfig, BoardConfig, ControlConfig, GameConfig
from torsio.errors import InvalidArgument, Refused
from torsio.knob import Knob
from torsio.knob_configuration import Config

__all__ = ["dump", "get", "load", "set_fields"]

_KINDS: dict[str, type[Config]] = {
    "actuator_config": ActuatorConfig,
    "control_config": ControlConfig,
    "board_config": BoardConfig,
    "game_config": GameConfig,
}


def _read(knob: Knob) -> dict[str, Config]:
    return {name: getattr(knob, name)() for name in _KINDS}


def dump(knob: Knob) -> dict[str, dict[str, Any]]:
    """Give the whole configuration, as `load` takes it."""
    return {name: asdict(config) for name, config in _read(knob).items()}


def get(knob: Knob, names: list[str]) -> dict[str, Any]:
    """Give some fields, or all.

    Raises
    ------
    InvalidArgument
        No configuration has such a field.
    """
    values = {name: value for part in dump(knob).values() for name, value in part.items()}
    if unknown := [name for name in names if name not in values]:
        raise InvalidArgument(
            f"no configuration has a field {unknown[0]!r}; `torsio config get` shows all"
        )
    return {name: values[name] for name in names} if names else values


def _value(name: str, text: str, now: Any) -> Any:
    """Read a value of the kind that the field has now."""
    try:
        if isinstance(now, bool):
            return {"on": True, "true": True, "off": False, "false": False}[text.lower()]
        return type(now)(text)
    except (KeyError, ValueError):
        wanted = {bool: "on or off", int: "a whole number", float: "a number"}[type(now)]
        raise InvalidArgument(f"{name} takes {wanted}, not {text!r}") from None


def set_fields(knob: Knob, assignments: list[str]) -> dict[str, Any]:
    """Set fields given as NAME=VALUE, of one or more configurations, and keep them on the knob.

    Raises
    ------
    InvalidArgument
        Not NAME=VALUE, no such field, or a value outside its range. What stood before remains.
    Refused
        Somebody has the actuator.
    """
    pairs = [assignment.partition("=") for assignment in assignments]
    for name, equals, _ in pairs:
        if not equals:
            raise InvalidArgument(f"{name!r} is not of the form NAME=VALUE")
    now = get(knob, [name for name, _, _ in pairs])
    changes = {name: _value(name, text, now[name]) for name, _, text in pairs}
    changed = {}
    for part, config in _read(knob).items():
        mine = {
            field.name: changes[field.name] for field in fields(config) if field.name in changes
        }
        if mine:
            changed[part] = replace(config, **mine)
    _apply(knob, changed)
    return get(knob, list(changes))


def load(knob: Knob, path: Path) -> None:
    """Set what a file of `dump` has, and keep it on the knob. What it does not name stays.

    Raises
    ------
    InvalidArgument
        The file is no such file, or has a field or a value that the knob does not take. What stood
        before remains.
    Refused
        Somebody has the actuator.
    OSError
        The file cannot be read.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError):
        content = None
    if not isinstance(content, dict) or not all(
        isinstance(part, dict) for part in content.values()
    ):
        raise InvalidArgument(f"{path} is no file of `torsio config dump`")
    if unknown := [name for name in content if name not in _KINDS]:
        raise InvalidArgument(f"{path}: there is no configuration {unknown[0]!r}")
    now = _read(knob)
    changed = {}
    for part, values in content.items():
        known = {field.name for field in fields(now[part])}
        if strangers := sorted(set(values) - known):
            raise InvalidArgument(f"{path}: {part} has no field {strangers[0]!r}")
        changed[part] = replace(now[part], **values)
    _apply(knob, changed)


def _apply(knob: Knob, changed: dict[str, Config]) -> None:
    """Set all or nothing, and save."""
    if knob.health().owner != "none":
        raise Refused("somebody has the actuator: end it, and set it again")
    before = _read(knob)
    done: list[str] = []
    try:
        for part, config in changed.items():
            knob.configure(config)
            done.append(part)
    except Exception:
        for part in done:
            knob.configure(before[part])
        raise
    knob.save()
