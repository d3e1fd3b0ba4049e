"""The knob as a dial, as Linux's own drivers and libinput see it.

The kernel's hid-input asks for the fine resolution and gives REL_WHEEL_HI_RES, 120 a detent;
libinput's own tool says what a desktop makes of that.
"""

from __future__ import annotations

import fcntl
import os
import re
import select
import struct
import subprocess
import threading
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import torsio
from tests.vm.guest.gamepad import pressed
from tests.vm.guest.test_reset import reset_port
from tests.vm.guest.torque_log import let_pass, turn
from tests.vm.guest.udev import ENVIRONMENT, run
from tests.vm.guest.virtual_bus import TREE, VirtualBus, VirtualKnob, wait_for
from torsio.apps.cli import app

EV_SYN, EV_KEY, EV_REL = 0x00, 0x01, 0x02
SYN_DROPPED = 3
REL_X, REL_HWHEEL, REL_WHEEL, REL_WHEEL_HI_RES, REL_HWHEEL_HI_RES = 0x00, 0x06, 0x08, 0x0B, 0x0C
REL_DIAL = 0x07
KEY_VOLUMEDOWN, KEY_VOLUMEUP, BTN_0, BTN_LEFT = 114, 115, 0x100, 0x110
# What hid-parser makes of the descriptor that the kernel has.
PARSER = """
import sys
from hid_parser import ReportDescriptor, VariableItem
device = ReportDescriptor(open(sys.argv[1], "rb").read())
for kind, number in (("input", 4), ("output", 5), ("feature", 5), ("feature", 6)):
    found = getattr(device, f"get_{kind}_items")(number)
    values = [value for value in found if isinstance(value, VariableItem)]
    size = int(getattr(device, f"get_{kind}_report_size")(number)) // 8
    named = ((v.usage.page, v.usage.usage, v.logical_min, v.logical_max) for v in values)
    print(kind, size, *("%x:%x=%d..%d" % tuple(map(int, value)) for value in named))
"""
DETENTS, TORQUE_NM = 24, 0.005
PITCH_RAD = 2 * np.pi / DETENTS
_EVENT = struct.Struct("<qqHHi")


def plug_dial(bus: VirtualBus, folder: Path, **settings: str) -> VirtualKnob:
    """Make a knob a dial as a user does, start it anew, and plug it in."""
    options = ["--status", "--storage", str(folder / "storage"), "--log", str(folder / "log")]
    first = bus.plug("DIAL", options=options)
    first.say("still")
    settings = {"personality": "dial", "dial-torque-nm": str(TORQUE_NM), **settings}
    arguments = [word for name, value in settings.items() for word in (f"--{name}", value)]
    result = CliRunner().invoke(app, ["games", "set", "--device", first.serial, *arguments])
    assert result.exit_code == 0, result.output
    with torsio.open(first.serial) as knob:
        knob.configure(torsio.ControlConfig(law="motor_only"))
        knob.save()
    bus.knobs.remove(first)
    first.end()
    second = bus.plug("DIAL", options=options)
    second.say("still")
    return second


