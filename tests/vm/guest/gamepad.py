"""The game interface as games see it: an event device (linux/input.h)."""

from __future__ import annotations

import fcntl
import os
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from tests.vm.guest.virtual_bus import VirtualKnob, wait_for

# Kinds of effects and of waves.
RUMBLE, PERIODIC, CONSTANT, SPRING, FRICTION, DAMPER, INERTIA, RAMP = range(0x50, 0x58)
SQUARE, TRIANGLE, SINE, SAW_UP, SAW_DOWN = range(0x58, 0x5D)
GAIN, AUTOCENTER = 0x60, 0x61
LEFT, RIGHT = 0x4000, 0xC000  # where a force goes to

_EV_ABS, _EV_FF = 0x03, 0x15
_EFFECT_BYTES = 48
_UPLOAD, _ERASE, _EFFECTS = 0x40304580, 0x40044581, 0x80044584


@dataclass(frozen=True)
class Envelope:
    """Levels from 0 to 32767, times in ms."""

    attack_ms: int = 0
    attack_level: int = 0
    fade_ms: int = 0
    fade_level: int = 0

    @property
    def packed(self) -> bytes:
        return struct.pack("<4H", self.attack_ms, self.attack_level, self.fade_ms, self.fade_level)


@dataclass(frozen=True)
class Effect:
    """struct ff_effect; `parameters` belong to its kind."""

    kind: int
    parameters: bytes
    length_ms: int = 0  # 0: without end
    delay_ms: int = 0
    direction: int = RIGHT
    number: int = field(default=-1)

    @property
    def packed(self) -> bytearray:
        head = struct.pack(
            "<HhHHHHH2x",
            *(self.kind, self.number, self.direction, 0, 0, self.length_ms, self.delay_ms),
        )
        return bytearray((head + self.parameters).ljust(_EFFECT_BYTES, b"\0"))


def constant(level: int, envelope: Envelope | None = None) -> bytes:
    """Return a constant force's parameters, and so below."""
    return struct.pack("<h", level) + (envelope or Envelope()).packed


def ramp(start: int, end: int, envelope: Envelope | None = None) -> bytes:
    return struct.pack("<2h", start, end) + (envelope or Envelope()).packed


def periodic(
    wave: int,
    magnitude: int,
    period_ms: int,
    *,
    offset: int = 0,
    phase: int = 0,
    envelope: Envelope | None = None,
) -> bytes:
    """Phase: 0x10000 is a whole turn."""
    head = struct.pack("<HHhhH", wave, period_ms, magnitude, offset, phase)
    return head + (envelope or Envelope()).packed


def condition(
    coefficient: int, *, saturation: int = 0xFFFF, dead_band: int = 0, center: int = 0
) -> bytes:
    one = struct.pack(
        "<HHhhHh", saturation, saturation, coefficient, coefficient, dead_band, center
    )
    return one * 2


class Axis(NamedTuple):
    """struct input_absinfo; changes of less than the fuzz are held back or halved."""

    value: int
    minimum: int
    maximum: int
    fuzz: int
    flat: int
    resolution: int


def pressed(file: int) -> set[int]:
    """Return the buttons of an event device that the kernel holds for pressed, EVIOCGKEY."""
    answer = bytearray(96)
    fcntl.ioctl(file, 0x80604518, answer)
    return {n for n in range(8 * len(answer)) if answer[n // 8] >> n % 8 & 1}


class Gamepad:
    """An event device that is open."""

    def __init__(self, knob: VirtualKnob) -> None:
        folder = knob.sysfs / f"{knob.bus_id}:1.1"
        found = wait_for("an event device", lambda: list(folder.glob("*/input/input*/event*")))
        self.path = Path("/dev/input") / found[0].name
        wait_for("its file", self.path.exists)
        self.file = os.open(self.path, os.O_RDWR | os.O_NONBLOCK)
        self.name = (found[0].parent / "name").read_text().strip()

    def close(self) -> None:
        os.close(self.file)

    def bits(self, event: int) -> set[int]:
        """Return the codes of a kind of event, EVIOCGBIT."""
        answer = bytearray(128)
        fcntl.ioctl(self.file, 0x80804520 + event, answer)
        return {n for n in range(8 * len(answer)) if answer[n // 8] >> n % 8 & 1}

    def pressed(self) -> set[int]:
        """Return the buttons that the kernel holds for pressed, EVIOCGKEY."""
        return pressed(self.file)

    def effects(self) -> int:
        """Return how many effects it can hold, EVIOCGEFFECTS."""
        answer = bytearray(4)
        fcntl.ioctl(self.file, _EFFECTS, answer)
        return int.from_bytes(answer, "little")

    def axis(self) -> Axis:
        """Return what is known of X, EVIOCGABS."""
        answer = bytearray(24)
        fcntl.ioctl(self.file, 0x80184540, answer)
        return Axis(*struct.unpack("<6i", answer))

    def upload(self, effect: Effect) -> int:
        """Make an effect, or change the one with its number. Returns the number."""
        return self.upload_packed(effect.packed)

    def upload_packed(self, data: bytearray) -> int:
        """Do the same with bytes that were made before, for haste."""
        fcntl.ioctl(self.file, _UPLOAD, data)
        return int(struct.unpack_from("<h", data, 2)[0])

    def erase(self, number: int) -> None:
        fcntl.ioctl(self.file, _ERASE, number)

    def play(self, *numbers: int, loops: int = 1) -> None:
        """Play, all at once; 0 loops stop them."""
        self._write(*((number, loops) for number in numbers))

    def set_gain(self, gain: int) -> None:
        """65535 is all."""
        self._write((GAIN, gain))

    def _write(self, *events: tuple[int, int]) -> None:
        data = (struct.pack("<qqHHi", 0, 0, _EV_FF, code, value) for code, value in events)
        os.write(self.file, b"".join(data))
