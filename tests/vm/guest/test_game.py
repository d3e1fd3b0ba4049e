"""Force feedback as Linux's own driver gets it: what it takes, and what the motor makes of it."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

import numpy as np
import pytest

import torsio
from tests.vm.guest import gamepad
from tests.vm.guest.effect_forms import cases, length_error_s, residual
from tests.vm.guest.gamepad import Effect, Gamepad
from tests.vm.guest.torque_log import (
    Floats,
    held,
    let_pass,
    pieces,
    plug,
    read_log,
    turn,
)
from tests.vm.guest.virtual_bus import VirtualBus, VirtualKnob, wait_for


def test_driver_takes_all_that_is_advertised(knob: VirtualKnob) -> None:
    pad = Gamepad(knob)
    # All but custom forces and autocenter. The kernel makes rumble of a sine.
    expected = {*range(gamepad.RUMBLE, gamepad.SAW_DOWN + 1), gamepad.GAIN}
    assert pad.bits(0x15) == expected
    assert pad.effects() == 40
    assert pad.bits(0x03) == {0, 1}  # X, and a Y that stays
    assert pad.bits(0x01) == {0x120, 0x121}  # two buttons of a joystick and nothing else
    assert pad.axis()[:3] == (0, -32767, 32767)
    effect = Effect(gamepad.CONSTANT, gamepad.constant(1))
    numbers = [pad.upload(effect) for _ in range(40)]
    assert sorted(numbers) == list(range(40))
    with pytest.raises(OSError, match="No space left"):
        pad.upload(effect)
    pad.erase(numbers[7])

    def upload_again() -> list[int]:
        try:
            return [pad.upload(effect)]
        except OSError:
            return []

    # The free block goes over another endpoint than the new one: it may come late.
    assert wait_for("the block to be free", upload_again) == [numbers[7]]
    pad.close()


def test_a_program_that_comes_late_learns_axis_and_buttons(bus: VirtualBus, tmp_path: Path) -> None:
    knob, _ = plug(bus, tmp_path)
    # By half of half the range, with a button held, while nobody has the device open.
    turn(knob, tmp_path, [(0.0, 0.0), (0.2, np.radians(225))])
    knob.say("buttons 1")
    let_pass(knob, 0.5)
    pad = Gamepad(knob)
    wait_for("the axis", lambda: abs(pad.axis().value - 16383) < 300)
    wait_for("the button", lambda: 0x120 in pad.pressed())
    pad.close()
    knob.say("buttons 0")  # between two programs
    let_pass(knob, 0.5)
    later = Gamepad(knob)
    wait_for("the button to be let go", lambda: 0x120 not in later.pressed())
    later.close()


def test_reports_go_over_the_control_pipe_too(bus: VirtualBus, tmp_path: Path) -> None:
    """hidapi's hid_get_input_report and hid_send_output_report; Linux has them in hidraw."""
    knob, _ = plug(bus, tmp_path)
    knob.say("buttons 2")
    let_pass(knob, 0.2)
    folder = knob.sysfs / f"{knob.bus_id}:1.1"
    (found,) = wait_for("a hidraw device", lambda: list(folder.glob("*/hidraw/hidraw*")))
    file = os.open(Path("/dev") / found.name, os.O_RDWR)
    state = bytearray([1, 0, 0, 0, 0, 0])
    assert fcntl.ioctl(file, 0xC006480A, state) == 6  # HIDIOCGINPUT of 6 bytes
    assert state == bytes([1, 0, 0, 2, 0, 0])
    create = bytearray([0x21, 1, 0, 0])
    fcntl.ioctl(file, 0xC0044806, create)  # HIDIOCSFEATURE
    for report in ([0x15, 1, 0, 0x20], [0x1A, 1, 1, 1]):
        assert fcntl.ioctl(file, 0xC004480B, bytearray(report)) == 4  # HIDIOCSOUTPUT
    with torsio.open(knob.serial) as opened:
        wait_for("the game", lambda: opened.health().owner == "game")
    os.close(file)


# Effects that depend on time only -----------------------------------------------------------------


def test_timed_effects_have_their_closed_form(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path)
    pad = Gamepad(knob)
    pause_s = 0.08
    for case in cases().values():
        number = pad.upload(case.effect)
        pad.play(number, loops=case.loops)
        let_pass(knob, case.length_s + case.effect.delay_ms / 1e3 + 3 * pause_s)
        pad.erase(number)
    pad.close()
    time_s, _, torque = read_log(bus, log)
    found = pieces(time_s, torque, pause_s)
    assert len(found) == len(cases())
    errors, late_s = {}, {}
    for (name, case), piece in zip(cases().items(), found, strict=True):
        errors[name] = float(residual(*piece, case).max())
        late_s[name] = length_error_s(*piece, case)
    print({name: (round(errors[name], 4), round(late_s[name], 4)) for name in errors})
    # A tick late on the steepest line, which is 2 / 100 ms for a sawtooth, and on the sine.
    assert {name: e for name, e in errors.items() if e > 0.05} == {}
    assert {name: late for name, late in late_s.items() if abs(late) > 5e-3} == {}


