"""The knob as games with SDL 3 get it: haptic, and the shaking of whole joysticks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.vm.guest import effect_forms, sdl, sdl3
from tests.vm.guest.effect_forms import Case, Form
from tests.vm.guest.gamepad import CONSTANT, Effect
from tests.vm.guest.sdl3 import Sdl3
from tests.vm.guest.torque_log import QUIET, let_pass, pieces, plug, read_log, turn
from tests.vm.guest.udev import run
from tests.vm.guest.virtual_bus import VirtualBus, VirtualKnob

pytestmark = pytest.mark.usefixtures("udev")

LEVEL = 20_000
SHARE = LEVEL / 32767
LENGTH_MS, PERIOD_MS = 120, 60
ANGLE_RAD = 0.4  # half the range is 45 degrees


def play(game: Sdl3, knob: VirtualKnob, effect: bytes) -> None:
    number = game.new(effect)
    game.run(number)
    let_pass(knob, LENGTH_MS / 1e3 + 0.15)
    game.destroy(number)


def levels(found: list[tuple[np.ndarray, np.ndarray]]) -> list[float]:
    """Return the torque in the middle of each piece, as a share of full."""
    return [float(np.median(x[np.abs(x) > QUIET])) for _, x in found]


@pytest.mark.whole
@pytest.mark.kernel("6.12")
def test_sdl_3_finds_all_forces_and_gives_them_their_directions(
    bus: VirtualBus, tmp_path: Path
) -> None:
    knob, log = plug(bus, tmp_path, range_deg=90)
    turn(knob, tmp_path, [(0.0, 0.0), (0.1, ANGLE_RAD)])
    run("udevadm", "settle")
    game = Sdl3()
    assert game.version >= (3, 4)
    assert "Torsio" in game.name
    assert game.parts == (2, 2, 2)
    # Every kind except custom waves, and gain; no centring, no status, no pause.
    assert game.can == (1 << 12) - 1 | sdl3.GAIN
    assert game.effects == 40
    push = sdl.constant(LEVEL, LENGTH_MS)
    directions = {
        sdl3.WEST: 1.0,
        sdl3.cartesian(1, 0): -1.0,
        sdl3.polar(315): np.sqrt(0.5),
        sdl3.steering_axis(): -1.0,
    }
    for direction in directions:
        play(game, knob, sdl3.turned(push, direction))
    game.set_gain(50)
    play(game, knob, push)
    game.set_gain(100)
    # A condition's direction, which SDL sends along, says nothing about its only axis.
    spring = sdl.condition(sdl3.SPRING, LEVEL, LENGTH_MS)
    for direction in (sdl3.WEST, sdl3.polar(0)):
        play(game, knob, sdl3.turned(spring, direction))
    # Changed and stopped while it plays.
    number = game.new(sdl.constant(LEVEL, 5000))
    game.run(number)
    let_pass(knob, 0.05)
    game.update(number, sdl.constant(-LEVEL, 5000))
    let_pass(knob, 0.1)
    game.stop(number)
    let_pass(knob, 0.1)
    game.rumble(0xC000, 0x6000, LENGTH_MS)
    let_pass(knob, LENGTH_MS / 1e3 + 0.1)
    game.close()
    time_s, _, torque = read_log(bus, log)
    found = pieces(time_s, torque, 0.08)
    assert len(found) == len(directions) + 5
    expected = [SHARE * share for share in (*directions.values(), 0.5)]
    pushes = len(expected)
    assert levels(found)[:pushes] == pytest.approx(expected, rel=1e-3)
    # Springs come up in 50 ms.
    ends = [x[np.abs(x) > QUIET][-20] for _, x in found[pushes : pushes + 2]]
    assert ends == pytest.approx([-SHARE * ANGLE_RAD / (np.pi / 4)] * 2, rel=0.01)
    changed = found[-2][1]
    assert changed.max() == pytest.approx(SHARE, rel=1e-3)
    assert changed.min() == pytest.approx(-SHARE, rel=1e-3)
    # The kernel makes a sine of it, with a third and a sixth of the two strengths.
    shaken = found[-1][1]
    assert np.abs(shaken).max() == pytest.approx(0x5000 / 32767, rel=0.02)


def wave(form: Form) -> Case:
    return Case(
        Effect(CONSTANT, b"", LENGTH_MS),
        LENGTH_MS / 1e3,
        lambda t: SHARE * form(t / (PERIOD_MS / 1e3)),
    )


WAVES = {
    sdl3.SINE: effect_forms.sine,
    sdl3.SQUARE: effect_forms.square,
    sdl3.TRIANGLE: effect_forms.triangle,
    sdl3.SAW_UP: effect_forms.saw_up,
    sdl3.SAW_DOWN: effect_forms.saw_down,
}


@pytest.mark.games
def test_every_kind_of_sdl_3_is_felt_as_it_was_made(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path, range_deg=90)
    run("udevadm", "settle")
    game = Sdl3()
    for kind in WAVES:
        play(game, knob, sdl.periodic(kind, LEVEL, PERIOD_MS, LENGTH_MS))
    play(game, knob, sdl.ramp(-LEVEL, LEVEL, LENGTH_MS))
    turn(knob, tmp_path, [(0.0, 0.0), (0.1, ANGLE_RAD)])
    let_pass(knob, 0.1)
    play(game, knob, sdl.condition(sdl3.SPRING, LEVEL, LENGTH_MS))
    # To and fro, so that it lasts until the driver has heard of it.
    swings = [(0.02 * n, ANGLE_RAD + n % 2 * 0.2) for n in range(60)]
    for kind in (sdl3.DAMPER, sdl3.FRICTION, sdl3.INERTIA):
        turn(knob, tmp_path, swings)
        play(game, knob, sdl.condition(kind, LEVEL, LENGTH_MS))
    turn(knob, tmp_path, [(0.0, ANGLE_RAD)])
    play(game, knob, sdl3.left_right(LEVEL, LEVEL // 2, LENGTH_MS))
    game.close()
    time_s, _, torque = read_log(bus, log)
    found = pieces(time_s, torque, 0.08)
    forms = [wave(form) for form in WAVES.values()]
    forms.append(
        Case(forms[0].effect, LENGTH_MS / 1e3, lambda t: SHARE * (2 * t / (LENGTH_MS / 1e3) - 1))
    )
    assert len(found) == len(forms) + 5
    errors = [
        float(effect_forms.residual(*piece, case).max())
        for piece, case in zip(found, forms, strict=False)
    ]
    print("worst distances from the closed forms:", errors)
    # A tick late on the steepest line.
    assert max(errors) < 0.05
    spring, damper, friction, inertia, shaken = (x for _, x in found[len(forms) :])
    assert spring[np.abs(spring) > QUIET][-20] == pytest.approx(
        -SHARE * ANGLE_RAD / (np.pi / 4), rel=0.01
    )
    # At 10 rad/s, of 20; friction at any speed.
    assert np.percentile(np.abs(damper), 90) == pytest.approx(SHARE / 2, rel=0.1)
    assert np.percentile(np.abs(friction), 80) == pytest.approx(SHARE, rel=0.1)
    assert np.abs(inertia).max() > 0.05
    assert np.abs(shaken).max() > 0.05
