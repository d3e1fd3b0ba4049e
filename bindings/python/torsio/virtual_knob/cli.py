"""``torsio emulate``: a virtual knob for other programs."""

from __future__ import annotations

import math
import os
import selectors
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Annotated

import typer

from torsio.printed.config import (
    EMULATED_CONTROL_PERIOD_NS,
    MAX_CONTROL_RATE_HZ,
    MIN_CONTROL_RATE_HZ,
)
from torsio.printed.emulator_options import EMULATED_SERIAL
from torsio.virtual_knob import Address, attach_commands, program_path, terminal

_PERSONS: dict[str, type[terminal.KeyboardHand] | type[terminal.MouseHand]] = {
    "keyboard": terminal.KeyboardHand,
    "mouse": terminal.MouseHand,
}


def _hand(value: str) -> str:
    kind, _, file = value.partition(":")
    if value in {"still", "free", *_PERSONS} or (kind == "scripted" and file):
        return value
    raise typer.BadParameter("must be still, free, scripted:FILE, keyboard or mouse")


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


class _Screen:
    """Lines that stay, and on a terminal one last line that changes."""

    def __init__(self) -> None:
        self.is_terminal = sys.stdout.isatty()

    def line(self, text: str) -> None:
        sys.stdout.write(("\r\x1b[K" if self.is_terminal else "") + text + "\n")
        sys.stdout.flush()

    def status(self, words: list[str]) -> None:
        time_s, state, angle_rad, *torques_nm = words
        motor, brake, hand = (1e3 * float(torque) for torque in torques_nm)
        sys.stdout.write(
            f"\r\x1b[K{float(time_s):8.1f} s  {state:8}  {math.degrees(float(angle_rad)):8.1f}°  "
            f"motor {motor:6.1f}  brake {brake:6.1f}  hand {hand:6.1f} mN·m"
        )
        sys.stdout.flush()

    def end(self) -> None:
        if self.is_terminal:
            self.line("")


@contextmanager
def _running(command: list[str]) -> Iterator[subprocess.Popen[bytes]]:
    """Run the program; it ends with the context, however that ends.

    It also ends with this process, killed or not, for that ends its input.
    """
    process = subprocess.Popen(
        [*command, "--commands"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0
    )
    before = signal.signal(signal.SIGTERM, _interrupt)
    try:
        yield process
    finally:
        process.terminate()
        process.wait()
        signal.signal(signal.SIGTERM, before)


class _Show:
    """The screen and the keys of a running program."""

    def __init__(self, process: subprocess.Popen[bytes], hand: terminal.Hand | None) -> None:
        self._process = process
        self._hand = hand
        self._screen = _Screen()
        self._input = terminal.Input()
        self._rest = b""
        self._angle_rad = 0.0

    def run(self, person: int | None) -> None:
        """Show and follow until the program ends."""
        assert self._process.stdout is not None
        output = self._process.stdout.fileno()
        with selectors.DefaultSelector() as selector:
            selector.register(output, selectors.EVENT_READ)
            if person is not None:
                selector.register(person, selectors.EVENT_READ)
            while True:
                for key, _ in selector.select():
                    data = os.read(key.fd, 4096)
                    if not data:
                        self._screen.end()
                        return
                    if key.fd == output:
                        self._show(data)
                    else:
                        self._follow(data)

    def _show(self, data: bytes) -> None:
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            word, *words = line.decode().split()
            if word == "listening":
                self._show_commands(line.decode())
            elif word == "status":
                self._angle_rad = float(words[2])
                if self._screen.is_terminal:
                    self._screen.status(words)
            elif word == "slipped" and self._screen.is_terminal:
                self._screen.line(f"this machine is busy: the knob fell {words[0]} ms behind")
            else:
                self._screen.line(line.decode())

    def _show_commands(self, line: str) -> None:
        address = Address.from_line(line)
        commands = attach_commands(address).items()
        # At once: a reader of the first line can rely on the rest.
        self._screen.line(
            "\n".join(
                [
                    line,
                    *(f"  {system + ':':9}{command}" for system, command in commands),
                    self._hand.help if self._hand else "Ctrl-C ends",
                ]
            )
        )

    def _follow(self, data: bytes) -> None:
        assert self._process.stdin is not None
        assert self._hand is not None
        for event in self._input.feed(data):
            if command := self._hand.follow(event, self._angle_rad):
                # If it has ended, its output says so.
                with suppress(BrokenPipeError):
                    self._process.stdin.write(command.encode() + b"\n")


def emulate_command(
    address: Annotated[
        str,
        typer.Option(help="IPv4 address to listen on. Any but 127.0.0.1 lets other machines in."),
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="TCP port; 0 takes a free one.")
    ] = 3240,
    serial: Annotated[str, typer.Option(help="1 to 16 printable characters.")] = EMULATED_SERIAL,
    rate_hz: Annotated[
        float,
        typer.Option(
            min=MIN_CONTROL_RATE_HZ, max=MAX_CONTROL_RATE_HZ, help="Rate of the control loop."
        ),
    ] = 1e9 / EMULATED_CONTROL_PERIOD_NS,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random.")] = 0,
    hand: Annotated[
        str,
        typer.Option(
            callback=_hand,
            metavar="HAND",
            help="The hand on the knob: still, free, scripted:FILE, keyboard or mouse.",
        ),
    ] = "still",
    log: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write true values of every control tick."),
    ] = None,
    storage: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Keep the knob's saved configuration there, and start with it."
        ),
    ] = None,
) -> None:
    """Serve an emulated knob as a USB device, over USB/IP, until Ctrl-C.

    Other programs find the knob once the system has attached it; the command for that is printed.
    Run this several times, with a port and a serial number each, for several knobs.
    """
    person = _PERSONS[hand]() if hand in _PERSONS else None
    if person and not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise typer.BadParameter(f"{hand} needs a terminal", param_hint="--hand")
    options = {
        **{"address": address, "port": port, "serial": serial, "rate-hz": rate_hz, "seed": seed},
        **{"hand": "free" if person else hand, "log": log, "storage": storage},
    }
    command = [str(program_path()), *_words(options)]
    command += ["--status"] if sys.stdout.isatty() else []
    with ExitStack() as stack:
        process = stack.enter_context(_running(command))
        source = stack.enter_context(terminal.taken(hand == "mouse")) if person else None
        try:
            _Show(process, person).run(source)
            process.wait()
        except KeyboardInterrupt:
            # The one way to end it.
            sys.stdout.write("\n" if sys.stdout.isatty() else "")
            return
    if process.returncode:
        raise typer.Exit(_status_of(process.returncode))


def _words(options: Mapping[str, object]) -> Iterator[str]:
    for name, value in options.items():
        if value is not None:
            yield from (f"--{name}", str(value))


def _status_of(code: int) -> int:
    """Give the exit status for the program's own, and name the signal that ended it."""
    if code > 0:
        return code
    name = signal.Signals(-code).name
    sys.stderr.write(f"torsio: error: {name} ended the knob's program; start it again\n")
    return 1
