"""Make UF2 files, which a board in its boot loader takes like a memory stick, and check them.

``python -m tools.uf2 torsio-BOARD.elf FIRMWARE.uf2`` writes one. The format is Microsoft's
(https://github.com/microsoft/uf2): blocks of 512 bytes, each with up to 476 bytes of payload, an
address and the number of the chip's family.
"""

from __future__ import annotations

import struct
import sys
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tools import boards

MAGIC_START = (0x0A324655, 0x9E5D5157)
MAGIC_END = 0x0AB16F30
FLAG_FAMILY = 0x00002000
FLAG_EXTENSION = 0x00008000
PAYLOAD = 256
MACHINE_ARM = 40
FLASH = range(0x10000000, 0x11000000)
FAMILIES = {"rp2040": 0xE48BFF56, "rp2350": 0xE48BFF59}

# RP2350 chips up to revision A2 lose the last block's data when a file is copied (erratum E10),
# unless it begins with a block of this family, which they write beyond any flash there is.
ABSOLUTE_FAMILY = 0xE48BFF57
ABSOLUTE_ADDRESS = 0x10FFFF00
IGNORE_EXTENSION = 0x9957E304

MARK = b"torsio firmware\0"
CHECKSUM_AT = 40

_HEADER = struct.Struct("<8I")
_ELF_HEADER = struct.Struct("<16sHHIIIIIHHHHHH")
_PROGRAM_HEADER = struct.Struct("<8I")


class FormatError(ValueError):
    """A file that is not what it should be."""


@dataclass(frozen=True)
class Block:
    """One block as it stands in a file."""

    flags: int
    address: int
    number: int
    count: int
    family: int
    payload: bytes


def read_elf(elf: bytes) -> dict[int, bytes]:
    """Return the flash's contents, in pages by address; unused bytes are zero.

    Raises
    ------
    FormatError
        If this is not a whole 32-bit little-endian ELF file for Arm, with something to load into
        the flash and nowhere else.
    """
    if elf[:7] != b"\x7fELF\x01\x01\x01" or len(elf) < _ELF_HEADER.size:
        raise FormatError("not a 32-bit little-endian ELF file")
    header = _ELF_HEADER.unpack_from(elf)
    if header[2] != MACHINE_ARM:
        raise FormatError("not for an Arm processor")
    offset, size, count = header[5], header[9], header[10]
    if offset + count * size > len(elf):
        raise FormatError("the file is cut off")
    pages: dict[int, bytearray] = {}
    for n in range(count):
        address, segment = _segment(elf, offset + n * size)
        for at, byte in enumerate(segment, address):
            page, place = divmod(at, PAYLOAD)
            pages.setdefault(page * PAYLOAD, bytearray(PAYLOAD))[place] = byte
    if not pages:
        raise FormatError("nothing to load")
    return {address: bytes(pages[address]) for address in sorted(pages)}


def _segment(elf: bytes, header: int) -> tuple[int, bytes]:
    """Return a segment's address and contents; none if it is not loaded."""
    kind, start, _, address, length, *_ = _PROGRAM_HEADER.unpack_from(elf, header)
    if kind != 1 or length == 0:
        return address, b""
    if address not in FLASH or address + length not in FLASH:
        raise FormatError(f"a segment at {address:#x} is not in the flash")
    if start + length > len(elf):
        raise FormatError("the file is cut off")
    return address, elf[start : start + length]


def seal(pages: dict[int, bytes]) -> dict[int, bytes]:
    """Return pages whose label says their CRC-32, reckoned with 0 in its place.

    firmware/boards/rp2/firmware_label.hpp has the label, sdk/src/firmware_file.cpp reads it.

    Raises
    ------
    FormatError
        Unless there is one label, whole.
    """
    image = b"".join(pages.values())
    at = image.find(MARK) + CHECKSUM_AT
    if image.count(MARK) != 1 or image[at : at + 4] != bytes(4):
        raise FormatError("not the label of Torsio's firmware, once, without a checksum")
    image = image[:at] + struct.pack("<I", zlib.crc32(image)) + image[at + 4 :]
    return {address: image[n * PAYLOAD :][:PAYLOAD] for n, address in enumerate(pages)}


def _block(
    address: int, number: int, count: int, family: int, payload: bytes, ignored: bool = False
) -> bytes:
    flags = FLAG_FAMILY | (FLAG_EXTENSION if ignored else 0)
    header = _HEADER.pack(*MAGIC_START, flags, address, len(payload), number, count, family)
    extension = struct.pack("<I", IGNORE_EXTENSION) if ignored else b""
    return (header + payload + extension).ljust(508, b"\0") + struct.pack("<I", MAGIC_END)


def make(pages: dict[int, bytes], chip: str) -> bytes:
    """Return the file that puts these pages into a chip's flash."""
    blocks = [
        _block(address, number, len(pages), FAMILIES[chip], payload)
        for number, (address, payload) in enumerate(pages.items())
    ]
    if chip == "rp2350":
        ignored = _block(ABSOLUTE_ADDRESS, 0, 2, ABSOLUTE_FAMILY, b"\xef" * PAYLOAD, ignored=True)
        blocks.insert(0, ignored)
    return b"".join(blocks)


def blocks(uf2: bytes) -> Iterator[Block]:
    """Yield every block of a file.

    Raises
    ------
    FormatError
        If a block does not follow the format.
    """
    if not uf2 or len(uf2) % 512 != 0:
        raise FormatError("not a whole number of blocks")
    for at in range(0, len(uf2), 512):
        first, second, flags, address, size, number, count, family = _HEADER.unpack_from(uf2, at)
        (last,) = struct.unpack_from("<I", uf2, at + 508)
        if (first, second, last) != (*MAGIC_START, MAGIC_END):
            raise FormatError(f"block at {at}: wrong magic number")
        if size != PAYLOAD or address % PAYLOAD != 0:
            raise FormatError(f"block at {at}: not one page of {PAYLOAD} bytes")
        yield Block(flags, address, number, count, family, uf2[at + 32 : at + 32 + size])


def check(uf2: bytes, chip: str) -> dict[int, bytes]:
    """Return a file's pages by address, after checking that a boot loader would take it.

    Raises
    ------
    FormatError
        If blocks are missing, doubled, out of order, outside the flash or for another chip.
    """
    found = list(blocks(uf2))
    if chip == "rp2350":
        lead = found.pop(0)
        if (lead.family, lead.address) != (ABSOLUTE_FAMILY, ABSOLUTE_ADDRESS):
            raise FormatError("the leading block is missing")
    pages: dict[int, bytes] = {}
    for number, block in enumerate(found):
        if block.family != FAMILIES[chip] or not block.flags & FLAG_FAMILY:
            raise FormatError(f"block {number}: not for {chip}")
        if (block.number, block.count) != (number, len(found)):
            raise FormatError(f"block {number}: counted as {block.number} of {block.count}")
        if block.address not in FLASH or block.address in pages:
            raise FormatError(f"block {number}: address {block.address:#x}")
        pages[block.address] = block.payload
    if FLASH.start not in pages:
        raise FormatError("the flash's first page is missing")
    return pages


def main(arguments: list[str]) -> int:
    """Convert one file, whose name tells the board and so the chip."""
    source, target = (Path(argument) for argument in arguments)
    try:
        chip = boards.chip_of(source)
        uf2 = make(seal(read_elf(source.read_bytes())), chip)
        check(uf2, chip)
    except ValueError as error:
        print(f"{source}: {error}", file=sys.stderr)
        return 1
    target.write_bytes(uf2)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
