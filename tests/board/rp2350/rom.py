"""The boot ROM, as much of it as the firmware asks for, and the flash that it writes.

A function is one halfword of memory; when the processor comes there, it is done here.
"""

from __future__ import annotations

import ctypes
import struct

from unicorn import UC_HOOK_CODE, UC_PROT_ALL, arm_const

from tests.board.rp2350.core import Core

HZ = 150_000_000
FLASH_SIZE = 4 * 1024 * 1024
FLASH_BASES = (0x10000000, 0x14000000)  # cached and not
SECTOR = 4096
TYPICAL_ERASE_NS = 45e6
PROGRAM_NS = 0.4e6
LOOP = 0x20070000  # RAM that the firmware leaves alone
DATA = 0x200
SIZE = 0x8000


class Place:
    """Where the functions are."""

    LOOKUP, NOTHING, ERASE, PROGRAM, BUSY, SYS_INFO, REBOOT, LOST = range(0x100, 0x110, 2)


FUNCTIONS = {
    **dict.fromkeys((b"IF", b"EX", b"FC", b"CX", b"XM", b"SR"), Place.NOTHING),
    b"RE": Place.ERASE,
    b"RP": Place.PROGRAM,
    b"GS": Place.SYS_INFO,
    b"RB": Place.REBOOT,
}


class PowerCut(Exception):
    """The power went while the flash was being written."""


class Rom:
    """The functions, and a flash chip that takes its time and can lose its power."""

    def __init__(self, core: Core, image: dict[int, bytes], serial: bytes) -> None:
        self._core = core
        self._serial = serial
        self.flash = bytearray(b"\xff" * FLASH_SIZE)
        self._flash_memory = (ctypes.c_char * FLASH_SIZE).from_buffer(self.flash)
        for address, page in image.items():
            self.flash[address : address + len(page)] = page
        self.cut_after_bytes: int | None = None  # power goes after so many of the next write
        self.erase_ns = TYPICAL_ERASE_NS
        self.spoilt_byte: int | None = None  # of the next page written, this byte fails
        self.power_up()
        uc = core.uc
        uc.mem_map(0, SIZE)
        content = bytearray(b"\x70\x47" * (SIZE // 2))  # bx lr
        content[0x14:0x16] = content[0x16:0x18] = struct.pack("<H", Place.LOOKUP + 1)
        content[DATA : DATA + 8] = struct.pack("<II", DATA + 4, 0)
        uc.mem_write(0, bytes(content))
        uc.hook_add(UC_HOOK_CODE, self._reached, begin=Place.LOOKUP, end=Place.LOST)
        for base in FLASH_BASES:
            uc.mem_map_ptr(base, FLASH_SIZE, UC_PROT_ALL, ctypes.addressof(self._flash_memory))

    def power_up(self) -> None:
        """Forget what was under way."""
        self.called = 0
        self.busy_until = 0
        self.bootloader = self.lost = False

    @property
    def waits(self) -> bool:
        """The main program stands in a function that waits for the flash."""
        return self.called == Place.BUSY and not self._core.active

    def wait(self) -> None:
        """Let the processor rest until the flash is ready or an interrupt comes."""
        core = self._core
        core.sleeping = core.counter.cycles < self.busy_until and not core.wakes()
        if core.counter.cycles >= self.busy_until:
            self._return()

    def serve(self) -> None:
        """Do what was called, if anything was."""
        if self.called and self.called != Place.BUSY:
            self.call()

    def _reached(self, uc: object, address: int, _size: int, _data: object) -> None:
        self.called = address
        self._core.uc.emu_stop()

    def _return(self, result: int | None = None) -> None:
        uc = self._core.uc
        if result is not None:
            uc.reg_write(arm_const.UC_ARM_REG_R0, result)
        uc.reg_write(arm_const.UC_ARM_REG_PC, uc.reg_read(arm_const.UC_ARM_REG_LR) | 1)
        self.called = 0
        self._core.sleeping = False

    def call(self) -> None:
        """Do what was called."""
        uc = self._core.uc
        first, second, third = (
            uc.reg_read(arm_const.UC_ARM_REG_R0 + number) for number in range(3)
        )
        self._core.sleeping = False
        match self.called:
            case Place.LOOKUP:
                code = struct.pack("<H", first & 0xFFFF)
                if second & 0x40:
                    self._return(DATA)
                else:
                    self._return(FUNCTIONS.get(code, Place.LOST) + 1)
            case Place.NOTHING:
                self._return()
            case Place.ERASE:
                self._change_flash(first, b"\xff" * second, self.erase_ns * second / SECTOR)
            case Place.PROGRAM:
                data = bytes(uc.mem_read(second, third))
                old = self.flash[first : first + third]
                mixed = bytearray(a & b for a, b in zip(data, old, strict=True))
                if self.spoilt_byte is not None:
                    mixed[self.spoilt_byte] ^= 0x10
                    self.spoilt_byte = None
                self._change_flash(first, bytes(mixed), PROGRAM_NS * third / 256)
            case Place.SYS_INFO:
                # Flags, package, then the chip's number, its low word first.
                number = int.from_bytes(self._serial, "big")
                words = struct.pack("<4I", third, 0, number & 0xFFFFFFFF, number >> 32)
                uc.mem_write(first, words)
                self._return(4)
            case Place.REBOOT:
                self.bootloader = True
                uc.mem_write(LOOP, struct.pack("<H", 0xE7FE))
                uc.reg_write(arm_const.UC_ARM_REG_PC, LOOP | 1)
                uc.reg_write(arm_const.UC_ARM_REG_PRIMASK, 1)
                self.called = 0
            case _:
                self.lost = True
                self._return()

    def _change_flash(self, address: int, data: bytes, ns: float) -> None:
        cut = self.cut_after_bytes
        part = data if cut is None else data[:cut]
        self.flash[address : address + len(part)] = part
        self.busy_until = self._core.counter.cycles + int(ns * HZ / 1e9)
        # The function goes on at the place that waits.
        self._core.uc.reg_write(arm_const.UC_ARM_REG_PC, Place.BUSY | 1)
        self.called = Place.BUSY
        if cut is not None:
            self.cut_after_bytes = cut - len(part)
            if len(part) < len(data):
                raise PowerCut
