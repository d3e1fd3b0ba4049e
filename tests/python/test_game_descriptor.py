"""The report descriptor of games and of the dial changes only on purpose.

Real readers look into it: Linux's hid-pidff and hid-input in ``tests/vm/guest/test_game.py`` and
``test_dial.py`` at every change, SDL, Wine and libinput in slow groups.
"""

from __future__ import annotations

import hashlib

import pytest
from hidtools.hid import ReportDescriptor

from tests.python.hid_fields import fields, report_bytes
from torsio._torsio import emulator


def test_every_report_has_one_kind_and_whole_bytes() -> None:
    every = fields(emulator.usb_report_descriptor(1))
    for report in {f.report for f in every}:
        of_report = [f for f in every if f.report == report]
        assert len({f.kind for f in of_report}) == 1
        assert sum(f.bits * f.count for f in of_report) % 8 == 0
    sizes = {report: size for (_, report), size in report_bytes(every).items()}
    assert sizes == {
        **{0x01: 6, 0x02: 4, 0x11: 17, 0x12: 10, 0x13: 15, 0x14: 10, 0x15: 4, 0x16: 6},
        **{0x1A: 4, 0x1B: 2, 0x1C: 2, 0x1D: 3, 0x21: 4, 0x22: 5, 0x23: 5},
    }


def test_vendor_interface_has_no_game_in_it() -> None:
    items = ReportDescriptor.from_bytes(emulator.usb_report_descriptor(0)).rdesc_items
    assert (items[0].item, items[0].value) == ("Usage Page", 0xFF00)
    with pytest.raises(ValueError, match="no such interface"):
        emulator.usb_report_descriptor(2)


@pytest.mark.parametrize(
    ("dial", "known"),
    [
        (False, "28109ecc3671dc87a01e5b2d48285cf1f0a6285e8c7f95dfc23ca77fe6c88bb5"),
        (True, "8250232772bbeb4d5c8fdfd28ac3f98f16510af27db0d12d9b36f24b5e508f87"),
    ],
)
def test_descriptor_bytes_change_only_on_purpose(dial: bool, known: str) -> None:
    # Drivers remember a device by its descriptor; a new one is a new device to them.
    descriptor = emulator.usb_report_descriptor(1, dial=dial)
    assert hashlib.sha256(descriptor).hexdigest() == known
