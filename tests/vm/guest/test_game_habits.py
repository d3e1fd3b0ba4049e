"""Habits of drivers and games, through Linux's driver: effects that the device ends come back."""

from __future__ import annotations

import fcntl
import os
import struct
import time
from pathlib import Path

import numpy as np
import pytest

import torsio
from tests.vm.guest import gamepad
from tests.vm.guest.gamepad import Effect, Gamepad
from tests.vm.guest.torque_log import FULL_NM, held, let_pass, plug, read_log
from tests.vm.guest.virtual_bus import VirtualBus, VirtualKnob, wait_for


def push(level: int, number: int = -1, direction: int = gamepad.RIGHT) -> Effect:
    return Effect(gamepad.CONSTANT, gamepad.constant(level), number=number, direction=direction)


@pytest.mark.kernel("6.12")
@pytest.mark.odd_trigger
def test_habits_of_games_are_felt_as_they_are_meant(bus: VirtualBus, tmp_path: Path) -> None:
    """Each was seen in a game or driver: SDL, PCSX2, new-lg4ff, hid-tmff2, Linux itself."""
    knob, log = plug(bus, tmp_path)
    pad = Gamepad(knob)
    expected = [0.0]

    def feel(share: float) -> None:
        expected.append(share)
        let_pass(knob, 0.1)

    def sine(offset: int, number: int = -1) -> Effect:
        wave = gamepad.periodic(gamepad.SINE, 0, 100, offset=offset)
        return Effect(gamepad.PERIODIC, wave, number=number)

    def ramp(level: int, number: int = -1) -> Effect:
        return Effect(gamepad.RAMP, gamepad.ramp(level, level), 0x7000, number=number)

    # Uploaded and played in each frame: one force without gaps.
    number = pad.upload(push(16000))
    for _ in range(20):
        pad.upload(push(16000, number))
        pad.play(number)
        time.sleep(1 / 60)
    feel(16000 / 32767)
    # Changed by the direction only.
    for direction, share in ((gamepad.LEFT, -1.0), (0xE000, np.sqrt(0.5))):
        pad.upload(push(16000, number, direction))
        feel(share * 16000 / 32767)
    # Device gain to 0 and back.
    for gain, share in ((0, 0.0), (0xFFFF, np.sqrt(0.5))):
        pad.set_gain(gain)
        feel(share * 16000 / 32767)
    pad.erase(number)
    feel(0)
    # A wave without amplitude; a ramp with equal ends.
    for make in (sine, ramp):
        number = pad.upload(make(12000))
        pad.play(number)
        feel(12000 / 32767)
        pad.upload(make(-12000, number))
        feel(-12000 / 32767)
        pad.erase(number)
        feel(0)
    # An envelope that an update has no more. Linux from 6.15 on does not tell: then it goes on.
    rising = gamepad.constant(20000, gamepad.Envelope(attack_ms=150))
    number = pad.upload(Effect(gamepad.CONSTANT, rising))
    pad.play(number)
    pad.upload(push(20000, number))
    time.sleep(0.2)
    feel(20000 / 32767)
    pad.erase(number)
    feel(0)
    # A trigger button that does not exist; played all the same.
    triggered = push(-8000).packed
    struct.pack_into("<H", triggered, 6, 0x12F)
    number = pad.upload_packed(triggered)
    pad.play(number)
    feel(-8000 / 32767)
    # Closed and opened, and all made anew.
    pad.close()
    feel(0)
    pad = Gamepad(knob)
    pad.play(pad.upload(push(24000)))
    feel(24000 / 32767)
    pad.close()
    feel(0)
    _, _, torque = read_log(bus, log)
    assert held(torque) == pytest.approx(expected, abs=1e-3)


def test_update_brings_back_what_the_sdk_has_interrupted(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path)
    pad = Gamepad(knob)
    number = pad.upload(push(16000))
    pad.play(number)
    let_pass(knob, 0.2)
    with torsio.open(knob.serial) as opened:
        opened.arm()
        let_pass(knob, 0.2)
        opened.disarm()
        let_pass(knob, 0.2)
        assert [e.state for e in opened.game_effects()] == ["set_aside"]
        pad.upload(push(24000, number))
        wait_for("the game to have it again", lambda: opened.health().owner == "game")
        let_pass(knob, 0.2)
        (effect,) = opened.game_effects()
        assert (effect.kind, effect.state) == ("constant", "playing")
        assert effect.torque_nm == pytest.approx(FULL_NM * 24000 / 32767, rel=1e-3)
    pad.close()
    let_pass(knob, 0.1)
    _, _, torque = read_log(bus, log)
    assert np.array(held(torque)) == pytest.approx(
        np.array([0, 16000, 0, 24000, 0]) / 32767, abs=1e-3
    )


def _game_hidraw(knob: VirtualKnob) -> Path:
    """Return the file for programs that write the game interface's reports themselves."""
    folder = knob.sysfs / f"{knob.bus_id}:1.1"
    found = wait_for("a hidraw device", lambda: list(folder.glob("*/hidraw/hidraw*")))
    path = Path("/dev") / found[0].name
    wait_for("its file", path.exists)
    return path


@pytest.mark.whole
def test_program_that_closes_hidraw_leaves_no_force(bus: VirtualBus, tmp_path: Path) -> None:
    # As Wine's and Proton's services do: the reports are their own, and no driver sees them.
    knob, log = plug(bus, tmp_path)
    file = os.open(_game_hidraw(knob), os.O_RDWR)
    create = bytearray(struct.pack("<BBH", 0x21, 1, 0))
    fcntl.ioctl(file, 0xC0004806 | len(create) << 16, create)  # HIDIOCSFEATURE
    load = bytearray(struct.pack("<B4x", 0x22))
    fcntl.ioctl(file, 0xC0004807 | len(load) << 16, load)  # HIDIOCGFEATURE
    block, status = load[1], load[2]
    assert status == 1
    effect = (0x11, block, 1, 0xFFFF, 0, 0, 32767, 0, 2, 24575, 0)
    os.write(file, struct.pack("<BBBHHHHBBHH", *effect))
    os.write(file, struct.pack("<BBh", 0x15, block, 32767))
    os.write(file, struct.pack("<BBBB", 0x1A, block, 1, 1))
    let_pass(knob, 2.0)
    with torsio.open(knob.serial) as opened:
        assert opened.health().owner == "game"  # silent, but it is there
        os.close(file)
        wait_for("the force to end", lambda: opened.health().owner == "none")
    time_s, _, torque = read_log(bus, log)
    full_s = np.count_nonzero(torque > 0.99) * (time_s[1] - time_s[0])
    assert 2.0 < full_s < 6.0  # far from the ten seconds of silence
    assert torque[-1] == 0
