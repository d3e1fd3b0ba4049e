"""An RP2350 that runs a firmware file: Unicorn's Cortex-M33 and peripherals of our own.

It has what the firmware uses and no more. Where it is simpler than the chip:

- A boot ROM of a few functions, done here; the image starts at its vector table.
- Peripherals that are only set up (clocks, oscillators, voltage ...) keep what was written and say
  that they are ready.
- What the world puts on a pin is low or nothing, as a contact or an open collector does it: high
  is what the firmware's pull-up makes of it.
- PWM pins do not move: the share of time in which one is high comes from the unit's registers.
- A world that is coupled to it is asked once a PWM period, as the period begins.
- Memory takes no time, and one core runs.
"""

from __future__ import annotations

import ctypes
import math
import struct
from collections import deque
from collections.abc import Callable
from functools import partial
from itertools import islice
from pathlib import Path

from unicorn import UC_PROT_ALL, arm_const

from tests.board.rp2350.core import HARD_FAULT, Core
from tests.board.rp2350.pio import Pio
from tests.board.rp2350.rom import HZ, LOOP, Rom
from tests.board.rp2350.usb import Usb

ADC_CYCLES = HZ // 500_000  # a conversion takes two microseconds
SUPPLY_CHANNEL = 1  # GP27
SUPPLY = {"supply": 12, "divider": 11}
PWM_LINE, USB_LINE = 8, 14

CLOCKS, RESETS, IO_BANK, PADS = 0x10, 0x20, 0x28, 0x38
XOSC, PLL_SYS, PLL_USB, ADC, PWM = 0x48, 0x50, 0x58, 0xA0, 0xA8
TIMER, WATCHDOG, BOOT_RAM, POWMAN = 0xB0, 0xD8, 0xE0, 0x100
SCRATCH = range(0x0C, 0x2C, 4)

PWM_PERIOD = HZ // 40_000
PHASES = (0b00, 0b01, 0b11, 0b10)  # A (bit 0) and B, in the order of a turning knob
World = Callable[[float, float, bool], tuple[float, list[float]]]

FUNCTION_PWM, FUNCTION_SIO = 4, 5
PULL_UP, ISOLATED = 1 << 3, 1 << 8


