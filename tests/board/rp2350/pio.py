"""One state machine of a PIO unit, in step with the processor: as much as our program uses."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

FIFO_SIZE = 4
WORD = 0xFFFFFFFF
IDLE_LOOP = 7  # cycles of the encoder program from edge to edge: whole turns may be left out


class Pio:
    """A unit with machine 0. Time passes in ``catch_up``."""

    def __init__(self, pins: Callable[[], int], now: Callable[[], int]) -> None:
        self._pins = pins
        self._now = now
        self._done = 0
        self.memory = [0] * 32
        self.registers: dict[int, int] = {}
        self.fifo: deque[int] = deque()
        self.enabled = False
        self.pc = self.x = self.y = self.isr = self.osr = 0

    def read(self, offset: int) -> int:
        self.catch_up()
        if offset == 0x04:  # FSTAT: what is empty, from bit 8 on
            return 0x0F000E00 | (0 if self.fifo else 1 << 8) | (len(self.fifo) == FIFO_SIZE)
        if offset == 0x0C:
            return len(self.fifo) << 4
        if offset == 0x20:
            return self.fifo.popleft() if self.fifo else 0
        if offset == 0xD4:
            return self.pc
        return self.registers.get(offset, 0)

    def write(self, offset: int, value: int) -> None:
        self.catch_up()
        self.registers[offset] = value
        if offset == 0x00:
            self.enabled = bool(value & 1)
            if value >> 4 & 1:  # restart
                self.isr = 0
            self.registers[0] = value & 0xF
        elif 0x48 <= offset < 0xC8:
            self.memory[(offset - 0x48) // 4] = value & 0xFFFF
        elif offset == 0xD0 and value & WORD:
            self.fifo.clear()
        elif offset == 0xD8:
            self._step(value & 0xFFFF, self.pc)

    def catch_up(self) -> None:
        """Do what the machine has done since."""
        cycles = self._now() - self._done
        self._done += cycles
        if not self.enabled:
            return
        if cycles > 8 * IDLE_LOOP:
            cycles = 4 * IDLE_LOOP + cycles % IDLE_LOOP
        top = self.registers[0xCC] >> 12 & 31
        bottom = self.registers[0xCC] >> 7 & 31
        for _ in range(cycles):
            self._step(self.memory[self.pc], bottom if self.pc == top else (self.pc + 1) & 31)

    def _step(self, code: int, following: int) -> None:
        self.pc = following
        match code >> 13:
            case 0:
                if self._jumps(code >> 5 & 7):
                    self.pc = code & 31
            case 2:
                self.isr = (self.isr << (code & 31 or 32) | self._in(code)) & WORD
            case 3:
                bits = code & 31 or 32
                self._store(code >> 5 & 7, self.osr & ((1 << bits) - 1), {6: "isr", 1: "x", 2: "y"})
                self.osr >>= bits
            case 4 if not code & 0x80:
                if len(self.fifo) < FIFO_SIZE:
                    self.fifo.append(self.isr)
                self.isr = 0
            case 5:
                value = self._source(code & 7)
                if code >> 3 & 3 == 1:
                    value ^= WORD
                names = {1: "x", 2: "y", 5: "pc", 6: "isr", 7: "osr"}
                self._store(code >> 5 & 7, value, names)
                self.pc &= 31
            case 7:
                self._store(code >> 5 & 7, code & 31, {1: "x", 2: "y"})
            case _:
                raise NotImplementedError(f"PIO instruction {code:#06x}")

    def _jumps(self, condition: int) -> bool:
        if condition == 0:
            return True
        if condition == 4:  # y--
            self.y, was = (self.y - 1) & WORD, self.y
            return was != 0
        raise NotImplementedError(f"PIO condition {condition}")

    def _in(self, code: int) -> int:
        return self._source(code >> 5 & 7) & ((1 << (code & 31 or 32)) - 1)

    def _source(self, number: int) -> int:
        match number:
            case 0:
                base = self.registers.get(0xDC, 0) >> 15 & 31
                return self._pins() >> base
            case 1:
                return self.x
            case 2:
                return self.y
            case 3:
                return 0
            case 6:
                return self.isr
            case 7:
                return self.osr
        raise NotImplementedError(f"PIO source {number}")

    def _store(self, number: int, value: int, names: dict[int, str]) -> None:
        setattr(self, names[number], value)
