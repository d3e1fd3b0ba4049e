"""Programs that nobody here wrote: SDL's own test of forces, and python-evdev of the system."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.vm.guest.torque_log import held, let_pass, plug, read_log, turn
from tests.vm.guest.udev import run
from tests.vm.guest.virtual_bus import VirtualBus

pytestmark = [pytest.mark.games, pytest.mark.usefixtures("udev")]

TESTHAPTIC = "/usr/libexec/installed-tests/SDL2/testhaptic"
PLAYED_S = 6.0  # testhaptic's time for each effect; the last second is a pause
EVDEV_PROGRAM = """
import time
from evdev import InputDevice, ecodes, ff, list_devices
(knob,) = [d for d in map(InputDevice, list_devices()) if "haptic knob" in d.name]
info = knob.absinfo(ecodes.ABS_X)
print(info.min, info.max, knob.ff_effects_count, len(knob.capabilities()[ecodes.EV_FF]))
level = ff.EffectType(ff_constant_effect=ff.Constant(16384, ff.Envelope(0, 0, 0, 0)))
number = knob.upload_effect(
    ff.Effect(ecodes.FF_CONSTANT, -1, 0xC000, ff.Trigger(0, 0), ff.Replay(0, 0), level)
)
knob.write(ecodes.EV_FF, number, 1)
time.sleep(0.5)
knob.erase_effect(number)
"""


def test_sdl_s_own_test_of_forces_plays_all_of_its_effects(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path, range_deg=90)
    # To and fro, for effects that answer to the motion.
    turn(knob, tmp_path, [(0.05 * n, 0.4 + n % 2 / 10) for n in range(1400)])
    run("udevadm", "settle")
    done = subprocess.run((TESTHAPTIC,), capture_output=True, text=True, timeout=900, check=False)
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert "ERROR" not in said
    played = said.count("Playing effect")
    assert played == said.count("   effect ") == 9, said
    let_pass(knob, 0.3)
    time_s, _, torque = read_log(bus, log)
    assert np.abs(torque[-50:]).max() == 0
    begin_s = time_s[np.flatnonzero(torque)[0]]
    for n in range(played):
        since_s = time_s - begin_s - PLAYED_S * n
        assert np.abs(torque[(since_s > 0.2) & (since_s < 4.8)]).max() > 0.01, (n, said)


def test_python_evdev_finds_the_knob_and_pushes_it(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path)
    run("udevadm", "settle")
    done = subprocess.run(
        ("/usr/bin/python3", "-c", EVDEV_PROGRAM), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    # Every kind of Linux's, with waves' shapes and rumble, and the gain.
    assert done.stdout.split() == ["-32767", "32767", "40", "14"]
    let_pass(knob, 0.2)
    _, _, torque = read_log(bus, log)
    assert held(torque) == pytest.approx([0, 0.5, 0], abs=1e-3)