def test_playing_effect_is_changed_scaled_stopped_and_erased(
    bus: VirtualBus, tmp_path: Path
) -> None:
    knob, log = plug(bus, tmp_path, gain=0.75)
    pad = Gamepad(knob)

    def show(level: int, number: int) -> int:
        return pad.upload(Effect(gamepad.CONSTANT, gamepad.constant(level), number=number))

    number = show(8000, -1)
    pad.play(number)
    let_pass(knob, 0.1)
    for level in (16000, -24000, 32767):
        show(level, number)
        let_pass(knob, 0.1)
    for gain in (0x8000, 0x0000, 0xFFFF):
        pad.set_gain(gain)
        let_pass(knob, 0.1)
    pad.play(number, loops=0)
    let_pass(knob, 0.1)
    pad.play(number)
    let_pass(knob, 0.1)
    pad.erase(number)
    let_pass(knob, 0.1)
    pad.close()
    _, _, torque = read_log(bus, log)
    expected = [0, 8000, 16000, -24000, 32767, 32767 / 2, 0, 32767, 0, 32767, 0]
    assert np.abs(np.array(held(torque)) - 0.75 * np.array(expected) / 32767).max() < 1e-3


# Conditions ----------------------------------------------------------------------------------


def follow(
    bus: VirtualBus,
    tmp_path: Path,
    effect: Effect,
    path: list[tuple[float, float]],
    *,
    range_deg: float = 900,
) -> tuple[Floats, Floats, Floats]:
    """Turn the knob along a path while an effect plays; return what `read_log` does."""
    knob, log = plug(bus, tmp_path, range_deg=range_deg)
    pad = Gamepad(knob)
    pad.play(pad.upload(effect))
    let_pass(knob, 0.1)
    turn(knob, tmp_path, path)
    let_pass(knob, path[-1][0] + 0.3)
    pad.close()
    return read_log(bus, log)


def test_spring_answers_to_the_angle_beyond_its_dead_band(bus: VirtualBus, tmp_path: Path) -> None:
    parameters = gamepad.condition(30000, saturation=0xC000, dead_band=0x1000)
    path = [(0.0, 0.0), (0.5, 0.75), (1.5, -0.75), (2.0, 0.0)]
    effect = Effect(gamepad.SPRING, parameters)
    _, angle, torque = follow(bus, tmp_path, effect, path, range_deg=90)
    x = angle / (np.pi / 4)
    band = 0x1000 / 0xFFFF
    beyond = np.sign(x) * np.maximum(np.abs(x) - band, 0)
    expected = np.clip(-30000 / 32767 * beyond, -0.75, 0.75)
    assert expected.max() > 0.74
    moving = np.abs(x) > 0.02
    # A tick late at 1.5 rad/s, twice.
    assert np.abs(torque - expected)[moving].max() < 0.01


def plateau(time_s: Floats, rate: Floats, torque: Floats, value: float) -> float:
    """Return the mean torque where a rate has had a value for 60 ms."""
    steady = np.convolve(np.abs(rate - value) < 0.02 * abs(value), np.ones(60), "full")[: rate.size]
    assert (steady > 59).sum() > 20
    return float(torque[steady > 59].mean())


@pytest.mark.parametrize(
    ("kind", "share"), [(gamepad.DAMPER, 0.5 * 10 / 20), (gamepad.FRICTION, 0.5)]
)
def test_damper_and_friction_resist_the_motion(
    bus: VirtualBus, tmp_path: Path, kind: int, share: float
) -> None:
    path = [(0.0, 0.0), (0.3, 3.0), (0.4, 3.0), (0.7, 0.0), (1.0, 0.0)]
    effect = Effect(kind, gamepad.condition(16384))
    time_s, angle, torque = follow(bus, tmp_path, effect, path)
    speed = np.gradient(angle, time_s)
    assert plateau(time_s, speed, torque, 10.0) == pytest.approx(-share, rel=0.03)
    assert plateau(time_s, speed, torque, -10.0) == pytest.approx(share, rel=0.03)


def test_inertia_resists_the_acceleration(bus: VirtualBus, tmp_path: Path) -> None:
    t = np.arange(0, 0.2, 1e-3)
    path = [(float(s), float(150 * s**2)) for s in t]
    effect = Effect(gamepad.INERTIA, gamepad.condition(32767))
    time_s, angle, torque = follow(bus, tmp_path, effect, path)
    acceleration = np.gradient(np.gradient(angle, time_s), time_s)
    mean = plateau(time_s, acceleration, torque, 300.0)
    assert mean == pytest.approx(-300 / 3000, rel=0.05)
