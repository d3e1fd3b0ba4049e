"""UF2 files, which a boot loader takes like a memory stick: what is in one, and is it whole.

The format is Microsoft's (https://github.com/microsoft/uf2): blocks of 512 bytes with an address, a
number and the family of the chip.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

__all__ = ["FormatError", "Image", "Label", "find_label", "read"]

_BLOCK_BYTES = 512
_PAGE_BYTES = 256
_HEADER = struct.Struct("<8I")
_BEGIN, _BEGIN_2, _END = 0x0A324655, 0x9E5D5157, 0x0AB16F30
_NOT_FLASH, _HAS_FAMILY = 0x0001, 0x2000
_FLASH = range(0x10000000, 0x11000000)

_CHIPS = {0xE48BFF56: "rp2040", 0xE48BFF59: "rp2350"}
_OTHERS = {
    0xE48BFF57: "no chip in particular",
    0xE48BFF58: "data of an RP2350",
    0xE48BFF5A: "an RP2350's RISC-V cores",
    0xE48BFF5B: "an RP2350 without security",
}
# A block that files for the RP2350 begin with because of a bug of its first chips (erratum E10).
_LEADING = (0xE48BFF57, 0x10FFFF00)

# firmware/boards/rp2/firmware_label.hpp has the same.
_LABEL = struct.Struct("<16sI3Bx16s")
_MARK = b"torsio firmware\0"


class FormatError(ValueError):
    """What is wrong with a file, in a sentence without its name."""


@dataclass(frozen=True)
class Image:
    """What a file puts into the flash, without a gap from its begin on."""

    chip: str
    """"rp2040" or "rp2350"."""
    data: bytes


@dataclass(frozen=True)
class Label:
    """What firmware says of itself."""

    board: str
    version: str
    fingerprint: int


@dataclass(frozen=True)
class _Block:
    place: int
    """In the file, from 0."""
    flags: int
    address: int
    number: int
    count: int
    family: int
    payload: bytes


def _block(uf2: bytes, place: int) -> _Block:
    block = uf2[place * _BLOCK_BYTES :][:_BLOCK_BYTES]
    begin, begin_2, flags, address, size, number, count, family = _HEADER.unpack_from(block)
    if (begin, begin_2) != (_BEGIN, _BEGIN_2) or block[-4:] != struct.pack("<I", _END):
        kind = "this is no UF2 file" if place == 0 else f"block {place} is damaged"
        raise FormatError(f"{kind}: its magic numbers are wrong")
    if size != _PAGE_BYTES or address % _PAGE_BYTES:
        raise FormatError(f"block {place} is not one page of {_PAGE_BYTES} bytes")
    return _Block(place, flags, address, number, count, family, block[32 : 32 + size])


def _chip(block: _Block) -> str:
    if not block.flags & _HAS_FAMILY:
        raise FormatError(f"block {block.place} does not say for which chip it is")
    if block.family not in _CHIPS:
        what = _OTHERS.get(block.family, "another chip")
        raise FormatError(
            f"it is for {what} (family 0x{block.family:08x}), not for an RP2040 or the Arm cores "
            "of an RP2350"
        )
    return _CHIPS[block.family]


def read(uf2: bytes) -> Image:
    """Read a whole file.

    Raises
    ------
    FormatError
        It is no UF2 file, not whole, for another chip, or does not fill the flash from its begin on
        without a gap.
    """
    if not uf2 or len(uf2) % _BLOCK_BYTES:
        raise FormatError(
            f"it has {len(uf2)} bytes, which is no whole number of blocks of {_BLOCK_BYTES}: it "
            "was cut off, or is no UF2 file"
        )
    blocks = [_block(uf2, place) for place in range(len(uf2) // _BLOCK_BYTES)]
    if len(blocks) > 1 and (blocks[0].family, blocks[0].address) == _LEADING:
        del blocks[0]
    chip = _chip(blocks[0])
    data = bytearray()
    for number, block in enumerate(blocks):
        if _chip(block) != chip:
            raise FormatError("it mixes blocks for different chips")
        if (block.number, block.count) != (number, len(blocks)):
            raise FormatError(
                f"blocks are missing, doubled or out of order: block {block.place} says that it is "
                f"number {block.number} of {block.count}, where number {number} of {len(blocks)} "
                "should be"
            )
        address = _FLASH.start + number * _PAGE_BYTES
        if block.flags & _NOT_FLASH or block.address != address or address not in _FLASH:
            raise FormatError(
                f"block {block.place} goes to address 0x{block.address:08x}, where 0x{address:08x} "
                "comes next"
            )
        data += block.payload
    return Image(chip, bytes(data))


def find_label(image: Image) -> Label:
    """Find what Torsio's firmware says of itself: a mark stands somewhere in its image.

    Raises
    ------
    FormatError
        There is none, or more than one.
    """
    marks = image.data.count(_MARK)
    if marks != 1:
        raise FormatError(
            "it is not Torsio's firmware, or of a version before it said its name"
            if marks == 0
            else "it has the mark of Torsio's firmware more than once"
        )
    at = image.data.index(_MARK)
    try:
        _, fingerprint, *version, board = _LABEL.unpack_from(image.data, at)
        name = board.rstrip(b"\0").decode("ascii")
    except (struct.error, UnicodeDecodeError):
        raise FormatError("what Torsio's firmware says of itself is damaged in it") from None
    return Label(name, ".".join(map(str, version)), fingerprint)
