"""The USB device controller as a host sees it: packets move when the host asks for them."""

from __future__ import annotations

import struct
from collections.abc import Callable

ADDRESS, SIE_CONTROL, SIE_STATUS, BUFFER_STATUS = 0x00, 0x4C, 0x50, 0x58
ABORT, ABORT_DONE, STALL_ARM, INTERRUPTS, ENABLED, STATUS = 0x60, 0x64, 0x68, 0x8C, 0x90, 0x98

PULL_UP = 1 << 16
SUSPENDED, RESUME, SETUP, RESET = 1 << 4, 1 << 11, 1 << 17, 1 << 19
# The interrupt of each bit of the status.
CAUSES = {SUSPENDED: 1 << 14, RESUME: 1 << 15, SETUP: 1 << 16, RESET: 1 << 12}
BUFFERS = 1 << 4

AVAILABLE, STALL, FULL, LENGTH = 1 << 10, 1 << 11, 1 << 15, 0x3FF


class Usb:
    """The controller; ``memory`` is the RAM that it shares with the processor."""

    def __init__(self, memory: memoryview, line: Callable[[bool], None]) -> None:
        self._memory = memory
        self._line = line
        self.registers: dict[int, int] = {}

    def read(self, offset: int) -> int:
        if offset == INTERRUPTS:
            return self._causes()
        if offset == STATUS:
            return self._causes() & self.registers.get(ENABLED, 0)
        if offset == ABORT_DONE:
            return self.registers.get(ABORT, 0)
        return self.registers.get(offset, 0)

    def write(self, offset: int, value: int, raw: int) -> None:
        """Write; ``raw`` is what came over the bus, before set and clear were applied."""
        if offset in (SIE_STATUS, BUFFER_STATUS):
            value = self.registers.get(offset, 0) & ~raw
        self.registers[offset] = value
        self._tell()

    @property
    def attached(self) -> bool:
        return bool(self.registers.get(SIE_CONTROL, 0) & PULL_UP)

    @property
    def address(self) -> int:
        return self.registers.get(ADDRESS, 0) & 0x7F

    def signal(self, bit: int) -> None:
        """Show the processor something that happened on the bus."""
        self.registers[SIE_STATUS] = self.registers.get(SIE_STATUS, 0) | bit
        self._tell()

    def setup(self, packet: bytes) -> None:
        """Receive a SETUP packet; it ends whatever endpoint 0 was at."""
        self.registers[STALL_ARM] = 0
        self._memory[0x80:0x88] = bytes(8)
        self._memory[0:8] = packet
        self.signal(SETUP)

    def token(self, endpoint: int, data: bytes | None) -> str | bytes:
        """Answer one IN (without data) or OUT token: nak, stall, ack, or the data read."""
        out = data is not None
        place = 0x80 + 8 * endpoint + 4 * out
        (control,) = struct.unpack_from("<I", self._memory, place)
        armed = endpoint != 0 or self.registers.get(STALL_ARM, 0) & (2 if out else 1)
        if control & STALL and armed:
            return "stall"
        if not control & AVAILABLE or out == bool(control & FULL):
            return "nak"
        at = self._buffer(endpoint, out)
        size = control & LENGTH if data is None else len(data)
        if data is not None:
            self._memory[at : at + size] = data
        kept = control & ~(AVAILABLE | FULL | LENGTH)
        struct.pack_into("<I", self._memory, place, kept | size | (FULL if out else 0))
        read = bytes(self._memory[at : at + size])
        bit = 1 << (2 * endpoint + out)
        self.registers[BUFFER_STATUS] = self.registers.get(BUFFER_STATUS, 0) | bit
        self._tell()
        return "ack" if out else read

    def _buffer(self, endpoint: int, out: bool) -> int:
        if endpoint == 0:
            return 0x100
        (control,) = struct.unpack_from("<I", self._memory, 8 * endpoint + 4 * out)
        return int(control & 0xFFC0)

    def _causes(self) -> int:
        status = self.registers.get(SIE_STATUS, 0)
        causes = sum(cause for bit, cause in CAUSES.items() if status & bit)
        return causes | (BUFFERS if self.registers.get(BUFFER_STATUS, 0) else 0)

    def _tell(self) -> None:
        self._line(bool(self._causes() & self.registers.get(ENABLED, 0)))
