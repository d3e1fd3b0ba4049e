"""Windows games under Wine, as the guests run them, and what a game of DirectInput plays."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from tests.vm.guest import effect_forms, gamepad
from tests.vm.guest.effect_forms import Case
from tests.vm.guest.gamepad import Effect
from tools import windows_games

# Made on the host, where it takes seconds; see tools/windows_games.py.
FOLDER = windows_games.FOLDER
DIRECT_INPUT = (FOLDER / "effects.exe",)
PREFIX = FOLDER / "prefix"
LENGTH_MS = 300
LENGTH_S = LENGTH_MS / 1e3
HALF = 5_000  # DirectInput's full level is 10,000
SATURATED = 10_000
PUSHED = f"10000 1 0 {HALF} {SATURATED}"


def environment() -> Mapping[str, str]:
    return {**os.environ, **windows_games.QUIET, "WINEPREFIX": str(PREFIX)}


class Game:
    """A Windows program that plays what it is told, while it runs."""

    def __init__(self, *command: str | Path) -> None:
        self._process = subprocess.Popen(
            ["wine", *command],
            env=environment(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def hear(self, what: str) -> None:
        """Wait for a line that it says."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline().strip()
        assert line == what

    def play(self, name: str, words: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(f"{name} {words}\n")
        self._process.stdin.flush()
        self.hear(f"played {name}")

    def kill(self) -> None:
        """Let it die as a game that crashes does."""
        self._process.kill()
        self._process.communicate()

    def end(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self.hear("done")
        assert self._process.wait(60) == 0
        assert self._process.stdout is not None
        self._process.stdout.close()


@contextmanager
def acquired(*command: str | Path) -> Iterator[Game]:
    game = Game(*command)
    game.hear("acquired")
    yield game
    game.end()


def case(form: effect_forms.Form) -> Case:
    return Case(Effect(gamepad.CONSTANT, b"", LENGTH_MS), LENGTH_S, lambda t: -form(t))


def level(share: float) -> Case:
    return case(lambda t: np.full_like(t, share))


def wave(form: effect_forms.Form, amplitude: float, offset: float = 0, phase: float = 0) -> Case:
    return case(lambda t: amplitude * form(t / 0.1 + phase) + offset)


# The program's values, and the torque as a share of full. With one axis Wine sends both 1 and
# -1 as 90 degrees, which is from the right: a positive force pushes to smaller angles.
PLAYED = {
    "half": (f"constant {LENGTH_MS} 10000 1 {HALF}", level(0.5)),
    "back": (f"constant {LENGTH_MS} 10000 1 {-HALF}", level(-0.5)),
    "half_gain": (f"constant {LENGTH_MS} 5000 1 {HALF}", level(0.25)),
    "ramp": (f"ramp {LENGTH_MS} 10000 1 -10000 10000", case(lambda t: 2 * t / LENGTH_S - 1)),
    "square": (f"square {LENGTH_MS} 10000 1 {HALF} 0 0 100000", wave(effect_forms.square, 0.5)),
    "sine": (f"sine {LENGTH_MS} 10000 1 {HALF} 0 0 100000", wave(effect_forms.sine, 0.5)),
    "sine_quarter": (
        f"sine {LENGTH_MS} 10000 1 4000 -3000 9000 100000",
        wave(effect_forms.sine, 0.4, offset=-0.3, phase=0.25),
    ),
    "triangle": (
        f"triangle {LENGTH_MS} 10000 1 {HALF} 0 0 100000",
        wave(effect_forms.triangle, 0.5),
    ),
    "saw_up": (f"saw_up {LENGTH_MS} 10000 1 {HALF} 0 0 100000", wave(effect_forms.saw_up, 0.5)),
    "saw_down": (
        f"saw_down {LENGTH_MS} 10000 1 {HALF} 0 0 100000",
        wave(effect_forms.saw_down, 0.5),
    ),
}