class Events:
    """The event devices of the interface, each with what it can do."""

    def __init__(self, knob: VirtualKnob) -> None:
        folder = knob.sysfs / f"{knob.bus_id}:1.1"
        # A mouse, the keys of the volume, and a radial controller.
        found = wait_for(
            "three event devices",
            lambda: (
                nodes if len(nodes := sorted(folder.glob("*/input/input*/event*"))) == 3 else []
            ),
        )
        self.paths = [Path("/dev/input") / node.name for node in found]
        for path in self.paths:
            wait_for("its file", path.exists)
        self.files = [os.open(path, os.O_RDONLY | os.O_NONBLOCK) for path in self.paths]
        self._sums: Counter[tuple[int, int]] = Counter()
        self._lock = threading.Lock()
        self._open = True
        # The kernel keeps no more than 64 events for a program that does not read.
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def close(self) -> None:
        self._open = False
        self._reader.join()
        for file in self.files:
            os.close(file)

    def _read(self) -> None:
        while self._open:
            for file in select.select(self.files, [], [], 0.1)[0]:
                data = os.read(file, 64 * _EVENT.size)
                with self._lock:
                    for _, _, kind, code, value in _EVENT.iter_unpack(data):
                        self._sums[kind, code] += 1 if kind == EV_SYN else value

    def bits(self, file: int, event: int) -> set[int]:
        answer = bytearray(128)
        fcntl.ioctl(file, 0x80804520 + event, answer)
        return {n for n in range(8 * len(answer)) if answer[n // 8] >> n % 8 & 1}

    def mouse(self, axis: int = REL_WHEEL_HI_RES) -> Path:
        """Return the device with this axis."""
        (found,) = [
            path
            for path, file in zip(self.paths, self.files, strict=True)
            if axis in self.bits(file, EV_REL)
        ]
        return found

    def sums(self) -> Counter[tuple[int, int]]:
        """Return the sum of all values since the last call, by kind and code: of keys, presses."""
        with self._lock:
            sums, self._sums = self._sums, Counter()
        assert not sums[EV_SYN, SYN_DROPPED]
        return sums


def turn_detents(
    knob: VirtualKnob, folder: Path, stops: list[tuple[float, float]], begin: float = 0.0
) -> None:
    """Turn to one detent after the other, each within a time in s; then wait until all is told."""
    path, time_s = [(0.0, begin * PITCH_RAD)], 0.0
    for duration_s, detent in stops:
        path.append((time_s + duration_s, detent * PITCH_RAD))
        time_s += duration_s
    turn(knob, folder, path)
    let_pass(knob, time_s + 0.2)


def test_detents_are_120_units_each_way_at_every_speed(bus: VirtualBus, tmp_path: Path) -> None:
    knob = plug_dial(bus, tmp_path)
    events = Events(knob)
    mouse = events.files[events.paths.index(events.mouse())]
    assert events.bits(mouse, EV_REL) >= {
        *(REL_X, REL_WHEEL, REL_HWHEEL, REL_WHEEL_HI_RES, REL_HWHEEL_HI_RES)
    }
    assert BTN_LEFT in events.bits(mouse, EV_KEY)
    # Slow, fast, back, faster than ten turns a second.
    stops = [(0.5, 5.0), (0.05, 29.0), (0.4, -7.0), (0.1, -31.0)]
    at = 0.0
    for duration_s, detent in stops:
        turn_detents(knob, tmp_path, [(duration_s, detent)], begin=at)
        sums = events.sums()
        steps = round(at - detent)  # clockwise, to larger angles, is down
        assert sums[EV_REL, REL_WHEEL_HI_RES] == 120 * steps
        assert sums[EV_REL, REL_WHEEL] == steps
        assert not sums[EV_REL, REL_HWHEEL_HI_RES]
        assert not sums[EV_REL, REL_X]
        at = detent
    # A rest between two detents is told as one.
    turn_detents(knob, tmp_path, [(0.3, at + 0.5)], begin=at)
    assert abs(events.sums()[EV_REL, REL_WHEEL_HI_RES] + 60) <= 1
    events.close()


def to_and_fro(knob: VirtualKnob, folder: Path, events: Events, begin: float) -> tuple[int, int]:
    """Turn one detent on and back again twice, and return the detents each way."""
    turn_detents(knob, folder, [(0.1, np.floor(begin) + 1)], begin=begin)
    events.sums()
    at, up, down = np.floor(begin) + 1, 0, 0
    for _ in range(2):
        turn_detents(knob, folder, [(0.1, at + 1)], begin=at)
        down -= events.sums()[EV_REL, REL_WHEEL]
        turn_detents(knob, folder, [(0.1, at)], begin=at + 1)
        up += events.sums()[EV_REL, REL_WHEEL]
    return down, up


def test_single_detents_are_heard_wherever_a_program_has_left_the_knob(
    bus: VirtualBus, tmp_path: Path
) -> None:
    knob = plug_dial(bus, tmp_path, **{"dial-torque-nm": "0"})
    events = Events(knob)
    at = 0.0
    for place in (0.25, 6.5):  # tests/cpp/device/dial has every place
        with torsio.open(knob.serial) as opened:
            opened.arm()
            turn(knob, tmp_path, [(0.0, at * PITCH_RAD), (0.2, place * PITCH_RAD)])
            let_pass(knob, 0.3)
        let_pass(knob, 0.2)
        assert to_and_fro(knob, tmp_path, events, place) == (2, 2)
        at = np.floor(place) + 1
    events.close()


def test_sleep_and_port_reset_change_neither_resolution_nor_buttons(
    bus: VirtualBus, tmp_path: Path
) -> None:
    knob = plug_dial(bus, tmp_path)
    events = Events(knob)
    mouse = events.files[events.paths.index(events.mouse())]
    knob.say("buttons 1")
    wait_for("the button", lambda: BTN_LEFT in pressed(mouse))
    knob.say("suspend")
    knob.say("buttons 0")
    let_pass(knob, 0.1)
    knob.say("resume")
    wait_for("the button to be let go", lambda: BTN_LEFT not in pressed(mouse))
    # As on a resume that resets the port: the kernel configures the device, and asks for no more.
    knob.say("reset")
    reset_port(knob)
    knob.say("resume")
    let_pass(knob, 0.2)
    events.sums()
    turn_detents(knob, tmp_path, [(0.3, 3.0)])
    assert events.sums()[EV_REL, REL_WHEEL_HI_RES] == -360
    events.close()


def test_a_program_that_comes_late_sees_what_is_pressed(bus: VirtualBus, tmp_path: Path) -> None:
    knob = plug_dial(bus, tmp_path)
    knob.say("buttons 1")
    let_pass(knob, 0.5)  # nobody has the device open
    events = Events(knob)
    mouse = events.files[events.paths.index(events.mouse())]
    wait_for("the button", lambda: BTN_LEFT in pressed(mouse))
    events.close()
    knob.say("buttons 0")
    let_pass(knob, 0.5)
    events = Events(knob)
    mouse = events.files[events.paths.index(events.mouse())]
    wait_for("the button to be let go", lambda: BTN_LEFT not in pressed(mouse))
    events.close()


@pytest.mark.kernel("6.12")
def test_volume_and_pan(bus: VirtualBus, tmp_path: Path) -> None:
    knob = plug_dial(bus, tmp_path, **{"dial-use": "volume"})
    events = Events(knob)
    turn_detents(knob, tmp_path, [(0.2, 6.0), (0.2, 4.0)])
    sums = events.sums()
    assert sums[EV_KEY, KEY_VOLUMEUP] == 6
    assert sums[EV_KEY, KEY_VOLUMEDOWN] == 2
    assert not [code for kind, code in sums if kind == EV_REL]
    events.close()
    with torsio.open(knob.serial) as opened:
        wait_for("the dial to rest", lambda: opened.health().owner == "none")
        opened.update(dial_use="pan")  # takes effect at once
    turn_detents(knob, tmp_path, [(0.2, 7.0)], begin=4.0)
    events = Events(knob)
    turn_detents(knob, tmp_path, [(0.2, 10.0)], begin=7.0)
    sums = events.sums()
    assert sums[EV_REL, REL_HWHEEL_HI_RES] == 360
    assert sums[EV_REL, REL_HWHEEL] == 3
    events.close()


def test_radial_controller_turns_is_pressed_and_clicks(bus: VirtualBus, tmp_path: Path) -> None:
    knob = plug_dial(bus, tmp_path, **{"dial-use": "radial"})
    events = Events(knob)
    dial = events.files[events.paths.index(events.mouse(REL_DIAL))]
    # Tenths of a degree, clockwise positive.
    for begin, end in ((0.0, 5.0), (5.0, -2.0)):
        turn_detents(knob, tmp_path, [(0.3, end)], begin=begin)
        sums = events.sums()
        assert sums[EV_REL, REL_DIAL] == 150 * (end - begin)
        assert {code for kind, code in sums if kind == EV_REL} == {REL_DIAL}
    knob.say("buttons 1")
    wait_for("the button", lambda: BTN_0 in pressed(dial))
    knob.say("buttons 0")
    wait_for("the button to be let go", lambda: BTN_0 not in pressed(dial))
    assert not events.sums()[EV_KEY, BTN_LEFT]
    events.close()
    # Three clicks that Windows would ask for, and what it reads before.
    (node,) = (knob.sysfs / f"{knob.bus_id}:1.1").glob("*/hidraw/hidraw*")
    file = os.open(f"/dev/{node.name}", os.O_RDWR)
    waveforms = bytearray([6, *bytes(10)])
    fcntl.ioctl(file, 0xC00B4807, waveforms)  # HIDIOCGFEATURE
    assert waveforms == struct.pack("<BIH4B", 6, 0x10037, 5000, 3, 4, 8, 0)
    let_pass(knob, 1.5)  # the dial has let go
    os.write(file, struct.pack("<4BH", 5, 3, 100, 2, 200))
    let_pass(knob, 1.5)
    os.close(file)
    bus.end()
    time_s, torque_nm = np.loadtxt(tmp_path / "log", delimiter=",", skiprows=1, usecols=(0, 2)).T
    loud_s = 1e-9 * time_s[np.abs(torque_nm) > 1e-3]
    starts_s = loud_s[1:][np.diff(loud_s) > 0.05][-3:]
    assert np.diff(starts_s) == pytest.approx([0.2, 0.2], abs=0.002)


@pytest.mark.games
def test_another_parser_reads_the_radial_controller(bus: VirtualBus, tmp_path: Path) -> None:
    knob = plug_dial(bus, tmp_path)
    (descriptor,) = (knob.sysfs / f"{knob.bus_id}:1.1").glob("*/report_descriptor")
    said = run(TREE / "build/players/bin/python", "-W", "ignore", "-c", PARSER, descriptor)
    asked = "e:23=0..100 e:24=0..255 e:25=0..2000"  # intensity, repeats, period
    assert said.splitlines() == [
        "input 3 9:1=0..1 1:37=-3600..3600",
        f"output 5 e:21=1..4 {asked}",
        f"feature 5 e:20=0..4 {asked}",
        "feature 10 e:22=65591..65591 e:28=0..32767 a:3=3..3 a:4=4..4 a:3=0..255 a:4=0..255",
    ]


@pytest.mark.usefixtures("udev")
def test_libinput_scrolls_by_the_same_detents(bus: VirtualBus, tmp_path: Path) -> None:
    knob = plug_dial(bus, tmp_path)
    run("udevadm", "settle")
    events = Events(knob)
    mouse = events.mouse()
    assert "ID_INPUT_MOUSE=1" in run("udevadm", "info", "--query=property", str(mouse))
    log = tmp_path / "libinput"
    with log.open("w") as out:
        tool = subprocess.Popen(
            ["stdbuf", "-oL", "libinput", "debug-events", "--device", str(mouse)],
            env=ENVIRONMENT, stdout=out, stderr=subprocess.STDOUT,
        )  # fmt: skip
        wait_for("libinput to know it", lambda: "DEVICE_ADDED" in log.read_text())
        turn_detents(knob, tmp_path, [(0.4, 9.0)])
        wait_for("the last of it", lambda: "SCROLL_WHEEL" in log.read_text())
        turn_detents(knob, tmp_path, [(0.2, 3.0)], begin=9.0)
        tool.terminate()
        tool.wait()
    said = log.read_text()
    assert re.search(r"DEVICE_ADDED .* cap:.*p", said), said
    v120 = [
        float(found[1])
        for found in re.finditer(r"POINTER_SCROLL_WHEEL .*vert -?[\d.]+/(-?[\d.]+)\*?", said)
    ]
    assert len(v120) > 3, said
    # libinput's down is positive.
    assert sum(x for x in v120 if x > 0) == 9 * 120, said
    assert sum(x for x in v120 if x < 0) == -6 * 120, said
    events.close()
