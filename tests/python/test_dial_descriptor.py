"""The dial's report descriptor, read by hid-tools.

What is asked of the radial controller comes from Microsoft's "Windows radial controller protocol
implementation". Linux reads mouse and keys in ``tests/vm/guest/test_dial.py``.
"""

from __future__ import annotations

import pytest

from tests.python.hid_fields import APPLICATION, Field, fields, report_bytes
from torsio._torsio import emulator

DESCRIPTOR = emulator.usb_report_descriptor(1, dial=True)
DESKTOP, BUTTON, CONSUMER = 0x01 << 16, 0x09 << 16, 0x0C << 16
ORDINAL, PUCK, HAPTICS = 0x0A << 16, 0x0D << 16 | 0x21, 0x0E << 16
DIAL, CLICK, BUZZ = DESKTOP | 0x37, 0x1003, 0x1004
EVERY_FIELD = fields(DESCRIPTOR)
RADIAL = [f for f in EVERY_FIELD if f.collections[0][2] == DESKTOP | 0x0E]
FIELDS = [f for f in EVERY_FIELD if f not in RADIAL]


def _the(usage: int, among: list[Field] = FIELDS) -> Field:
    (found,) = [field for field in among if usage in field.usages]
    return found


def test_it_is_a_mouse_a_volume_control_and_a_radial_controller() -> None:
    applications = {f.collections[0][2] for f in EVERY_FIELD if f.collections[0][1] == APPLICATION}
    assert applications == {DESKTOP | 0x02, CONSUMER | 0x01, DESKTOP | 0x0E}
    assert not [f for f in FIELDS if f.kind == "Output"]


def test_reports_have_the_sizes_that_the_device_sends() -> None:
    assert report_bytes(FIELDS) == {("Input", 1): 8, ("Input", 2): 2, ("Feature", 3): 2}
    haptics = {("Output", 5): 6, ("Feature", 5): 6, ("Feature", 6): 11}
    assert report_bytes(RADIAL) == {("Input", 4): 4, **haptics}


def test_radial_controller_has_a_button_and_a_dial_in_tenths_of_a_degree() -> None:
    button, dial = _the(BUTTON | 1, RADIAL), _the(DIAL, RADIAL)
    assert (button.kind, button.flags, button.bits, button.maximum) == ("Input", 2, 1, 1)
    assert (dial.kind, dial.flags, dial.report) == ("Input", 6, button.report)
    assert dial.physical == (dial.minimum, dial.maximum) == (-3600, 3600)
    # Degrees of the English rotation system.
    assert (dial.state["Unit"], dial.state["Unit Exponent"]) == (0x14, -1)
    for field in (button, dial):
        assert [usage for _, kind, usage in field.collections[1:] if kind == 0] == [PUCK]


@pytest.mark.parametrize(("kind", "trigger", "lowest"), [("Output", 0x21, 1), ("Feature", 0x20, 0)])
def test_haptics_are_triggered_by_hand_and_automatically(
    kind: str, trigger: int, lowest: int
) -> None:
    fields = [f for f in RADIAL if f.kind == kind and f.report == 5]
    assert all(HAPTICS | 0x01 in f.logical for f in fields)
    # Ordinal of a waveform, intensity in percent, repeats, retrigger period in ms. Automatic: or 0.
    assert [(*f.usages, f.minimum, f.maximum, f.bits) for f in fields] == [
        (HAPTICS | trigger, lowest, 4, 8),
        (HAPTICS | 0x23, 0, 100, 8),
        (HAPTICS | 0x24, 0, 255, 8),
        (HAPTICS | 0x25, 0, 2000, 16),
    ]


def test_waveforms_are_a_click_and_a_buzz_at_the_dial() -> None:
    constant = [f for f in RADIAL if f.report == 6]
    assert all((f.kind, f.flags) == ("Feature", 3) for f in constant)
    control = _the(HAPTICS | 0x22, constant)
    assert (control.minimum, control.maximum, control.bits) == (DIAL, DIAL, 32)
    assert _the(HAPTICS | 0x28, constant).bits == 16  # cutoff time
    for number, waveform in ((3, CLICK), (4, BUZZ)):
        listed, lasts = (f for f in constant if ORDINAL | number in f.usages)
        assert listed.logical == (HAPTICS | 0x01, HAPTICS | 0x10)
        assert (listed.minimum, listed.maximum) == (number, number)
        assert listed.physical == (waveform, waveform)
        assert lasts.logical == (HAPTICS | 0x01, HAPTICS | 0x11)


def test_vendor_interface_is_the_same_beside_a_dial() -> None:
    assert emulator.usb_report_descriptor(0, dial=True) == emulator.usb_report_descriptor(0)
    assert emulator.usb_report_descriptor(1) != DESCRIPTOR
