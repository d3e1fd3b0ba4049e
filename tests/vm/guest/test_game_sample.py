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


@pytest.mark.whole
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
        way = [(0.0, 0.0), (0.4, 60.0), (0.8, 60.0), (1.2, 100.0), (1.4, 100.0), (1.8, 30.0)]
        turn(knob, tmp_path, [(time_s, float(np.radians(deg))) for time_s, deg in way])
        let_pass(knob, 2.0)
        game.send_signal(signal.SIGINT)
        words, _ = game.communicate(timeout=30)
        assert game.returncode == 0
        assert "open\n" in words
        wait_for("the game to let go", lambda: opened.health().owner == "none")
    _, angle, torque = read_log(bus, log)
    deg = np.degrees(angle)
    assert torque[deg > 99].min() < -0.99  # five springs: full torque within 5 degrees
    assert np.abs(torque[(deg > 5) & (deg < 28)]).max() == pytest.approx(0.3, abs=0.06)
    # The notches alone push by 0.25 either way.
    assert np.ptp(torque[(deg > 50) & (deg < 70)]) > 1.2
    assert np.abs(torque[-100:]).max() == 0
