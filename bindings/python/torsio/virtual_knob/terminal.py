"""A hand made of keys or of the mouse: from a terminal's bytes to a virtual knob's commands."""

from __future__ import annotations

import math
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol

if sys.platform != "win32":  # Windows has neither, and no virtual knob
    import termios
    import tty

PUSH_STEP_NM = 5e-3
LARGEST_PUSH_NM = 100e-3
RAD_PER_COLUMN = math.radians(3.0)

# Report presses, releases and moves with a button down, as decimal numbers (xterm's modes).
_MOUSE_ON = "\x1b[?1002h\x1b[?1006h"
_MOUSE_OFF = "\x1b[?1006l\x1b[?1002l"

_EVENT = re.compile(
    rb"\x1b\[<(?P<button>\d+);(?P<column>\d+);\d+(?P<end>[Mm])|\x1b[\[O](?P<arrow>[A-D])|"
    rb"\x1b\[[0-9;<?]*[ -/]*[@-~]|(?P<key>[^\x1b])"
)
# Input that may still become one of the above.
_BEGUN = re.compile(rb"\x1b(?:[\[O][0-9;<?]*)?$")


@dataclass(frozen=True)
class Key:
    """A key: ``left``, ``right``, ``up``, ``down``, or the character."""

    name: str


@dataclass(frozen=True)
class Mouse:
    """The left button: ``press``, ``move`` with it down, or ``release``, at a column."""

    what: str
    column: int


class Input:
    """Bytes from a terminal, in pieces of any size, as keys and mouse events."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> Iterator[Key | Mouse]:
        """Yield the keys that the bytes complete; other bytes are ignored."""
        data = self._rest + data
        self._rest = b""
        at = 0
        while at < len(data):
            match = _EVENT.match(data, at)
            if match is None:
                if _BEGUN.match(data, at) and len(data) - at < 32:
                    self._rest = data[at:]
                    return
                at += 1
                continue
            at = match.end()
            if arrow := match["arrow"]:
                yield Key({b"A": "up", b"B": "down", b"C": "right", b"D": "left"}[arrow])
            elif key := match["key"]:
                yield Key(key.decode("ascii", "replace"))
            elif match["button"] and int(match["button"]) in (0, 32):
                moved = int(match["button"]) == 32
                what = "release" if match["end"] == b"m" else "move" if moved else "press"
                yield Mouse(what, int(match["column"]))


class Hand(Protocol):
    """Effects of a person's input on the knob."""

    help: str

    def follow(self, event: Key | Mouse, angle_rad: float) -> str | None:
        """Return the command for an event, at the angle where the knob is, if it means any."""


class KeyboardHand:
    """Arrow keys push harder to either side; the space bar lets go."""

    help = "← and → push, space lets go, Ctrl-C ends"

    def __init__(self) -> None:
        self._steps = 0

    def follow(self, event: Key | Mouse, angle_rad: float) -> str | None:
        """Return the command for an event."""
        most = round(LARGEST_PUSH_NM / PUSH_STEP_NM)
        if event == Key("right"):
            self._steps = min(self._steps + 1, most)
        elif event == Key("left"):
            self._steps = max(self._steps - 1, -most)
        elif event in (Key(" "), Key("down")):
            self._steps = 0
        else:
            return None
        return f"torque {self._steps * PUSH_STEP_NM:.3f}" if self._steps else "free"


class MouseHand:
    """Holding the left button holds the knob; moving sideways turns it."""

    help = "hold the left mouse button and move sideways to turn, Ctrl-C ends"

    def __init__(self) -> None:
        self._column = 0
        self._angle_rad = 0.0

    def follow(self, event: Key | Mouse, angle_rad: float) -> str | None:
        """Return the command for an event."""
        if not isinstance(event, Mouse):
            return None
        if event.what == "release":
            return "free"
        if event.what == "press":
            self._column, self._angle_rad = event.column, angle_rad
        turned = (event.column - self._column) * RAD_PER_COLUMN
        return f"angle {self._angle_rad + turned:.6f}"


@contextmanager
def taken(mouse: bool) -> Iterator[int]:
    """Take the terminal for as long as the context lasts; Ctrl-C keeps its meaning.

    Yields the file descriptor to read from.
    """
    number = sys.stdin.fileno()
    before = termios.tcgetattr(number)
    tty.setcbreak(number)
    try:
        if mouse:
            os.write(sys.stdout.fileno(), _MOUSE_ON.encode())
        yield number
    finally:
        if mouse:
            os.write(sys.stdout.fileno(), _MOUSE_OFF.encode())
        termios.tcsetattr(number, termios.TCSAFLUSH, before)
