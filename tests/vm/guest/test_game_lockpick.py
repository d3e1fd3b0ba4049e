"""The example game, played with a joystick that the kernel has: the knob."""

from __future__ import annotations

import json
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

import torsio
from tests.vm.guest.torque_log import let_pass, plug, read_log, turn
from tests.vm.guest.udev import run
from tests.vm.guest.virtual_bus import TREE, VirtualBus, wait_for

PROGRAM = TREE / "build/asan-ubsan/examples/game/lockpick"
LIFT_RAD = np.pi / 2  # of a lift of 1


@pytest.mark.whole
@pytest.mark.kernel("6.12")
@pytest.mark.usefixtures("udev")
def test_game_is_felt_at_the_knob_and_lets_go_when_interrupted(
    bus: VirtualBus, tmp_path: Path
) -> None:
    # Range and stiffness as the knob comes, at a rate where its walls are not softened.
    default = torsio.GameConfig()
    knob, log = plug(
        bus, tmp_path, rate_hz=4_000, range_deg=default.range_deg, spring_gain=default.spring_gain
    )
    run("udevadm", "settle")
    report = tmp_path / "report.json"
    options = ("--headless", "--joystick", "0", "--report", str(report))
    game = subprocess.Popen(
        [PROGRAM, *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    with torsio.open(knob.serial) as opened:
        wait_for("all its forces", lambda: len(opened.game_effects()) == 11)
        let_pass(knob, 0.1)  # springs come up in 50 ms
        turn(knob, tmp_path, [(0.0, 0.0), (0.2, -0.2), (0.4, -0.2), (0.6, 0.0)])  # into the floor
        let_pass(knob, 0.7)
        # Every pin once, up and down: the one that binds first is set, and perhaps more.
        for _ in range(5):
            path = [(0.0, 0.0), (0.3, 0.8 * LIFT_RAD), (0.6, 0.0)]
            turn(knob, tmp_path, path)
            let_pass(knob, 0.7)
            knob.say("buttons 1")
            let_pass(knob, 0.1)
            knob.say("buttons 0")
        game.send_signal(signal.SIGINT)
        words, _ = game.communicate(timeout=30)
        assert (game.returncode, words) == (0, "")
        wait_for("the game to let go", lambda: opened.health().owner == "none")
    found = json.loads(report.read_text())
    assert found["set"] >= 1
    assert found["knob"]["errors"] == []
    assert all(effect["uploaded"] for effect in found["knob"]["effects"].values())
    assert found["knob"]["effects"]["click"]["starts"] >= 1
    _, angle, torque = read_log(bus, log)
    # The floor begins at -5.4 degrees and gives full torque within 5 more. The pins' spring pushes
    # down with a fifth, the click knocks with nine tenths.
    face_rad = -0.06 * LIFT_RAD
    assert torque[angle < face_rad - np.radians(5)].max() > 0.99
    shallow = (angle < face_rad - 0.01) & (angle > face_rad - 0.06)
    slope = np.polyfit(angle[shallow], torque[shallow], 1)[0]
    assert slope == pytest.approx(-5 * default.spring_gain / np.radians(450), rel=0.2)
    lifted = (angle > 0.3) & (angle < 0.8 * LIFT_RAD)
    assert np.median(torque[lifted]) == pytest.approx(-0.2, abs=0.05)
    assert np.abs(torque[lifted]).max() > 0.6
    assert np.abs(torque[-100:]).max() == 0
