"""A Cortex-M33 in time: Unicorn computes, and what it leaves out is here.

That is exceptions with their priorities and their frames, among them those with floating-point
registers, the interrupt controller and SysTick, sleep, and the passage of time.
"""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable
from typing import Any

import unicorn
from unicorn import arm_const as arm

HARD_FAULT = 3
NO_COPROCESSOR = 17  # Unicorn's numbers for what it cannot do itself
EXCEPTION_RETURN = 8
SLEEPS = (0xBF30, 0xBF20)  # WFI, WFE

FPCA = 1 << 2  # floating point was used since the exception
BASIC_FRAME = 1 << 4
THUMB = 1 << 24
ALIGNED = 1 << 9

STACKED = (
    *(arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R1, arm.UC_ARM_REG_R2, arm.UC_ARM_REG_R3),
    *(arm.UC_ARM_REG_R12, arm.UC_ARM_REG_LR, arm.UC_ARM_REG_PC, arm.UC_ARM_REG_XPSR),
)
FLOATS = (*(arm.UC_ARM_REG_S0 + n for n in range(16)), arm.UC_ARM_REG_FPSCR)
LIBRARY = unicorn.unicorn_py3.unicorn.uclib


READER = ctypes.CFUNCTYPE(
    ctypes.c_uint64, ctypes.c_void_p, ctypes.c_uint64, ctypes.c_uint, ctypes.c_void_p
)
WRITER = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_uint64, ctypes.c_uint, ctypes.c_uint64, ctypes.c_void_p
)


class Registers:
    """Some registers of the processor, at once: Unicorn's own way takes a while for each."""

    def __init__(self, uc: unicorn.Uc, *names: int) -> None:
        size = len(names)
        self._values = (ctypes.c_uint64 * size)()
        each = ctypes.sizeof(ctypes.c_uint64)
        first = ctypes.addressof(self._values)
        pointers = (ctypes.c_void_p * size)(*(first + each * n for n in range(size)))
        self._arguments = (uc._uch, (ctypes.c_int * size)(*names), pointers, size)

    def read(self) -> list[int]:
        LIBRARY.uc_reg_read_batch(*self._arguments)
        return [value & 0xFFFFFFFF for value in self._values]

    def write(self, *values: int) -> None:
        self._values[:] = list(values)
        LIBRARY.uc_reg_write_batch(*self._arguments)


class Counter(ctypes.Structure):
    """As in fast.c."""

    _fields_ = (
        ("cycles", ctypes.c_uint64),
        ("deadline", ctypes.c_uint64),
        ("stop", ctypes.c_void_p),
    )
    cycles: int
    deadline: int


