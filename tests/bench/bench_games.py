"""How late and how true a game's forces are at the motor: one JSON line each.

Boots a virtual machine and plays on a virtual knob through Linux's own driver, as a game does. Time
is counted in instructions there, 1 ns each, so that the figures do not depend on what else the
computer does. `--here` measures on this computer instead, by the clock; that needs root and the
module vhci_hcd. `--in-process` measures "frames" alone, on an emulated knob without a driver, by a
virtual clock.

Keys: `benchmark` "games"; `what`; `kernel` its release; `time` "instructions", "clock" or
"virtual"; `control_rate_hz`.

`what` "delay", from the call that changes a playing effect to the torque of the motor. `effect`:
"constant", "ramp", "sine" (its offset), "spring" (its coefficient), or "start" for a constant one
that is started and stopped. `median_ms` and `p99_ms` to the first tick whose torque moves by 1 % of
the change, `whole_median_ms` and `whole_p99_ms` to 99 % of it, after the device's blend; `updates`.

`what` "torque_error", the distance from the effect's closed form: `max_share` and `rms_share`, as
shares of full torque. Effects that depend on time only: without 3 ms at their ends and at their own
jumps. Of a spring: all along a turn to and fro. Of damper and friction: at 10 rad/s. Of inertia: at
300 rad/s^2.

`what` "flood", a constant force that is changed as fast as `asked_per_s`: `updates`, `applied`
(that reached the motor), `median_ms` and `max_ms` of their delay, `first_quarter_max_ms` to see it
grow, and `last_wins`, whether an update after the flood is what plays.

`what` "frames", a sine of 1 Hz and half of full torque that a game sends as a constant force, one
value in each of `frames_hz` frames a second; `joined` as the device does by default, or held.
In process also `sent`, the reports of a frame in their order, 1 ms apart: "level"; "level start",
as games do that play with each update; "level envelope effect", as Wine's DirectInput does.
`late_ms` behind the curve where it fits best, `ripple_share` the largest distance from it there and
`rms_share` the mean, `step_share` the largest change in a tick, `overshoot_share` beyond what was
sent, all as shares of full torque; `updates`.
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

TREE = Path(__file__).parents[2]
sys.path.insert(0, str(TREE))  # this file is also run as a program
from tests.bench import game_frames  # noqa: E402
from tests.bench.bench_usb import measure_in_virtual_machine  # noqa: E402
from tests.vm.guest import effect_forms, gamepad  # noqa: E402
from tests.vm.guest.gamepad import Effect, Gamepad  # noqa: E402
from tests.vm.guest.torque_log import (  # noqa: E402
    Floats,
    let_pass,
    pieces,
    plug,
    read_log,
    turn,
)
from tests.vm.guest.virtual_bus import VirtualBus  # noqa: E402
from tests.vm.machine import GuestFailed  # noqa: E402

SLIP_S = 1e-3
FRAME_S = 1e-3
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


# Delay ---------------------------------------------------------------------------------------


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
        "what": "delay",
        "effect": effect,
        "median_ms": round(float(np.median(first_ms)), 3),
        "p99_ms": round(float(np.percentile(first_ms, 99)), 3),
        "whole_median_ms": round(float(np.median(whole_ms)), 3),
        "whole_p99_ms": round(float(np.percentile(whole_ms, 99)), 3),
        "updates": updates,
    }


# Torque error --------------------------------------------------------------------------------


def _error_line(effect: str, error: Floats) -> Line:
    return {
        "what": "torque_error",
        "effect": effect,
        "max_share": round(float(np.abs(error).max()), 5),
        "rms_share": round(float(np.sqrt(np.mean(error**2))), 5),
    }


def timed_lines(rate_hz: int) -> Iterator[Line]:
    """Play what depends on time only."""
    cases = effect_forms.cases()
    pause_s = 0.08
    with bench(rate_hz) as running:
        for case in cases.values():
            number = running.pad.upload(case.effect)
            running.pad.play(number, loops=case.loops)
            let_pass(running.knob, case.length_s + case.effect.delay_ms / 1e3 + 3 * pause_s)
            running.pad.erase(number)
        time_s, _, torque = running.end()
    found = pieces(time_s, torque, pause_s)
    for (name, case), piece in zip(cases.items(), found, strict=True):
        yield _error_line(name, effect_forms.residual(*piece, case))


def condition_line(effect: str, rate_hz: int) -> Line:
    """Turn the knob while it answers to that."""
    kind, coefficient = {
        "spring": (gamepad.SPRING, 30_000),
        "damper": (gamepad.DAMPER, 16_384),
        "friction": (gamepad.FRICTION, 16_384),
        "inertia": (gamepad.INERTIA, 32_767),
    }[effect]
    times = np.arange(0, 0.3, 1e-3)
    path = {
        "spring": [(0.0, 0.0), (0.5, 0.75), (1.5, -0.75), (2.0, 0.0)],
        "inertia": [(float(t), float(150 * t**2)) for t in times],
    }.get(effect, [(0.0, 0.0), (0.4, 4.0), (0.5, 4.0), (0.9, 0.0)])
    with bench(rate_hz, range_deg=90 if effect == "spring" else 900) as running:
        running.pad.play(running.pad.upload(Effect(kind, gamepad.condition(coefficient))))
        let_pass(running.knob, 0.2)
        turn(running.knob, running.folder, path)
        let_pass(running.knob, path[-1][0] + 0.2)
        time_s, angle, torque = running.end()
    moved = np.flatnonzero(np.abs(np.diff(angle)) > 0)
    since_s = time_s - time_s[moved[0]]
    share = coefficient / 32767
    if effect == "spring":
        counted = np.abs(angle) > 1e-3
        expected = -share * angle / (np.pi / 4)
    elif effect == "inertia":
        counted = (since_s > 0.1) & (since_s < 0.29)
        expected = np.full_like(angle, -share * 300 / 3000)
    else:
        counted = (since_s > 0.1) & (since_s < 0.39)
        expected = np.full_like(angle, -share * (10 / 20 if effect == "damper" else 1))
    return _error_line(effect, (torque - expected)[counted])


# Flood ---------------------------------------------------------------------------------------


def flood_line(rate_hz: int, asked_per_s: float, duration_s: float) -> Line:
    """Change an effect more often than the bus carries reports."""
    # The level tells which update it is.
    count = min(round(asked_per_s * duration_s), 30_000)
    last = 31_000
    with bench(rate_hz, blend_s=0, join_updates=False) as running:
        pad = running.pad

        def state(level: int, number: int) -> Effect:
            return Effect(gamepad.CONSTANT, gamepad.constant(level), number=number)

        number = pad.upload(state(0, -1))
        pad.play(number)
        let_pass(running.knob, 0.2)
        packed = [state(1 + index, number).packed for index in range(count)]
        sent_s = np.zeros(count)
        begin_s = time.monotonic()
        for index, data in enumerate(packed):
            while (now_s := time.monotonic()) < begin_s + index / asked_per_s:
                pass
            sent_s[index] = now_s
            pad.upload_packed(data)
        let_pass(running.knob, 0.6)
        pad.upload(state(last, number))
        let_pass(running.knob, 0.2)
        time_s, _, torque = running.end()
    # A frame brings one update, and at its end the motor has settled to it.
    frame = round(rate_hz * FRAME_S)
    level = np.rint(torque * 32767).astype(int)[frame - 1 :: frame]
    begin_of_frame_s = time_s[::frame][: level.size]
    won = np.flatnonzero(level == last)
    flood = level[: won[0]] if won.size else level
    new = 1 + np.flatnonzero((np.diff(flood) != 0) & (flood[1:] > 0) & (flood[1:] <= count))
    update = level[new] - 1
    delays_ms = 1e3 * (begin_of_frame_s[new] - sent_s[update])
    quarter = delays_ms[update < count // 4]
    return {
        "what": "flood",
        "asked_per_s": asked_per_s,
        "updates_per_s": round(count / (sent_s[-1] - sent_s[0])),
        "updates": count,
        "applied": len(new),
        "median_ms": round(float(np.median(delays_ms)), 1),
        "max_ms": round(float(delays_ms.max()), 1),
        "first_quarter_max_ms": round(float(quarter.max()), 1),
        "last_wins": won.size > 0,
    }


# A game's frames -----------------------------------------------------------------------------


def frames_line(rate_hz: int, frames_hz: int, *, joined: bool) -> Line:
    """Send a curve as a game does, a value in each frame."""
    duration_s = 3.0
    count = round(duration_s * frames_hz)
    with bench(rate_hz, join_updates=joined) as running:
        pad = running.pad

        def state(index: int, number: int) -> Effect:
            level = round(32767 * float(game_frames.curve(np.array(index / frames_hz))))
            return Effect(gamepad.CONSTANT, gamepad.constant(level), number=number)

        number = pad.upload(state(0, -1))
        pad.play(number)
        let_pass(running.knob, 0.2)
        packed = [state(index, number).packed for index in range(count)]
        begin_s = time.monotonic()
        for index, data in enumerate(packed):
            while time.monotonic() < begin_s + index / frames_hz:
                pass
            pad.upload_packed(data)
        let_pass(running.knob, 0.2)
        time_s, _, torque = running.end()
    sent = slice(*np.searchsorted(time_s, (begin_s, begin_s + duration_s)))
    found = game_frames.measures(time_s[sent] - begin_s, torque[sent])
    about: Line = {"what": "frames", "frames_hz": frames_hz, "joined": joined, "updates": count}
    return about | found


# ---------------------------------------------------------------------------------------------


def measure(arguments: argparse.Namespace) -> Iterator[Line]:
    """Measure on this computer."""
    rate_hz = arguments.rate_hz
    about = {
        "benchmark": "games",
        "kernel": platform.release(),
        "time": "clock",
        "control_rate_hz": rate_hz,
    }
    if "delay" in arguments.what:
        for effect in (*_changes(), "start"):
            yield about | delay_line(effect, rate_hz, arguments.updates)
    if "torque_error" in arguments.what:
        for line in timed_lines(rate_hz):
            yield about | line
        for effect in ("spring", "damper", "friction", "inertia"):
            yield about | condition_line(effect, rate_hz)
    if "frames" in arguments.what:
        for frames_hz in game_frames.FRAMES_HZ:
            for joined in (False, True):
                yield about | frames_line(rate_hz, frames_hz, joined=joined)
    if "flood" in arguments.what:
        yield about | flood_line(rate_hz, arguments.flood_per_s, arguments.flood_s)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--here", action="store_true", help="no virtual machine; needs root")
    parser.add_argument(
        "--in-process",
        action="store_true",
        help="measure frames only, without a driver; takes seconds",
    )
    kinds = ("delay", "torque_error", "frames", "flood")
    parser.add_argument(
        "--what", nargs="+", choices=kinds, default=kinds, help="measurements; default: all"
    )
    parser.add_argument("--rate-hz", type=int, default=10_000, help="control rate")
    parser.add_argument("--updates", type=int, default=400, help="changes for each delay")
    parser.add_argument("--flood-per-s", type=float, default=10_000, help="updates a second")
    parser.add_argument(
        "--flood-s", type=float, default=3.0, help="length of the flood; at most 30,000 updates"
    )
    arguments = parser.parse_args()
    if arguments.in_process:
        for line in game_frames.measure_in_process(arguments.rate_hz):
            print(json.dumps(line), flush=True)
        return
    if arguments.here:
        for line in measure(arguments):
            print(json.dumps(line), flush=True)
        return
    try:
        for line in measure_in_virtual_machine(["--here", *sys.argv[1:]], file=__file__):
            print(json.dumps(line), flush=True)
    except GuestFailed as failure:
        sys.exit(f"bench_games: {failure}")


if __name__ == "__main__":
    main()
