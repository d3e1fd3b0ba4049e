"""Reads a firmware's flash, static RAM and stack from its ELF file.

``python -m tools.firmware_report FIRMWARE.elf...`` prints a line for each.
"""

from __future__ import annotations

import struct
import sys
from dataclasses import dataclass
from pathlib import Path

from tools import stack_bound


@dataclass(frozen=True)
class Sizes:
    """Bytes of a firmware."""

    flash: int
    ram: int
    symbols: frozenset[str]


def sizes(elf: Path) -> Sizes:
    """Read an ELF file: what is loaded into the flash, what is taken of the RAM, its symbols."""
    data = elf.read_bytes()
    header = struct.unpack_from("<16sHHIIIIIHHHHHH", data)
    sections = [
        struct.unpack_from("<10I", data, header[6] + n * header[11]) for n in range(header[12])
    ]
    flash = 0
    for n in range(header[10]):
        kind, _, _, _, length, *_ = struct.unpack_from("<8I", data, header[5] + n * header[9])
        flash += length if kind == 1 else 0
    allocated = [s for s in sections if s[2] & 2]
    ram = sum(s[5] for s in allocated if 0x20000000 <= s[3] < 0x20100000)
    names = set()
    for section in sections:
        if section[1] != 2:
            continue
        strings = sections[section[6]][4]
        for at in range(section[4], section[4] + section[5], section[9]):
            (name,) = struct.unpack_from("<I", data, at)
            end = data.index(b"\0", strings + name)
            names.add(data[strings + name : end].decode())
    return Sizes(flash, ram, frozenset(names))


def main(arguments: list[str]) -> int:
    """Print a line for each file; fail where the stack may get deeper than there is room."""
    result = 0
    for name in arguments:
        elf = Path(name)
        size = sizes(elf)
        try:
            deepest = stack_bound.of_firmware(elf)
        except stack_bound.UnknownStack as error:
            print(f"{elf.name}: {error}", file=sys.stderr)
            return 1
        print(
            f"{elf.stem}: {size.flash:,} bytes of flash, {size.ram:,} of static RAM; stack at most "
            f"{deepest.total_bytes:,} of {deepest.room_bytes:,} (main loop {deepest.main_bytes:,}, "
            f"interrupts {deepest.interrupt_bytes:,})"
        )
        if deepest.total_bytes > deepest.room_bytes:
            print(f"{elf.name}: too deep: {' -> '.join(deepest.path)}", file=sys.stderr)
            result = 1
    return result


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