class Core:
    """One processor, its interrupt controller and its clock."""

    def __init__(self, library: ctypes.CDLL) -> None:
        self.uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        self.uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M33)
        self.counter = Counter()
        self.instructions = ctypes.c_uint64(0)  # since count_instructions()
        self._callbacks: list[object] = []
        self.passed: list[tuple[Any, ...]] = []  # places that are traced
        self._seen: dict[str, list[int]] = {}
        self._at_entry = Registers(self.uc, *STACKED, arm.UC_ARM_REG_SP, arm.UC_ARM_REG_CONTROL)
        self._handler = Registers(
            self.uc,
            *(arm.UC_ARM_REG_SP, arm.UC_ARM_REG_CONTROL, arm.UC_ARM_REG_LR),
            *(arm.UC_ARM_REG_XPSR, arm.UC_ARM_REG_PC),
        )
        self._floats = Registers(self.uc, *FLOATS)
        self._pc = Registers(self.uc, arm.UC_ARM_REG_PC)
        self._masked = Registers(self.uc, arm.UC_ARM_REG_PRIMASK)
        self._count_blocks(library)
        self.uc.hook_add(unicorn.UC_HOOK_INTR, self._trapped)
        self.coprocessor: Callable[[int, int], None] = lambda first, second: None
        self.entered: Callable[[int], None] = lambda number: None
        self.left: Callable[[int], None] = lambda number: None
        self.reset(0, 0)

    def reset(self, stack: int, entry: int) -> None:
        """Begin anew, without interrupts."""
        self.active: list[int] = []
        self.enabled = 0  # interrupts, a bit each
        self.pending = 0
        self.level = 0  # interrupt lines of peripherals: pending while high
        self.priorities = bytearray(64)
        self.vectors = 0x10000000
        self.sleeping = False
        self._returning = False
        self._systick_since = 0
        self.failure: BaseException | None = None  # raised by a callback
        self._registers: dict[int, int] = {}
        for register in (arm.UC_ARM_REG_CONTROL, arm.UC_ARM_REG_PRIMASK):
            self.uc.reg_write(register, 0)
        self.uc.reg_write(arm.UC_ARM_REG_XPSR, THUMB)
        self.uc.reg_write(arm.UC_ARM_REG_MSP, stack)
        self.uc.reg_write(arm.UC_ARM_REG_SP, stack)
        self.uc.reg_write(arm.UC_ARM_REG_LR, 0xFFFFFFFF)
        self.uc.reg_write(arm.UC_ARM_REG_PC, entry | 1)

    @property
    def ipsr(self) -> int:
        return self.active[-1] if self.active else 0

    def run(self, until: int) -> None:
        """Run to that cycle, or to what needs attention: an exception, sleep, a peripheral."""
        number = self._due()
        if number is not None:
            self.sleeping = False
            self.enter(number)
        if self.sleeping:
            if self.wakes():
                self.sleeping = False
            else:
                self.counter.cycles = until
                return
        # While an interrupt is masked it must not come late.
        waiting = (self.pending | self.level) & self.enabled
        now = self.counter.cycles
        self.counter.deadline = min(until, now + 64) if waiting else until
        LIBRARY.uc_emu_start(self.uc._uch, self._pc.read()[0] | 1, 0xFFFFFFFF, 0, 0)
        if self.failure is not None:
            raise self.failure
        if self._returning:
            self._returning = False
            self._leave()
            return
        if self.counter.cycles < self.counter.deadline:
            pc = self._pc.read()[0]
            (code,) = struct.unpack("<H", self.uc.mem_read(pc - 2, 2))
            self.sleeping = code in SLEEPS

    def attend(self) -> None:
        """Stop before the next block, for something has changed."""
        self.counter.deadline = 0

    def wakes(self) -> bool:
        """Tell whether an interrupt waits that ends sleep."""
        return bool((self.pending | self.level) & self.enabled)

    # Exceptions -------------------------------------------------------------------------------

    def raise_line(self, line: int, high: bool) -> None:
        """Set a peripheral's interrupt line."""
        if high:
            self.level |= 1 << line
            self.attend()
        else:
            self.level &= ~(1 << line)

    def _priority(self, number: int) -> int:
        return -1 if number == HARD_FAULT else self.priorities[number - 16]

    def _due(self) -> int | None:
        ready = (self.pending | self.level) & self.enabled
        if not ready or self._masked.read()[0] & 1:
            return None
        lines = [line for line in range(52) if ready >> line & 1]
        best = min(lines, key=lambda line: (self.priorities[line], line))
        now = min((self._priority(number) for number in self.active), default=256)
        return 16 + best if self.priorities[best] < now else None

    def enter(self, number: int) -> None:
        """Stack a frame and go to the handler."""
        self.entered(number)
        *frame, stack, control = self._at_entry.read()
        words = struct.pack("<8I", *frame)
        code = 0xFFFFFFF9 if not self.active else 0xFFFFFFF1
        if control & FPCA:
            words += struct.pack("<18I", *self._floats.read(), 0)
            code &= ~BASIC_FRAME
        top = stack - len(words)
        if top & 4:
            top -= 4
            words = words[:28] + struct.pack("<I", frame[7] | ALIGNED) + words[32:]
        self.uc.mem_write(top, words)
        (handler,) = struct.unpack("<I", self.uc.mem_read(self.vectors + 4 * number, 4))
        self.active.append(number)
        self.pending &= ~(1 << (number - 16)) if number >= 16 else -1
        self._handler.write(top, control & ~FPCA, code, THUMB | number, handler | 1)
        self.counter.cycles += 12

    def _leave(self) -> None:
        number = self.active.pop()
        *_, stack, control = self._at_entry.read()
        control &= ~FPCA
        frame = list(struct.unpack("<8I", self.uc.mem_read(stack, 32)))
        size = 32
        if not self._code & BASIC_FRAME:
            floats = struct.unpack("<17I", self.uc.mem_read(stack + 32, 68))
            self._floats.write(*floats)
            control |= FPCA
            size = 104
        if frame[7] & ALIGNED:
            size += 4
        frame[7] &= ~ALIGNED
        frame[6] |= 1
        self._at_entry.write(*frame, stack + size, control)
        self.counter.cycles += 12
        self.left(number)

    def _trapped(self, uc: unicorn.Uc, number: int, _: object) -> None:
        pc = self._pc.read()[0]
        if number == EXCEPTION_RETURN:
            self._code = pc | 1
            self._returning = True
            uc.emu_stop()
        elif number == NO_COPROCESSOR:
            first, second = struct.unpack("<HH", uc.mem_read(pc, 4))
            self.coprocessor(first, second)
            self._pc.write((pc + 4) | 1)
        else:
            self.fail(RuntimeError(f"exception {number} at {pc:#x}"))

    def fail(self, why: BaseException) -> None:
        """Keep what went wrong in a callback, and stop: Unicorn cannot pass it on."""
        self.failure = self.failure or why
        self.uc.emu_stop()

    def _count_blocks(self, library: ctypes.CDLL) -> None:
        stop = ctypes.cast(LIBRARY.uc_emu_stop, ctypes.c_void_p).value
        self.counter.stop = stop
        self._call_before(unicorn.UC_HOOK_BLOCK, library.count_block, self.counter)

    def count_instructions(self, library: ctypes.CDLL) -> None:
        """From now on, which takes time."""
        self._call_before(unicorn.UC_HOOK_CODE, library.count_instruction, self.instructions)
        self.uc.ctl_flush_tb()  # translated code does not call the new hook

    def trace(
        self, name: str, at: int, pointer: tuple[str, int] | None = None, size: int = 0
    ) -> None:
        """Note registers, and memory that one pointed to, whenever the program is at a place."""
        arguments = Registers(self.uc, *STACKED[:3])

        def note(uc: unicorn.Uc, _address: int, _size: int, _data: object) -> None:
            self._seen[name] = arguments.read()
            memory = uc.mem_read(self._seen[pointer[0]][pointer[1]], size) if pointer else b""
            self.passed.append((name, *self._seen[name], memory.hex()))

        self.uc.hook_add(unicorn.UC_HOOK_CODE, note, begin=at, end=at)

    def _call_before(self, what: int, function: Any, counter: Any) -> None:
        handle = ctypes.c_size_t()
        first, last = ctypes.c_uint64(1), ctypes.c_uint64(0)
        failed = LIBRARY.uc_hook_add(
            self.uc._uch,
            ctypes.byref(handle),
            what,
            ctypes.cast(function, ctypes.c_void_p),
            ctypes.cast(ctypes.pointer(counter), ctypes.c_void_p),
            first,
            last,
        )
        assert not failed

    def map_registers(
        self,
        base: int,
        size: int,
        read: Callable[[int, int], int],
        write: Callable[[int, int, int], None],
    ) -> None:
        """Have addresses done by functions, past Unicorn's own way, which takes twice the time."""

        def do_read(_uc: int, offset: int, width: int, _: int) -> int:
            try:
                return read(offset, width)
            except BaseException as why:
                self.fail(why)
                return 0

        def do_write(_uc: int, offset: int, width: int, value: int, _: int) -> None:
            try:
                write(offset, width, value)
            except BaseException as why:
                self.fail(why)

        callbacks = (READER(do_read), WRITER(do_write))
        self._callbacks.append(callbacks)  # or they would be collected
        failed = LIBRARY.uc_mmio_map(
            self.uc._uch, ctypes.c_uint64(base), ctypes.c_size_t(size),
            ctypes.cast(callbacks[0], ctypes.c_void_p), None,
            ctypes.cast(callbacks[1], ctypes.c_void_p), None,
        )  # fmt: skip
        assert not failed

    # The private peripherals ---------------------------------------------------------------------

    def read_private(self, offset: int) -> int:
        """Read at 0xE0000000 + offset."""
        if offset == 0xE018:  # SysTick counts down in 24 bits
            return (self._systick_since - self.counter.cycles) & 0xFFFFFF
        if 0xE100 <= offset < 0xE140:
            return self.enabled >> 8 * (offset & 0x3C) & 0xFFFFFFFF
        if 0xE400 <= offset < 0xE440:
            return int.from_bytes(self.priorities[offset - 0xE400 :][:4], "little")
        if offset == 0xED00:
            return 0x411FD210
        if offset == 0xED04:
            return self.ipsr
        if offset == 0xED08:
            return self.vectors
        return self._registers.get(offset, 0)

    def write_private(self, offset: int, value: int, size: int) -> None:
        """Write at 0xE0000000 + offset."""
        if 0xE100 <= offset < 0xE300:
            bits = value << 8 * (offset & 0x3C)
            match offset >> 7 & 3:
                case 2:
                    self.enabled |= bits
                case 3:
                    self.enabled &= ~bits
                case 0:
                    self.pending |= bits
                case 1:
                    self.pending &= ~bits
            if self.wakes():
                self.attend()
        elif 0xE400 <= offset < 0xE440:
            at = offset - 0xE400
            self.priorities[at : at + size] = value.to_bytes(size, "little")
        elif offset == 0xE018:
            self._systick_since = self.counter.cycles
        elif offset == 0xED08:
            self.vectors = value
        else:
            self._registers[offset] = value
