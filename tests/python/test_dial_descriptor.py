"""The dial's report descriptor, read by hid-tools.

What is asked of it comes from the HID Usage Tables 1.4 (4.3.1, resolution multiplier), from what
Linux's hid-input looks for, and from Microsoft's "Enhanced Wheel Support in Windows".
"""

from __future__ import annotations

import pytest

from tests.python.hid_fields import APPLICATION, LOGICAL, Field, fields, report_bytes
from torsio._torsio import emulator

DESCRIPTOR = emulator.usb_report_descriptor(1, dial=True)
DESKTOP, BUTTON, CONSUMER = 0x01 << 16, 0x09 << 16, 0x0C << 16
MULTIPLIER, WHEEL, AC_PAN = DESKTOP | 0x48, DESKTOP | 0x38, CONSUMER | 0x238
FIELDS = fields(DESCRIPTOR)


def _the(usage: int) -> Field:
    (found,) = [field for field in FIELDS if usage in field.usages]
    return found


def test_it_is_a_mouse_and_a_volume_control() -> None:
    applications = {f.collections[0][2] for f in FIELDS if f.collections[0][1] == APPLICATION}
    assert applications == {DESKTOP | 0x02, CONSUMER | 0x01}
    assert not [f for f in FIELDS if f.kind == "Output"]


def test_mouse_has_what_systems_know_a_mouse_by() -> None:
    for axis in (0x30, 0x31):
        field = _the(DESKTOP | axis)
        assert (field.kind, field.flags, field.bits) == ("Input", 6, 8)  # changes
        assert (field.minimum, field.maximum) == (-127, 127)
    for button in (1, 2, 3):
        assert (_the(BUTTON | button).kind, _the(BUTTON | button).bits) == ("Input", 1)


@pytest.mark.parametrize("wheel", [WHEEL, AC_PAN])
def test_each_wheel_has_a_multiplier_of_its_own(wheel: int) -> None:
    field = _the(wheel)
    assert (field.kind, field.flags, field.bits) == ("Input", 6, 16)
    assert (field.minimum, field.maximum) == (-32767, 32767)
    assert field.physical == (0, 0)  # as the logical ones
    # A multiplier applies to the controls in its own logical collection.
    (multiplier,) = [
        f for f in FIELDS if MULTIPLIER in f.usages and f.collections[-1] == field.collections[-1]
    ]
    assert field.collections[-1][1] == LOGICAL
    assert (multiplier.kind, multiplier.flags) == ("Feature", 2)
    # Linux: (value - min) / (max - min) * (physical max - physical min) + physical min.
    low, high = multiplier.minimum, multiplier.maximum
    physical_low, physical_high = multiplier.physical
    effective = [
        (value - low) / (high - low) * (physical_high - physical_low) + physical_low
        for value in (0, 1)
    ]
    assert effective == [1, 120]
    assert multiplier.state.get("Unit Exponent", 0) == 0
    assert field.report != multiplier.report


def test_no_other_field_has_physical_limits() -> None:
    for field in FIELDS:
        if MULTIPLIER not in field.usages and field.usages:
            assert field.physical == (0, 0)


def test_keys_are_louder_and_quieter() -> None:
    for key in (0xE9, 0xEA):
        field = _the(CONSUMER | key)
        assert (field.kind, field.flags, field.bits, field.maximum) == ("Input", 2, 1, 1)


def test_reports_have_the_sizes_that_the_device_sends() -> None:
    assert report_bytes(FIELDS) == {("Input", 1): 8, ("Input", 2): 2, ("Feature", 3): 2}


def test_vendor_interface_is_the_same_beside_a_dial() -> None:
    assert emulator.usb_report_descriptor(0, dial=True) == emulator.usb_report_descriptor(0)
    assert emulator.usb_report_descriptor(1) != DESCRIPTOR
