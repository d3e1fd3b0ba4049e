"""One state machine of a PIO unit, in step with the processor: as much as our program uses."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

QUEUE_SIZE = 4
FLAGS = 0x30
IDLE_LOOP = 7  # cycles of the encoder program from edge to edge: whole turns may be left out


class Machine(ctypes.Structure):
    """As in fast.c."""

    _fields_ = (
        *((name, ctypes.c_uint32) for name in ("pc", "x", "y", "isr", "osr", "pins")),
        *((name, ctypes.c_uint32) for name in ("top", "bottom", "level")),
        ("queue", ctypes.c_uint32 * QUEUE_SIZE),
        ("flags", ctypes.c_uint32),
        ("unknown", ctypes.c_uint32),
        ("memory", ctypes.c_uint16 * 32),
    )
    y: int
    pins: int
    level: int
    flags: int


class Pio:
    """A unit with machine 0. Time passes in ``catch_up``."""

    def __init__(
        self, library: ctypes.CDLL, pins: Callable[[], int], now: Callable[[], int]
    ) -> None:
        self._library = library
        self._pins = pins
        self._now = now
        self._done = now()
        self._registers: dict[int, int] = {}
        self._enabled = False
        self._machine = Machine()
        self._pointer = ctypes.byref(self._machine)

    @property
    def count(self) -> int:
        """The encoder program's count."""
        self.catch_up()
        return self._machine.y

    def read(self, offset: int) -> int:
        self.catch_up()
        level = self._machine.level
        if offset == 0x04:  # FSTAT: which are empty, from bit 8 on, and full
            return 0x0F000E00 | (0 if level else 1 << 8) | (level == QUEUE_SIZE)
        if offset == 0x0C:
            return level << 4
        if offset == 0x20:
            return int(self._library.pop(self._pointer))
        if offset == FLAGS:
            return self._machine.flags
        return self._registers.get(offset, 0)

    def write(self, offset: int, value: int) -> None:
        self.catch_up()
        self._registers[offset] = value
        machine = self._machine
        if offset == 0x00:
            self._enabled = bool(value & 1)
            if value >> 4 & 1:  # restart
                machine.isr = 0
            self._registers[0] = value & 0xF
        elif offset == FLAGS:
            machine.flags &= ~value
        elif 0x48 <= offset < 0xC8:
            machine.memory[(offset - 0x48) // 4] = value & 0xFFFF
        elif offset == 0xCC:
            machine.top, machine.bottom = value >> 12 & 31, value >> 7 & 31
        elif offset == 0xD0:
            machine.level = 0
        elif offset == 0xD8:
            machine.pins = self._levels()
            self._library.execute(self._pointer, ctypes.c_uint32(value & 0xFFFF))

    def catch_up(self) -> None:
        """Do what the machine has done since."""
        now = self._now()
        cycles = now - self._done
        self._done = now
        if not self._enabled:
            return
        if cycles > 1000 * IDLE_LOOP:
            cycles = 4 * IDLE_LOOP + cycles % IDLE_LOOP
        self._machine.pins = self._levels()
        self._library.run(self._pointer, ctypes.c_uint64(cycles))
        if self._machine.unknown:
            raise NotImplementedError(f"PIO instruction {self._machine.unknown:#x}")

    def _levels(self) -> int:
        return self._pins() >> (self._registers.get(0xDC, 0) >> 15 & 31)
