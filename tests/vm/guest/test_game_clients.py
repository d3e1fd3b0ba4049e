"""Players on the knob: two games, a game and the SDK, one that floods it, one that dies."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import torsio
from tests.vm.guest import gamepad
from tests.vm.guest.gamepad import Effect, Gamepad
from tests.vm.guest.torque_log import (
    FULL_NM,
    fall_s,
    held,
    let_pass,
    plug,
    read_log,
    turn,
)
from tests.vm.guest.virtual_bus import VirtualBus, wait_for


def push(level: int, number: int = -1) -> Effect:
    return Effect(gamepad.CONSTANT, gamepad.constant(level), number=number)


# A game and the SDK --------------------------------------------------------------------------


def test_sdk_takes_over_and_gives_back_without_a_jump(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path)
    pad = Gamepad(knob)
    # With an end: Linux 7.2 does not send the second start of an endless effect.
    number = pad.upload(replace(push(32767), length_ms=30_000))
    with torsio.open(knob.serial) as opened:
        opened.play(torsio.Constant(torque_nm=-0.5 * FULL_NM))
        pad.play(number)
        wait_for("the game to have it", lambda: opened.health().owner == "game")
        opened.stream_local_model(torque_nm=0.01)
        wait_for("its refusal", lambda: opened.statistics().local_models_refused)
        let_pass(knob, 0.1)
        opened.arm()
        let_pass(knob, 0.2)
        assert opened.health().owner == "sdk"
        pad.play(number)  # in vain
        let_pass(knob, 0.2)
        assert opened.health().owner == "sdk"
        opened.play(torsio.Constant(torque_nm=0.0))
        let_pass(knob, 0.1)
        opened.disarm()
        let_pass(knob, 0.2)
        assert opened.health().owner == "none"
        pad.play(number)
        wait_for("the game to have it again", lambda: opened.health().owner == "game")
        let_pass(knob, 0.1)
    pad.close()
    let_pass(knob, 0.1)
    _, _, torque = read_log(bus, log)
    assert np.array(held(torque)) == pytest.approx([0, 1, -0.5, 0, 1, 0], abs=1e-3)
    # Down from 1 while the scene comes up to -0.5: both in passive_ramp_s, 50 ticks.
    taken = slice(*np.flatnonzero(np.diff((torque > 0.99).astype(int)) != 0)[1:3])
    assert np.abs(np.diff(torque[taken][:200])).max() < 1.05 * 1.5 / 50


# One that floods it --------------------------------------------------------------------------

_QUEUE = 64  # reports that Linux keeps for an endpoint, HID_OUTPUT_FIFO_SIZE


@pytest.mark.whole
@pytest.mark.kernel("6.1")
@pytest.mark.floods_queue
def test_flood_of_updates_is_late_by_no_more_than_linux_keeps(
    bus: VirtualBus, tmp_path: Path
) -> None:
    """10,000 updates in a second, ten times what the bus carries.

    A minute of it would fill the kernel's log with what it drops; the device's side of a minute is
    tests/cpp/device/game/test_game_reports.cpp.
    """
    knob, log = plug(bus, tmp_path, blend_s=0)
    pad = Gamepad(knob)
    number = pad.upload(push(0))
    pad.play(number)
    updates = [push(1 + level, number).packed for level in range(10_000)]
    for begin_rad, count, last in ((0.0, 3_000, 20_000), (0.1, 10_000, 30_000)):
        begin = time.monotonic()
        for index in range(count):
            if index % 10 == 0:
                while time.monotonic() < begin + index * 1e-4:
                    pass
            pad.upload_packed(updates[index])
        turn(knob, tmp_path, [(0.0, begin_rad), (0.05, begin_rad + 0.1)])  # a mark in the log
        pad.erase(pad.upload(push(0)))  # comes back when the queue is empty
        pad.upload(push(last, number))
        let_pass(knob, 0.1)
    pad.close()
    _, angle, torque = read_log(bus, log)
    level = np.rint(torque * 32767).astype(int)
    for mark, last in ((0.0, 20_000), (0.1, 30_000)):
        end = np.flatnonzero(angle > mark + 1e-9)[0]
        won = np.flatnonzero(level == last)[0]  # though it came last
        late = level[end:won]
        print("still came after the flood:", np.count_nonzero(np.diff(late)))
        assert np.count_nonzero(np.diff(late)) <= _QUEUE + 2
        assert np.diff(late).min() >= 0  # none overtook a newer one


# One that dies -------------------------------------------------------------------------------


def test_killed_game_leaves_no_force(bus: VirtualBus, tmp_path: Path) -> None:
    # Linux closes the files of a killed process: evdev_release, input_ff_flush.
    knob, log = plug(bus, tmp_path)
    ready, done = os.pipe()
    game = os.fork()
    if game == 0:
        pad = Gamepad(knob)
        pad.play(pad.upload(push(32767)))
        os.write(done, b".")
        signal.pause()
    os.read(ready, 1)
    let_pass(knob, 0.3)
    os.kill(game, signal.SIGKILL)
    os.waitpid(game, 0)
    os.close(ready)
    os.close(done)
    with torsio.open(knob.serial) as opened:
        wait_for("the game to let go", lambda: opened.health().owner == "none")
        assert opened.state == "disarmed"
    again = Gamepad(knob)  # all forty are free again
    numbers = [again.upload(push(16000)) for _ in range(40)]
    assert len(set(numbers)) == 40
    again.play(numbers[0])
    let_pass(knob, 0.2)
    again.close()
    time_s, _, torque = read_log(bus, log)
    died = np.flatnonzero(torque > 0.99)[-1] + np.searchsorted(time_s, time_s[0] + 0.1)
    assert fall_s(time_s[:died], torque[:died]) <= 4e-3  # blend_s and two ticks
    felt = np.array([0, 32767, 0, 16000, 0]) / 32767
    assert np.array(held(torque))[:5] == pytest.approx(felt, abs=1e-3)


@pytest.mark.pulls_cable
def test_unplugged_game_fades(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path)
    pad = Gamepad(knob)
    pad.play(pad.upload(push(32767)))
    let_pass(knob, 0.3)
    knob.unplug()
    let_pass(knob, 0.3)
    pad.close()
    time_s, _, torque = read_log(bus, log)
    assert 0.045 < fall_s(time_s, torque) < 0.055  # passive_ramp_s
