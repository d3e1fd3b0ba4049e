"""The knob as games with SDL 2 get it, with udev running as on every desktop."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.vm.guest import sdl
from tests.vm.guest.gamepad import Gamepad
from tests.vm.guest.sdl import Sdl
from tests.vm.guest.torque_log import QUIET, let_pass, pieces, plug, read_log, set_up, turn
from tests.vm.guest.udev import run
from tests.vm.guest.virtual_bus import TREE, VirtualBus, wait_for

pytestmark = pytest.mark.usefixtures("udev")

LEVEL = 20_000
LENGTH_MS = 200
COUNT_RAD = 2 * np.pi / 8192
HALF_RANGE_RAD = np.pi / 180 * 450


def test_haptic_query_is_complete_and_every_effect_runs(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path, range_deg=90)
    turn(knob, tmp_path, [(0.0, 0.0), (0.1, 0.4)])
    run("udevadm", "settle")
    game = Sdl()
    assert "Torsio" in game.name
    assert game.parts == (2, 2)
    assert game.is_haptic
    # Every kind of SDL 2 except custom waves, and gain; no centring.
    kinds = {1 << bit for bit in range(11)}
    assert {1 << bit for bit in range(32) if game.can >> bit & 1} == {*kinds, sdl.GAIN}
    assert game.effects == 40
    game.set_gain(100)
    waves = [
        sdl.periodic(kind, LEVEL, 50, LENGTH_MS)
        for kind in (sdl.SINE, sdl.TRIANGLE, sdl.SAW_UP, sdl.SAW_DOWN)
    ]
    conditions = [
        sdl.condition(kind, LEVEL, LENGTH_MS)
        for kind in (sdl.SPRING, sdl.DAMPER, sdl.INERTIA, sdl.FRICTION)
    ]
    pushes = [sdl.constant(LEVEL, LENGTH_MS), sdl.ramp(0, LEVEL, LENGTH_MS)]
    played = [*pushes, *waves, sdl.left_right(LEVEL, LEVEL, LENGTH_MS), *conditions]
    for effect in played:
        number = game.new(effect)
        # Off centre, and turned to and fro, for those that answer to that.
        turn(knob, tmp_path, [(0.02 * n, 0.4 + n % 2 / 10) for n in range(30)])
        game.run(number)
        let_pass(knob, LENGTH_MS / 1e3 + 0.2)
        game.update(number, effect)
        game.stop(number)
        game.destroy(number)
    game.close()
    time_s, _, torque = read_log(bus, log)
    found = pieces(time_s, torque, 0.1)
    sounding = [t[np.abs(x) > QUIET] for t, x in found]
    lengths_s = [float(t[-1] - t[0]) for t in sounding]
    assert lengths_s == pytest.approx([LENGTH_MS / 1e3] * len(played), abs=6e-3)
    peaks = [float(np.abs(x).max()) for _, x in found]
    # A triangle's peak lies between two ticks.
    assert peaks[: len(pushes) + len(waves)] == pytest.approx([LEVEL / 32767] * 6, rel=0.05)
    assert min(peaks) > 0.05


def shows(game: Sdl, buttons: list[bool]) -> bool:
    return [game.button(0), game.button(1)] == buttons


@pytest.mark.kernel("6.1")
def test_axis_is_exact_centred_and_monotonic_with_the_udev_rule(
    bus: VirtualBus, tmp_path: Path
) -> None:
    knob = bus.plug()
    set_up(knob)
    run("udevadm", "settle")
    pad = Gamepad(knob)
    assert pad.axis().fuzz == 65534 // 256  # Linux's own idea
    run(TREE / "dev", "udev")
    assert (pad.axis().fuzz, pad.axis().flat) == (0, 0)
    pad.close()
    game = Sdl()
    count = 0

    def goes_to(to: int) -> int:
        """Turn the knob by the encoder's counts, and return where the axis comes to rest."""
        nonlocal count
        # In the middle of a count, which is where its angle is sure to be read as this one.
        path = [(0.0, (count + 0.5) * COUNT_RAD), (0.05, (to + 0.5) * COUNT_RAD)]
        turn(knob, tmp_path, path)
        count = to
        # SDL stretches -32767 to 32767, which the device says, to -32768 to 32767.
        expected = 32767.5 * np.clip(to * COUNT_RAD / HALF_RANGE_RAD, -1, 1) - 0.5

        def is_there() -> list[int]:
            value = game.axis()
            return [value] if abs(value - expected) <= 1.01 else []

        return wait_for(f"the axis at {expected}", is_there)[0]

    assert goes_to(0) == 0
    assert goes_to(-11_000) == -32768
    seen = [goes_to(to) for to in range(-10_500, 10_501, 1_500)]
    assert np.diff(seen).min() >= 0
    assert goes_to(11_000) == 32767
    # Each of the encoder's counts shows.
    near = [goes_to(1_000 + n) for n in range(8)]
    assert set(np.diff(near)) <= {3, 4}
    assert goes_to(0) == 0
    for pressed in (1, 2, 3, 0):
        knob.say(f"buttons {pressed}")
        wanted = [pressed & 1 != 0, pressed & 2 != 0]
        wait_for("the buttons", partial(shows, game, wanted))
    game.close()
    run(TREE / "dev", "udev", "--remove")
