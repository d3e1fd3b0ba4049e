"""Shared by the commands of `torsio`: options, opening a knob, reporting errors."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Annotated, Any, ParamSpec, TypeVar

import typer
from rich.console import Console

import torsio
from torsio.common.emulated import EMULATED, selects_emulated
from torsio.common.screen import err, line
from torsio.demos import output, wall

__all__ = [
    "AsJson",
    "Device",
    "Seconds",
    "assignment",
    "choose",
    "complain",
    "device_option",
    "opened",
    "option",
    "plainly",
    "print_json",
    "value_of",
    "value_text",
]

P = ParamSpec("P")
T = TypeVar("T")


def option(name: str, metavar: str, text: str, **more: Any) -> Any:
    """Make an option that has no default to show."""
    return typer.Option(name, metavar=metavar, help=text, show_default=False, **more)


def device_option(text: str) -> Any:
    """Make `--device`; an empty name is refused, as of a shell's variable that is not set."""

    def check(context: typer.Context, device: str) -> str:
        source = context.get_parameter_source("device")
        if device == "" and source is not None and source.name != "DEFAULT":
            raise typer.BadParameter("it is empty")
        return device

    return option("--device", "DEVICE", text, callback=check)


Device = Annotated[
    str,
    device_option(
        "Path, serial number, or 'emulated'; see `torsio list`. Default: the knob "
        "that is plugged in, else the emulated one, unless the command saves."
    ),
]
Seconds = Annotated[
    float | None,
    typer.Option("--seconds", min=0.0, help="End after so long.", show_default=False),
]
AsJson = Annotated[
    bool,
    typer.Option(
        "--json",
        help="Print JSON to standard output, everything else to standard error.",
    ),
]


def plainly(command: Callable[P, T]) -> Callable[P, T]:
    """Turn what can go wrong into one sentence and an exit status."""

    @wraps(command)
    def run(*args: P.args, **kwargs: P.kwargs) -> T:
        try:
            return command(*args, **kwargs)
        except KeyboardInterrupt:
            err.print("torsio: interrupted")
            raise typer.Exit(130) from None
        except (torsio.Error, wall.WallNotReachedError, output.OutputError) as error:
            complain(str(error))
            raise typer.Exit(1) from None
        except BrokenPipeError:  # the reader, such as `head`, has enough
            raise typer.Exit(1) from None
        except OSError as error:
            named = error.filename is not None and error.strerror is not None
            complain(f"{error.filename}: {error.strerror}" if named else str(error))
            raise typer.Exit(1) from None

    return run


def complain(sentence: str) -> None:
    """Print what went wrong, in a sentence."""
    line(err, f"torsio: error: {sentence}")


def choose(device: str) -> str:
    """Give the selector of a device: if none is named, as `torsio.open`, or else the emulated."""
    if device or any(listed.transport != EMULATED for listed in torsio.list_devices()):
        return device
    return EMULATED


@contextmanager
def opened(
    device: str,
    say: Console,
    emulator: torsio.EmulatorOptions | None = None,
    order: Callable[[torsio.Knob], object] | None = None,
    *,
    changes: bool = False,
) -> Iterator[torsio.Knob]:
    """Open a device, give it an order, say which one it is, and close it.

    The order comes first: the screen may fail. A command that `changes` what a knob keeps takes the
    emulated one only by its name: it forgets all at the end, and somebody meant a real one.
    """
    selector = choose(device)
    if changes and selector != device:
        raise torsio.DeviceNotFound(
            "no knob is plugged in, so nothing was changed. ./dev udev in the clone gives "
            "permission for one; --device emulated tries the command on an emulated knob"
        )
    options = emulator if selects_emulated(selector) else None
    states: list[str] = []
    try:
        with torsio.open(selector or None, emulator=options) as knob, telling(knob, states):
            if order is not None:
                order(knob)
            info = knob.info
            said = [info.path + (f", serial number {info.serial}" if info.serial else "")]
            if selector != device:
                said.append("no real knob is plugged in")
            if knob.is_emulated:
                said.append("settings are forgotten")
            line(say, f"knob     {'; '.join(said)}")
            yield knob
    except KeyboardInterrupt:
        if not states:
            raise
        err.print(f"torsio: interrupted; the knob is {states[-1]}")
        raise typer.Exit(130) from None


@contextmanager
def telling(knob: torsio.Knob, states: list[str]) -> Iterator[None]:
    """Collect the state in which an interrupted knob is left: one may play on."""
    try:
        yield
    except KeyboardInterrupt:
        knob._knob.disarm_to_close()  # before anything that may fail
        states.append(knob.state if knob.is_open else "closed")
        raise


def print_json(value: Any) -> None:
    """Print a value as JSON to standard output."""
    # Not through rich, which would wrap and colour it.
    sys.stdout.write(json.dumps(value, indent=2, allow_nan=False) + "\n")


def value_text(key: str, value: Any) -> str:
    """Write the value of a field as a person reads it."""
    if key == "fingerprint":
        return f"0x{value:08x}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple | list):
        return ", ".join(value) or "none"
    return str(value)


def assignment(text: str) -> tuple[str, str]:
    """Take FIELD=VALUE apart."""
    name, equals, value = text.partition("=")
    if not equals:
        raise torsio.InvalidArgument(f"{text!r} is not of the form FIELD=VALUE")
    return name, value


def value_of(name: str, text: str, kind: type) -> Any:
    """Read the value of a field, of the kind that the field has."""
    try:
        if kind is bool:
            return {"on": True, "true": True, "off": False, "false": False}[text.lower()]
        value = kind(text)
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError
    except (KeyError, ValueError):
        wanted = {bool: "on or off", int: "a whole number", float: "a number"}[kind]
        raise torsio.InvalidArgument(f"{name} takes {wanted}, not {text!r}") from None
    return value
