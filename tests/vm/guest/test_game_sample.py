"""The example game, played with a joystick that the kernel has: the knob."""

from __future__ import annotations

import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

import torsio
from tests.vm.guest.torque_log import let_pass, plug, read_log, turn
from tests.vm.guest.udev import run
from tests.vm.guest.virtual_bus import TREE, VirtualBus, wait_for

PROGRAM = TREE / "build/asan-ubsan/examples/game/safe"


@pytest.mark.kernel("6.12")
@pytest.mark.usefixtures("udev")
def test_game_is_felt_at_the_knob_and_lets_go_when_interrupted(
    bus: VirtualBus, tmp_path: Path
) -> None:
    gain = torsio.GameConfig().spring_gain
    range_deg = torsio.GameConfig().range_deg
    # At this rate the device does not soften the wall.
    knob, log = plug(bus, tmp_path, rate_hz=4_000, range_deg=range_deg, spring_gain=gain)
    run("udevadm", "settle")
    game = subprocess.Popen([PROGRAM, "--no-window"], stdout=subprocess.PIPE, text=True)
    with torsio.open(knob.serial) as opened:
        wait_for("all its forces", lambda: len(opened.game_effects()) == 9)
        turn(knob, tmp_path, [(0.0, 0.0), (0.6, np.radians(100)), (1.0, np.radians(45))])
        let_pass(knob, 1.2)
        game.send_signal(signal.SIGINT)
        words, _ = game.communicate(timeout=30)
        assert (game.returncode, words.count("open\n")) == (0, 2), words
        wait_for("the game to let go", lambda: opened.health().owner == "none")
    _, angle, torque = read_log(bus, log)
    deg = np.degrees(angle)
    assert torque[deg > 99].min() < -0.99  # five springs: full torque within 5 degrees
    assert np.abs(torque[(deg > 5) & (deg < 30)]).max() == pytest.approx(0.3, abs=0.06)
    knock = (deg > 60) & (deg < 70)
    assert np.ptp(torque[knock]) > 0.8
    assert np.abs(torque[-100:]).max() == 0
