"""Programs and libraries that nobody here wrote: SDL's own tests, OIS, python-evdev.

OIS takes 10 s and a compiled program. It runs with ``./dev test games``.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.vm.guest.torque_log import held, let_pass, pieces, plug, read_log, turn
from tests.vm.guest.udev import run
from tests.vm.guest.virtual_bus import TREE, VirtualBus, wait_for

pytestmark = pytest.mark.usefixtures("udev")

SDL_TESTS = Path("/usr/libexec/installed-tests/SDL2")
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


def test_sdl_s_own_test_of_joysticks_sees_axis_and_buttons(bus: VirtualBus, tmp_path: Path) -> None:
    knob, _ = plug(bus, tmp_path)
    run("udevadm", "settle")
    said = tmp_path / "said"
    with said.open("w") as out:
        tool = subprocess.Popen(
            (SDL_TESTS / "testjoystick",),
            env={
                "SDL_VIDEODRIVER": "dummy",
                "SDL_RENDER_DRIVER": "software",  # looks for no graphics card
                "SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS": "1",
            },
            stdout=out,
            stderr=out,
        )

    def hear(words: str) -> None:
        try:
            wait_for(words, lambda: words in said.read_text())
        except TimeoutError as wrong:
            raise AssertionError(f"testjoystick has said: {said.read_text()}") from wrong

    hear("axes: 2")
    for order, words in (
        *(("buttons 1", "button 0 down"), ("buttons 2", "button 1 down")),
        ("angle 1", "axis 0 value: "),
    ):
        knob.say(order)
        hear(words)
    tool.terminate()
    assert tool.wait(30) == 0, said.read_text()


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


@pytest.mark.games
@pytest.mark.odd_trigger
def test_ois_opened_late_sees_axis_and_button_and_plays_all_of_its_effects(
    bus: VirtualBus, tmp_path: Path
) -> None:
    knob, log = plug(bus, tmp_path, range_deg=90)
    run("udevadm", "settle")  # udev's jscal-restore opens the device
    # By half of half the range, with a button held, while nobody has the device open.
    turn(knob, tmp_path, [(0.0, 0.0), (0.1, np.pi / 8)])
    knob.say("buttons 2")
    let_pass(knob, 0.5)
    said = tmp_path / "said"
    with said.open("w") as out:
        tool = subprocess.Popen(TREE / "build/games/ois", stdin=subprocess.PIPE, stdout=out)
    assert tool.stdin is not None

    def line(number: int) -> str:
        """Wait for a line of the program's own; the library has others."""

        def found() -> list[str]:
            lines = said.read_text().splitlines()
            return [line for line in lines if not line.startswith("Linux")][number:]

        return wait_for(f"line {number}", found)[0]

    assert line(0) == "Torsio haptic knob, axes 2"
    assert int(line(1).split()[1]) == pytest.approx(16384, abs=300)
    knob.say("buttons 0")
    assert line(2) == "let go"
    # To and fro, for effects that answer to the motion.
    turn(knob, tmp_path, [(0.05 * n, 0.4 + n % 2 / 10) for n in range(600)])
    played = []
    for n in range(11):
        os.write(tool.stdin.fileno(), b"\n")
        played.append(line(3 + n))
        let_pass(knob, 0.5)
        os.write(tool.stdin.fileno(), b"\n")
    tool.stdin.close()
    assert tool.wait(30) == 0
    time_s, _, torque = read_log(bus, log)
    peaks = [np.abs(part).max() for _, part in pieces(time_s, torque, 0.1)]
    felt = dict(zip(played, peaks, strict=True))
    for name in ("Constant", "Ramp", "Square", "Triangle", "Sine", "SawToothUp", "SawToothDown"):
        assert felt.pop(name) == pytest.approx(0.5, rel=0.05), name
    assert felt.pop("Friction") == pytest.approx(0.5, rel=0.05)
    assert 0.5 * 0.4 / (np.pi / 4) < felt.pop("Spring") < 0.5 * 0.51 / (np.pi / 4)
    assert felt.pop("Damper") == pytest.approx(0.5 * 2 / 20, rel=0.2)
    assert felt.pop("Inertia") > 0.01
    assert felt == {}