class Chip:
    """The chip, its flash, and what is wired to it."""

    def __init__(self, library: Path, image: dict[int, bytes], serial: bytes) -> None:
        self.registers: dict[int, dict[int, int]] = {}
        self.watchdog_resets = 0
        # Time left to the watchdog when it was fed, since somebody asked to watch it.
        self.watchdog_least_left_ns = math.inf
        self.low = {11}  # pins that the world connects to ground: the emergency stop runs
        self.zero = 2048  # steps of the current sensor without a current
        self.sensor_amperes: float | None = None  # what the sensor shows; None: the truth
        self.motor = {"ohm": 2.5, "henry": 1.5e-3, "voltsPerAmpere": 0.2, **SUPPLY}
        self.cut: set[int] = set()  # pins whose wire is cut
        self.world: World | None = None
        self._world_at = 0  # the next PWM period
        self._edges: deque[tuple[int, int]] = deque()  # when, and which way
        self._phase = 2
        self._library = ctypes.CDLL(str(library))
        self.core = Core(self._library)
        self.rom = Rom(self.core, image, serial)
        self._map_memory()
        self.core.coprocessor = self._move_pins
        self.core.entered = self._tick_begins
        self.core.left = self._tick_ends
        self.power_up()

    def power_up(
        self, *, bitten: bool = False, copied: bool = False, brown_out: bool = False
    ) -> None:
        """Start from reset, by the watchdog or not; the flash, the world and its time stay.

        With ``copied`` the boot ROM has used the watchdog, to start a file that it was given. With
        ``brown_out`` the power was not away, but too low for a moment.
        """
        bitten |= copied
        kept = self._file(WATCHDOG) if bitten else {}
        self.registers = {}
        self.pwm_starts: list[int] = []
        self.tick_ns = {"last": 0.0, "most": 0.0}
        self.interrupt_ns = 0.0  # in all control interrupts
        self.tick_instructions = 0  # the most, once they are counted
        self._tick_began = self._tick_instruction = 0
        self.out = self.driven = 0
        self._settle()
        self.sleepless = False
        self.amperes = 0.0
        self._next_share = 0.0
        self._amperes_at = self.now
        self._adc_ready = 0
        self._adc_result = 0
        self._powered = self.now
        self._watchdog_at: int | None = None
        self._pwm_intr = 0
        self._pwm_wraps: dict[int, tuple[int, int]] = {}  # unit: next wrap, period
        self.rom.power_up()
        self.pio = Pio(self._library, lambda: self._levels, lambda: self.core.counter.cycles)
        self.usb = Usb(self._dpram, lambda high: self.core.raise_line(USB_LINE, high))
        self._file(RESETS)[0] = 0x1FFFFFFF
        self._file(WATCHDOG).update({at: kept[at] for at in SCRATCH if at in kept})
        if copied:
            self._file(WATCHDOG)[SCRATCH[4]] = 0
        self._file(WATCHDOG)[8] = int(bitten)
        power_on, too_low = 1 << 16, 1 << 17
        self._file(POWMAN)[0x2C] = 0 if bitten else too_low if brown_out else power_on
        stack, entry = struct.unpack("<II", self.rom.flash[0:8])
        self.core.reset(stack, entry & ~1)

    # Time ---------------------------------------------------------------------------------------

    @property
    def now(self) -> int:
        """Cycles since the first power-up."""
        return self.core.counter.cycles

    @property
    def ns(self) -> float:
        return self.now * 1e9 / HZ

    def run_for(self, ns: float, done: Callable[[], bool] = lambda: False) -> bool:
        """Run so long, or until ``done`` says so; return what it said."""
        end = self.now + math.ceil(ns * HZ / 1e9)
        while self.now < end:
            self._step(end)
            if done():
                return True
        return done()

    def _step(self, end: int) -> None:
        until = end
        for wrap, _ in self._pwm_wraps.values():
            until = min(until, wrap)
        if self._watchdog_at is not None:
            until = min(until, self._watchdog_at)
        if self.world:
            until = min(until, self._world_at, *(at for at, _ in islice(self._edges, 1)))
        if self.rom.waits:
            until = min(until, self.rom.busy_until)
            self.rom.wait()
        if self.sleepless:
            self.core.sleeping = False
        if until > self.now:
            self.core.run(until)
        self._pass_events()
        self.rom.serve()
        if self.rom.bootloader:
            self._watchdog_at = None

    def _pass_events(self) -> None:
        if self.world:
            self._move_world(self.world)
        for unit, (wrap, period) in self._pwm_wraps.items():
            if self.now >= wrap:
                self._pwm_intr |= 1 << unit
                self._pwm_wraps[unit] = (wrap + period, period)
                self._tell_pwm()
        if self._watchdog_at is not None and self.now >= self._watchdog_at:
            self.watchdog_resets += 1
            self.power_up(bitten=True)

    def count_instructions(self) -> None:
        """Count the control interrupt's instructions from now on."""
        self.core.count_instructions(self._library)

    # The world ----------------------------------------------------------------------------------

    def couple(self, world: World) -> None:
        """Have motor and encoder moved by a world from the next PWM period on."""
        self.world = world
        self._world_at = min(wrap for wrap, _ in self._pwm_wraps.values())

    def _move_world(self, world: World) -> None:
        while self._edges and self._edges[0][0] <= self.now:
            self.turn(self._edges.popleft()[1])
        if self.now < self._world_at:
            return
        high = [self.high_share(pin) or 0.0 for pin in range(6, 11)]
        self.amperes, edges = world(high[0] - high[1], high[2] - high[3], bool(high[4]))
        for time in edges:
            self._edges.append((self._world_at + int(abs(time) * HZ / 1e9), 1 if time > 0 else -1))
        self._world_at += PWM_PERIOD

    def turn(self, step: int, pin_a: int = 2) -> None:
        """Turn the encoder by one edge."""
        self._phase = (self._phase + step) % 4
        for pin in (pin_a, pin_a + 1):
            self.set_pin(pin, high=bool(PHASES[self._phase] >> (pin - pin_a) & 1))

    # Ways to go wrong ---------------------------------------------------------------------------

    def hang(self, *, masked: bool = False, inside_us: float | None = None) -> None:
        """Let the main loop get on no more; interrupts do, unless they are masked as well.

        Or a control interrupt, so long after it has begun.
        """
        self.run_for(1e6, lambda: not self.core.active)
        if inside_us is not None:
            self._run_into_tick(1e3 * inside_us)
        uc = self.core.uc
        uc.mem_write(LOOP, struct.pack("<H", 0xE7FE))
        uc.reg_write(arm_const.UC_ARM_REG_PC, LOOP | 1)
        uc.reg_write(arm_const.UC_ARM_REG_PRIMASK, int(masked))
        self.core.sleeping = False

    def _run_into_tick(self, ns: float) -> None:
        since = self.now
        for _ in range(100_000):
            self.run_for(100)
            if self.core.ipsr != 16 + PWM_LINE:
                since = self.now
            elif self.now - since >= ns * HZ / 1e9:
                return
        raise AssertionError("no control interrupt takes so long")

    def stop_ticks(self) -> None:
        """No tick comes any more; the main loop is woken by other things, and often."""
        self.core.enabled &= ~(1 << PWM_LINE)
        self.sleepless = True

    def hard_fault(self) -> None:
        self.core.enter(HARD_FAULT)
        self.core.sleeping = False

    # Memory and registers -----------------------------------------------------------------------

    def _map_memory(self) -> None:
        uc = self.core.uc
        uc.mem_map(0x18000000, 0x4000000)  # cache maintenance by writing
        uc.mem_map(0x20000000, 0x82000)
        dpram = ctypes.create_string_buffer(0x1000)
        self._dpram = memoryview(dpram).cast("B")
        uc.mem_map_ptr(0x50100000, 0x1000, UC_PROT_ALL, ctypes.addressof(dpram))
        self._dpram_memory = dpram
        for base, size in (
            *((0x40000000, 0x170000), (0x50110000, 0x10000), (0x50200000, 0x10000)),
            *((0xD0000000, 0x20000), (0xE0000000, 0x100000)),
        ):
            self.core.map_registers(
                base, size, partial(self._read_at, base), partial(self._write_at, base)
            )

    def _file(self, block: int) -> dict[int, int]:
        return self.registers.setdefault(block, {})

    def _read_at(self, base: int, offset: int, size: int) -> int:
        word = self._read(base, offset & ~3)
        return word >> 8 * (offset & 3) & ((1 << 8 * size) - 1)

    def _read(self, base: int, offset: int) -> int:
        if base == 0x40000000:
            return self._read_block(offset >> 12 & ~7, offset & 0xFFF)
        if base == 0x50110000:
            return self.usb.read(offset & 0xFFF)
        if base == 0x50200000:
            return self.pio.read(offset & 0xFFF)
        if base == 0xD0000000:
            return self._read_sio(offset)
        return self.core.read_private(offset)

    def _write_at(self, base: int, offset: int, size: int, value: int) -> None:
        if base == 0xD0000000:
            self._write_sio(offset, value)
        elif base == 0xE0000000:
            self.core.write_private(offset, value, size)
        else:
            way = offset >> 12 & 3
            block, place = offset >> 12 & ~7, offset & 0xFFF
            # A narrow write puts the same bytes on all lanes.
            raw = value * {1: 0x01010101, 2: 0x00010001, 4: 1}[size] if size < 4 else value
            if way:
                old = self._read(base, offset & ~0x3000)
                value = (raw, old ^ raw, old | raw, old & ~raw)[way]
            else:
                value = raw
            if base == 0x40000000:
                self._write_block(block, place & ~3, value, raw)
            elif base == 0x50110000:
                self.usb.write(place, value, raw)
            else:
                self.pio.write(place, value)

    def _read_block(self, block: int, offset: int) -> int:  # noqa: C901 - a table
        file = self._file(block)
        if block == TIMER and offset in (0x08, 0x0C, 0x24, 0x28):
            us = (self.now - self._powered) // (HZ // 1_000_000)
            return us >> 32 if offset in (0x08, 0x24) else us & 0xFFFFFFFF
        if block == ADC and offset == 0:
            # The firmware asks until it is ready: let that time pass at once, up to an interrupt.
            counter = self.core.counter
            counter.cycles = max(counter.cycles, min(self._adc_ready, counter.deadline))
            return file.get(0, 0) | (1 << 8 if self.now >= self._adc_ready else 0)
        if block == ADC and offset == 4:
            return self._adc_result
        if block == PWM:
            return self._read_pwm(offset)
        if block == CLOCKS and offset in (0x38, 0x44):
            return 1 << (file.get(offset - 8, 0) & (3 if offset == 0x38 else 1))
        if block == CLOCKS and offset % 12 == 8 and offset < 0x78:
            return 1
        if block == RESETS and offset == 8:
            return ~file.get(0, 0) & 0x1FFFFFFF
        if block == XOSC and offset == 4:
            return 1 << 31
        if block in (PLL_SYS, PLL_USB) and offset == 0:
            return file.get(0, 0) | 1 << 31
        if block == BOOT_RAM and offset < 0x100:
            return 0x47704770  # two times bx lr: the ROM's code that makes the flash fast again
        if block == BOOT_RAM and 0x80C <= offset < 0x82C:
            return 1  # a lock, free for the asking
        if block == PADS and 4 <= offset < 0xC4:
            return file.get(offset, 0x116)
        return file.get(offset, 0x1F if block == IO_BANK and offset % 8 == 4 else 0)

    def _write_block(self, block: int, offset: int, value: int, raw: int) -> None:
        file = self._file(block)
        if block == ADC and offset == 0 and value & 4:
            value &= ~(4 | 1 << 8)  # the write acknowledges these bits, which do not stay
            self._convert(value >> 12 & 7)
        elif block == PWM:
            self._write_pwm(offset, value, raw)
            return
        elif block == WATCHDOG:
            self._write_watchdog(offset, value)
            return
        elif block in (PADS, IO_BANK):
            self.pio.catch_up()
            file[offset] = value
            self._settle()
        file[offset] = value

    def _write_watchdog(self, offset: int, value: int) -> None:
        file = self._file(WATCHDOG)
        if offset == 4:
            self._watchdog_left = value & 0xFFFFFF
        elif offset == 8:
            return
        file[offset] = value
        before = self._watchdog_at
        if offset == 4 and before is not None:
            left_ns = (before - self.now) * 1e9 / HZ
            self.watchdog_least_left_ns = min(self.watchdog_least_left_ns, left_ns)
        if value >> 31 and offset == 0:
            self._watchdog_at = self.now
        elif file.get(0, 0) >> 30 & 1:
            self._watchdog_at = self.now + self._watchdog_left * (HZ // 1_000_000)
        else:
            self._watchdog_at = None
        # Feeding it is no reason to stop: the emulator would have stopped earlier anyway.
        if before is None or self._watchdog_at is None or self._watchdog_at < before:
            self.core.attend()

    # Pins ---------------------------------------------------------------------------------------

    def set_pin(self, pin: int, *, high: bool) -> None:
        """Let go of a pin (high) or connect it to ground."""
        if pin in self.cut:
            return
        self.pio.catch_up()
        if high:
            self.low.discard(pin)
        else:
            self.low.add(pin)
        self._settle()

    def _settle(self) -> None:
        pads = self._file(PADS)
        levels = 0
        for pin in range(30):
            pad = pads.get(4 + 4 * pin, 0x116)
            if pin not in self.low and pad & PULL_UP and not pad & ISOLATED:
                levels |= 1 << pin
        self._levels = levels

    def function(self, pin: int) -> int:
        return self._read_block(IO_BANK, 8 * pin + 4) & 31

    def high_share(self, pin: int) -> float | None:
        """Return the share of the time in which a pin is driven high; None if it is not driven."""
        if self._read_block(PADS, 4 + 4 * pin) & ISOLATED:
            return None
        if self.function(pin) == FUNCTION_PWM:
            unit = pin // 2 % 8
            control, level, top = (
                self._file(PWM).get(0x14 * unit + at, 0) for at in (0x00, 0x0C, 0x10)
            )
            share = min((level >> 16 * (pin & 1) & 0xFFFF) / (top + 1), 1)
            inverted = control & (8 if pin & 1 else 4)
            if not control & 1:
                return 1 if inverted else 0
            return 1 - share if inverted else share
        if self.function(pin) == FUNCTION_SIO and self.driven >> pin & 1:
            return self.out >> pin & 1
        return None

    def _read_sio(self, offset: int) -> int:
        if offset == 0x04:
            return self._levels & ~self.driven | self.out & self.driven
        return {0x10: self.out, 0x30: self.driven}.get(offset, 0)

    def _write_sio(self, offset: int, value: int) -> None:
        match offset:
            case 0x10:
                self.out = value
            case 0x18:
                self.out |= value
            case 0x20:
                self.out &= ~value
            case 0x28:
                self.out ^= value
            case 0x30:
                self.driven = value
            case 0x38:
                self.driven |= value
            case 0x40:
                self.driven &= ~value
            case 0x48:
                self.driven ^= value

    def _move_pins(self, first: int, second: int) -> None:
        """Do an MCR or MCRR of coprocessor 0, which is the pins'."""
        uc = self.core.uc
        register = [arm_const.UC_ARM_REG_R0 + n for n in range(13)]
        if second >> 8 & 0xF == 4:  # doubles, which are only set up
            if first & 0xFF10 == 0xEE10 and second >> 12 < 13:
                uc.reg_write(register[second >> 12], 0)
            return
        if second >> 8 & 0xF != 0:
            raise RuntimeError(f"coprocessor instruction {first:04x} {second:04x}")
        value = uc.reg_read(register[second >> 12])
        if first & 0xFFF0 == 0xEC40:  # two registers: which pin, and its level
            way, name = second >> 4 & 0xF, second & 0xF
            level = uc.reg_read(register[first & 0xF]) & 1
            if way != 4:
                raise RuntimeError(f"coprocessor instruction {first:04x} {second:04x}")
            mask = 1 << value
            way = 2 if level else 3
        elif first & 0xFF10 == 0xEE00:
            way, name, mask = first >> 5 & 7, second & 0xF, value
        else:
            raise RuntimeError(f"coprocessor instruction {first:04x} {second:04x}")
        base = {0: 0x10, 4: 0x30}[name]
        self._write_sio(base + {0: 0, 1: 0x18, 2: 0x08, 3: 0x10}[way], mask)

    # PWM ----------------------------------------------------------------------------------------

    def _read_pwm(self, offset: int) -> int:
        file = self._file(PWM)
        if offset == 0xF0:
            return sum((file.get(0x14 * unit, 0) & 1) << unit for unit in range(12))
        if offset == 0xF4:
            return self._pwm_intr
        if offset == 0x100:
            return self._pwm_intr & file.get(0xF8, 0)
        return file.get(offset, 0xFFFF if offset % 0x14 == 0x10 and offset < 0xF0 else 0)

    def _write_pwm(self, offset: int, value: int, raw: int) -> None:
        file = self._file(PWM)
        if offset < 0xF0 and offset % 0x14:  # a level, a top: no unit starts or stops
            file[offset] = value
            return
        before = self._read_pwm(0xF0)
        if offset == 0xF4:
            self._pwm_intr &= ~raw
            self._tell_pwm()
            return
        if offset == 0xF0:
            for unit in range(12):
                control = file.get(0x14 * unit, 0)
                file[0x14 * unit] = control & ~1 | (value >> unit & 1)
        else:
            file[offset] = value
        after = self._read_pwm(0xF0)
        if after != before:
            self.pwm_starts.append(after)
            for unit in range(12):
                if not after >> unit & 1:
                    self._pwm_wraps.pop(unit, None)
                elif not before >> unit & 1 and file.get(0xF8, 0) >> unit & 1:
                    period = file.get(0x14 * unit + 0x10, 0xFFFF) + 1
                    self._world_at = self.now + period
                    self._pwm_wraps[unit] = (self.now + period, period)
            self.core.attend()
        self._tell_pwm()

    def _tell_pwm(self) -> None:
        self.core.raise_line(PWM_LINE, bool(self._pwm_intr & self._file(PWM).get(0xF8, 0)))

    def _tick_begins(self, number: int) -> None:
        if number == 16 + PWM_LINE:
            self._tick_began = self.now
            self._tick_instruction = self.core.instructions.value

    def _tick_ends(self, number: int) -> None:
        if number == 16 + PWM_LINE:
            last = (self.now - self._tick_began) * 1e9 / HZ
            self.tick_ns = {"last": last, "most": max(last, self.tick_ns["most"])}
            self.interrupt_ns += last
            counted = self.core.instructions.value - self._tick_instruction
            self.tick_instructions = max(self.tick_instructions, counted)

    # The motor's winding between its PWM pins (6 and 7) and its current sensor --------------------

    def _convert(self, channel: int) -> None:
        self._adc_ready = self.now + ADC_CYCLES
        if channel == SUPPLY_CHANNEL:
            steps = round(self.motor["supply"] / self.motor["divider"] / 3.3 * 4096)
            self._adc_result = min(4095, steps)
            return
        if not self.world:
            self._follow_pins()
        seen = self.amperes if self.sensor_amperes is None else self.sensor_amperes
        steps = round(self.zero + seen * self.motor["voltsPerAmpere"] / 3.3 * 4096)
        self._adc_result = max(0, min(4095, steps))

    def _follow_pins(self) -> None:
        """Without a world: a winding of a motor that stands still."""
        motor = self.motor
        seconds = (self.now - self._amperes_at) / HZ
        self._amperes_at = self.now
        # A level that was written in the last period counts from this one on: the chip takes it
        # over when its counter wraps, which is when the current is measured.
        share, self._next_share = self._next_share, 0.0
        if self.high_share(10):
            self._next_share = (self.high_share(6) or 0) - (self.high_share(7) or 0)
        else:
            share = 0.0
        end = motor["supply"] * share / motor["ohm"]
        decay = math.exp(-seconds * motor["ohm"] / motor["henry"])
        self.amperes = end + (self.amperes - end) * decay
