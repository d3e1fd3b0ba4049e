"""The dial's report descriptor, read by hid-tools and by a parser of a few lines.

What is asked of it comes from the HID Usage Tables 1.4 (4.3.1, resolution multiplier), from what
Linux's hid-input looks for, and from Microsoft's "Enhanced Wheel Support in Windows".
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import pytest
from hidtools.hid import ReportDescriptor

from torsio._torsio import emulator

DESCRIPTOR = emulator.usb_report_descriptor(1, dial=True)
DESKTOP, BUTTON, CONSUMER = 0x01 << 16, 0x09 << 16, 0x0C << 16
MULTIPLIER, WHEEL, AC_PAN = DESKTOP | 0x48, DESKTOP | 0x38, CONSUMER | 0x238
INPUT, FEATURE = 0x80, 0xB0
APPLICATION, LOGICAL = 1, 2


@dataclass(frozen=True)
class Field:
    main: int
    flags: int
    usages: tuple[int, ...]
    collections: tuple[tuple[int, int, int], ...]  # number, kind and usage, outermost first
    items: dict[int, bytes]

    def number(self, item: int) -> int:
        return int.from_bytes(self.items.get(item, b"\0"), "little", signed=True)

    @property
    def bits(self) -> int:
        return self.number(0x74) * self.number(0x94)


def _fields() -> Iterator[Field]:
    at, made = 0, 0
    state: dict[int, bytes] = {}
    usages: list[int] = []
    collections: list[tuple[int, int, int]] = []
    while at < len(DESCRIPTOR):
        head = DESCRIPTOR[at]
        data = DESCRIPTOR[at + 1 : at + 1 + (0, 1, 2, 4)[head & 3]]
        kind = head & 0xFC
        at += 1 + len(data)
        if kind == 0x08:
            usages.append(
                int.from_bytes(state[0x04], "little") << 16 | int.from_bytes(data, "little")
            )
        elif kind == 0xA0:
            made += 1
            collections.append((made, data[0], usages[-1]))
            usages = []
        elif kind == 0xC0:
            collections.pop()
        elif kind in (INPUT, 0x90, FEATURE):
            yield Field(kind, data[0], tuple(usages), tuple(collections), dict(state))
            usages = []
        else:
            state[kind] = data
    assert collections == []
    assert at == len(DESCRIPTOR)


FIELDS = list(_fields())
REPORT = 0x84


def _the(usage: int) -> Field:
    (found,) = [field for field in FIELDS if usage in field.usages]
    return found


def test_it_is_a_mouse_and_a_volume_control() -> None:
    applications = {f.collections[0][2] for f in FIELDS if f.collections[0][1] == APPLICATION}
    assert applications == {DESKTOP | 0x02, CONSUMER | 0x01}
    assert not [f for f in FIELDS if f.main == 0x90]


def test_mouse_has_what_systems_know_a_mouse_by() -> None:
    for axis in (0x30, 0x31):
        field = _the(DESKTOP | axis)
        assert (field.main, field.flags, field.bits) == (INPUT, 6, 8)  # changes
        assert (field.number(0x14), field.number(0x24)) == (-127, 127)
    for button in (1, 2, 3):
        assert (_the(BUTTON | button).main, _the(BUTTON | button).bits) == (INPUT, 1)


@pytest.mark.parametrize("wheel", [WHEEL, AC_PAN])
def test_each_wheel_has_a_multiplier_of_its_own(wheel: int) -> None:
    field = _the(wheel)
    assert (field.main, field.flags, field.bits) == (INPUT, 6, 16)
    assert (field.number(0x14), field.number(0x24)) == (-32767, 32767)
    assert (field.number(0x34), field.number(0x44)) == (0, 0)  # as the logical ones
    # A multiplier applies to the controls in its own logical collection.
    (multiplier,) = [
        f for f in FIELDS if MULTIPLIER in f.usages and f.collections[-1] == field.collections[-1]
    ]
    assert field.collections[-1][1] == LOGICAL
    assert (multiplier.main, multiplier.flags) == (FEATURE, 2)
    # Linux: (value - min) / (max - min) * (physical max - physical min) + physical min.
    low, high, physical_low, physical_high = map(multiplier.number, (0x14, 0x24, 0x34, 0x44))
    effective = [
        (value - low) / (high - low) * (physical_high - physical_low) + physical_low
        for value in (0, 1)
    ]
    assert effective == [1, 120]
    assert multiplier.number(0x54) == 0
    assert field.items[REPORT] != multiplier.items[REPORT]


def test_no_other_field_has_physical_limits() -> None:
    for field in FIELDS:
        if MULTIPLIER not in field.usages and field.usages:
            assert (field.number(0x34), field.number(0x44)) == (0, 0)


def test_keys_are_louder_and_quieter() -> None:
    for key in (0xE9, 0xEA):
        field = _the(CONSUMER | key)
        assert (field.main, field.flags, field.bits, field.number(0x24)) == (INPUT, 2, 1, 1)


def test_reports_have_the_sizes_that_the_device_sends() -> None:
    sizes = {
        (f.main, f.number(REPORT)): 8
        + sum(g.bits for g in FIELDS if (g.main, g.number(REPORT)) == (f.main, f.number(REPORT)))
        for f in FIELDS
    }
    assert sizes == {(INPUT, 1): 8 * 8, (INPUT, 2): 2 * 8, (FEATURE, 3): 2 * 8}


def test_hid_tools_sees_the_same_reports() -> None:
    descriptor = ReportDescriptor.from_bytes(DESCRIPTOR)
    assert sorted(descriptor.input_reports) == [1, 2]
    assert sorted(descriptor.feature_reports) == [3]
    assert sorted(descriptor.output_reports) == []
    names = [
        field.usage_name for r in descriptor.input_reports.values() for field in r if field.usage
    ]
    assert "Wheel" in names
    assert "AC Pan" in names


def test_vendor_interface_is_the_same_beside_a_dial() -> None:
    assert emulator.usb_report_descriptor(0, dial=True) == emulator.usb_report_descriptor(0)
    assert emulator.usb_report_descriptor(1) != DESCRIPTOR
