"""Linux's own programs that try forces out: fftest and ffcfstress of linuxconsole 1.8."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.vm.guest.gamepad import Gamepad
from tests.vm.guest.torque_log import held, let_pass, plug, read_log, turn
from tests.vm.guest.virtual_bus import VirtualBus, wait_for

pytestmark = pytest.mark.kernel("6.12")

ANGLE_RAD = np.pi / 8  # half of a half range of 45 degrees


@pytest.mark.odd_trigger
def test_fftest_plays_what_it_says(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path, range_deg=90)
    turn(knob, tmp_path, [(0.0, 0.0), (0.1, ANGLE_RAD)])
    pad = Gamepad(knob)
    said = tmp_path / "said"
    with said.open("w") as out:
        tool = subprocess.Popen(
            ["stdbuf", "-oL", "fftest", pad.path], stdin=subprocess.PIPE, stdout=out, text=True
        )
        assert tool.stdin is not None
        wait_for("its question", lambda: "Enter effect number" in said.read_text())
        for choice in (1, 2):  # its rumble leaves the direction to chance
            tool.stdin.write(f"{choice}\n")
            tool.stdin.flush()
            let_pass(knob, 0.5)
        tool.stdin.write("-1\n")
        tool.stdin.close()
        assert tool.wait(30) == 0
    let_pass(knob, 0.2)
    pad.close()
    text = said.read_text()
    assert "Error" not in text
    assert text.count("OK (id ") == 6  # it has six effects
    _, _, torque = read_log(bus, log)
    # Its gain is three quarters. A constant force of a quarter from 135 degrees, which rises in
    # 256 ms; a spring with a quarter of a coefficient.
    constant = 0.75 * 0x2000 / 0x7FFF * -np.sin(np.radians(135))
    spring = -0.75 * 0x2000 / 0x7FFF / 2
    levels = held(torque, 100)
    assert levels[-2:] == pytest.approx([constant + spring, 0], abs=1e-3)


@pytest.mark.whole
def test_ffcfstress_moves_its_spring_in_many_small_steps(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path)
    pad = Gamepad(knob)
    options = ("-d", pad.path, "-u", "200", "-f", "2", "-a", "0.5", "-s", "1")
    # It knows no end but this one.
    tool = subprocess.Popen(["ffcfstress", *options], stdout=subprocess.DEVNULL)
    let_pass(knob, 1.5)
    tool.kill()
    tool.wait()
    let_pass(knob, 0.2)
    pad.close()
    time_s, _, torque = read_log(bus, log)
    assert np.abs(torque[-50:]).max() == 0
    # The knob is held in its middle: the force follows the moving centre.
    loud = np.flatnonzero(torque)
    part = slice(loud[0] + 200, loud[0] + 1200)
    turns = 2 * np.pi * 2 * time_s[part]
    basis = np.column_stack((np.sin(turns), np.cos(turns)))
    weights, *_ = np.linalg.lstsq(basis, torque[part])
    assert np.hypot(*weights) == pytest.approx(0.5, rel=0.05)
    # It starts its effect anew with each step, so the device does not join them; each is blended.
    # The steps are at most so long, and a blend is one step late.
    step = 0.5 * 2 * np.pi * 2 / 200
    assert np.abs(torque[part] - basis @ weights).max() < 2 * step
    assert np.abs(np.diff(torque[part])).max() < 0.05
