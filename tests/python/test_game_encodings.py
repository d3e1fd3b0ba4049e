"""The numbers of the game interface's descriptor, as readers with different rules read them.

HID 1.11 leaves open, or drivers get wrong, whether an item's number has a sign and how long it is.
A parser of a few lines, apart from hid-tools and from what wrote the descriptor, reads every
item in each way; all of them must find the same times and angles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from torsio._torsio import emulator

DESCRIPTOR = emulator.usb_report_descriptor(1)
# Bytes of the items (HID 1.11, 6.2.2), without the two bits of their length.
USAGE_PAGE, LOGICAL_MIN, LOGICAL_MAX, PHYSICAL_MIN, PHYSICAL_MAX = 0x04, 0x14, 0x24, 0x34, 0x44
EXPONENT, UNIT, USAGE = 0x54, 0x64, 0x08
MAIN = (0x80, 0x90, 0xB0, 0xA0, 0xC0)
SECONDS, DEGREES = 0x1003, 0x14

Reader = Callable[[bytes], int]
Field = dict[int, bytes]


def _signed(data: bytes) -> int:
    return int.from_bytes(data, "little", signed=True)


def _unsigned(data: bytes) -> int:
    return int.from_bytes(data, "little")


def _nibble(data: bytes) -> int:
    """Read an exponent by the letter of the standard: four bits in two's complement."""
    low = data[0] & 0x0F
    return low - 16 if low > 7 else low


def _linux(data: bytes) -> int:
    """Read an exponent as Linux does: a nibble if nothing is above it, else the item's number."""
    return _nibble(data) if not _signed(data) & ~0x0F else _signed(data)


def _fields() -> Iterator[tuple[list[int], Field]]:
    """Yield the usages of each field and the bytes of the items that hold for it."""
    at, state, usages = 0, dict[int, bytes](), list[int]()
    while at < len(DESCRIPTOR):
        head = DESCRIPTOR[at]
        length = (0, 1, 2, 4)[head & 3]
        data = DESCRIPTOR[at + 1 : at + 1 + length]
        kind = head & 0xFC
        at += 1 + length
        if kind == USAGE:
            usages.append(_unsigned(state[USAGE_PAGE]) << 16 | _unsigned(data))
        elif kind in MAIN:
            if kind in MAIN[:3]:
                yield usages, dict(state)
            usages = []
        else:
            state[kind] = data
    assert at == len(DESCRIPTOR)


FIELDS = list(_fields())
EXPONENT_READERS = pytest.mark.parametrize("exponent", [_signed, _nibble, _linux])
READERS = pytest.mark.parametrize("number", [_signed, _unsigned])
PID = 0x0F << 16


def _measured(unit: int) -> list[tuple[list[int], Field]]:
    return [(u, f) for u, f in FIELDS if UNIT in f and _unsigned(f[UNIT]) == unit]


def _full(field: Field, number: Reader, exponent: Reader) -> float:
    """Return what the largest logical value means, in the field's unit."""
    return float(number(field[PHYSICAL_MAX]) * 10.0 ** exponent(field[EXPONENT]))


@READERS
@EXPONENT_READERS
def test_times_are_milliseconds_to_every_reader(number: Reader, exponent: Reader) -> None:
    times = _measured(SECONDS)
    # Duration, repetition, delay, attack, fade, period.
    assert {u for usages, _ in times for u in usages} == {
        PID | usage for usage in (0x50, 0x54, 0xA7, 0x5C, 0x5E, 0x72)
    }
    for _, field in times:
        assert number(field[LOGICAL_MAX]) == 32767
        assert _full(field, number, exponent) == pytest.approx(32.767)


@READERS
@EXPONENT_READERS
def test_angles_are_hundredths_of_a_degree_to_every_reader(
    number: Reader, exponent: Reader
) -> None:
    angles = _measured(DEGREES)
    # Two directions of one field, and a wave's phase.
    assert [usages for usages, _ in angles] == [[0x0A << 16 | 1, 0x0A << 16 | 2], [PID | 0x71]]
    for _, field in angles:
        assert number(field[LOGICAL_MAX]) == 32767
        assert _full(field, number, exponent) == pytest.approx(360)
        # Wine takes the physical maximum for hundredths and does not look at the exponent.
        assert number(field[PHYSICAL_MAX]) == 36000


def test_exponents_are_whole_bytes_because_wine_has_no_nibbles() -> None:
    written = {field[EXPONENT] for _, field in FIELDS if EXPONENT in field}
    assert written == {b"\xfd", b"\xfe", b"\x00"}


def test_no_maximum_depends_on_whether_its_number_has_a_sign() -> None:
    for _, field in FIELDS:
        for item in (LOGICAL_MAX, PHYSICAL_MAX):
            if item in field:
                assert _signed(field[item]) == _unsigned(field[item])
