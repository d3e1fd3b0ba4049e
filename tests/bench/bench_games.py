"""How late a game's forces are at the motor: one JSON line each.

Boots a virtual machine and plays on a virtual knob through Linux's own driver, as a game does. Time
is counted in instructions there, 1 ns each, so that the figures do not depend on what else the
computer does. `--here` measures on this computer instead, by the clock; that needs root and the
module vhci_hcd.

Keys: `benchmark` "games"; `kernel` its release; `time` "instructions" or "clock";
`control_rate_hz`; `effect`: "constant", "ramp", "sine" (its offset), "spring" (its coefficient), or
"start" for a constant one that is started and stopped; `updates`. From the call that changes a
playing effect, `median_ms` and `p99_ms` to the first tick whose torque moves by 1 % of the change,
`whole_median_ms` and `whole_p99_ms` to 99 % of it, after the device's blend.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import random
import select
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from tests.bench.bench_usb import measure_in_virtual_machine
from tests.vm.guest import gamepad
from tests.vm.guest.gamepad import Effect, Gamepad
from tests.vm.guest.torque_log import Floats, let_pass, plug, read_log, turn
from tests.vm.guest.virtual_bus import VirtualBus
from tests.vm.machine import GuestFailed

SLIP_S = 1e-3
Line = dict[str, Any]


class Bench:
    """A knob that is plugged in, the game on it, and what its motor gave."""

    def __init__(self, folder: Path, rate_hz: int, **game: Any) -> None:
        self.folder = folder
        self.bus = VirtualBus()
        self.knob, self.log = plug(self.bus, folder, rate_hz=rate_hz, **game)
        self.pad = Gamepad(self.knob)
        self.offset_s = self._offset_s()

    def end(self) -> tuple[Floats, Floats, Floats]:
        """Return time in s by the computer's clock, angle, and torque as a share of full."""
        slipped_s = self._offset_s() - self.offset_s
        self.pad.close()
        time_s, angle, torque = read_log(self.bus, self.log)
        if abs(slipped_s) > SLIP_S:
            raise RuntimeError(f"the virtual knob could not keep up, by {slipped_s:g} s")
        return time_s + self.offset_s, angle, torque

    def _offset_s(self) -> float:
        """Return when the knob's time was 0. It tells its time when a frame ends."""
        assert self.knob.process.stdout is not None
        file = self.knob.process.stdout.fileno()
        found: list[float] = []
        while len(found) < 15:
            select.select([file], [], [])
            now_s = time.monotonic()
            words = os.read(file, 1 << 16).decode().split()
            if len(words) == 7 and words[0] == "status":
                found.append(now_s - float(words[1]))
        return min(found)


@contextmanager
def bench(rate_hz: int, **game: Any) -> Iterator[Bench]:
    """Plug a knob in, with a game configuration."""
    with tempfile.TemporaryDirectory() as folder:
        running = Bench(Path(folder), rate_hz, **game)
        try:
            yield running
        finally:
            running.bus.end()


def _changes() -> dict[str, tuple[Effect, Effect]]:
    """Return two states between which an effect goes to and fro, by its name."""

    def offset(level: int) -> Effect:
        return Effect(gamepad.PERIODIC, gamepad.periodic(gamepad.SINE, 0, 100, offset=level))

    def both(make: Callable[[int], Effect]) -> tuple[Effect, Effect]:
        return make(10_000), make(30_000)

    return {
        "constant": both(lambda level: Effect(gamepad.CONSTANT, gamepad.constant(level))),
        "ramp": both(lambda level: Effect(gamepad.RAMP, gamepad.ramp(level, level), 0x7000)),
        "sine": both(offset),
        "spring": both(lambda level: Effect(gamepad.SPRING, gamepad.condition(level))),
    }


def _delays_ms(sent_s: Floats, time_s: Floats, torque: Floats) -> tuple[Floats, Floats]:
    """Return the delays to the first and to nearly all of each change."""
    first_ms: list[float] = []
    whole_ms: list[float] = []
    for begin_s, next_s in pairwise(sent_s):
        here = slice(*np.searchsorted(time_s, (begin_s, next_s)))
        before, after = torque[here][0], torque[here][-1]
        moved = (torque[here] - before) / (after - before)
        for share, found in ((0.01, first_ms), (0.99, whole_ms)):
            found.append(1e3 * (time_s[here][np.argmax(moved >= share)] - begin_s))
    return np.array(first_ms), np.array(whole_ms)


def delay_line(effect: str, rate_hz: int, updates: int) -> Line:
    """Change an effect again and again at any moment of a frame."""
    chance = random.Random(effect)
    with bench(rate_hz, range_deg=90) as running:
        pad = running.pad
        turn(running.knob, running.folder, [(0.0, 0.0), (0.2, 0.5)])
        states = _changes()["constant" if effect == "start" else effect]
        number = pad.upload(states[0])
        changed = [Effect(s.kind, s.parameters, s.length_ms, number=number).packed for s in states]
        pad.play(number)
        let_pass(running.knob, 0.5)
        sent_s = []
        for count in range(updates + 1):
            time.sleep(chance.uniform(0.015, 0.025))
            sent_s.append(time.monotonic())
            if effect == "start":
                pad.play(number, loops=count % 2)
            else:
                pad.upload_packed(changed[1 - count % 2])
        time_s, _, torque = running.end()
    first_ms, whole_ms = _delays_ms(np.array(sent_s), time_s, torque)
    return {
        "effect": effect,
        "median_ms": round(float(np.median(first_ms)), 3),
        "p99_ms": round(float(np.percentile(first_ms, 99)), 3),
        "whole_median_ms": round(float(np.median(whole_ms)), 3),
        "whole_p99_ms": round(float(np.percentile(whole_ms, 99)), 3),
        "updates": updates,
    }


def measure(arguments: argparse.Namespace) -> Iterator[Line]:
    """Measure on this computer."""
    rate_hz = arguments.rate_hz
    about = {
        "benchmark": "games",
        "kernel": platform.release(),
        "time": "clock",
        "control_rate_hz": rate_hz,
    }
    for effect in (*_changes(), "start"):
        yield about | delay_line(effect, rate_hz, arguments.updates)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--here", action="store_true", help="no virtual machine; needs root")
    parser.add_argument("--rate-hz", type=int, default=10_000, help="control rate")
    parser.add_argument("--updates", type=int, default=400, help="changes for each delay")
    arguments = parser.parse_args()
    if arguments.here:
        for line in measure(arguments):
            print(json.dumps(line), flush=True)
        return
    try:
        for line in measure_in_virtual_machine(["--here", *sys.argv[1:]], name="games"):
            print(json.dumps(line), flush=True)
    except GuestFailed as failure:
        sys.exit(f"bench_games: {failure}")


if __name__ == "__main__":
    main()
