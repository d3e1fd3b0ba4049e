"""The game interface's report descriptor, read by hid-tools, against what drivers ask of it.

Linux's hid-pidff is the strictest reader there is; each requirement here is one of its checks, in
kernel 6.1 or since 6.12. The fields' bytes are those that docs/reference/games.md tabulates.
"""

from __future__ import annotations

import hashlib

import pytest
from hidtools.hid import ReportDescriptor

from tests.python.hid_fields import Field, fields, report_bytes
from torsio._torsio import emulator

PID, DESKTOP, BUTTON = 0x0F << 16, 0x01 << 16, 0x09 << 16
EFFECT_TYPES = [PID | u for u in (0x26, 0x27, *range(0x30, 0x35), *range(0x40, 0x44))]


FIELDS = fields(emulator.usb_report_descriptor(1))


def _report(kind: str, usage: int) -> list[Field]:
    """Find the fields of the report whose logical collection has this usage, as hid-pidff does."""
    ids = {f.report for f in FIELDS if f.kind == kind and f.logical[:1] == (PID | usage,)}
    assert len(ids) == 1, hex(usage)
    return [f for f in FIELDS if f.kind == kind and f.report in ids and not f.constant]


def _value(report: list[Field], usage: int) -> Field:
    (found,) = [f for f in report if PID | usage in f.usages and f.variable]
    assert found.count == len(found.usages)  # else hid-pidff does not look at it
    return found


def _array(report: list[Field], usage: int) -> Field:
    (found,) = [f for f in report if f.logical[-1:] == (PID | usage,) and not f.variable]
    assert found.count == 1
    assert found.minimum == 1
    assert found.maximum == len(found.usages)
    return found


def test_first_collection_is_a_joystick_application() -> None:
    items = ReportDescriptor.from_bytes(emulator.usb_report_descriptor(1)).rdesc_items
    assert [(i.item, i.value) for i in items[:3]] == [
        ("Usage Page", 0x01),
        ("Usage", 0x04),
        ("Collection", 1),
    ]
    applications = [i for i in items if i.item == "Collection" and i.value == 1]
    assert len(applications) == 1


def test_first_input_is_two_axes_and_two_buttons() -> None:
    inputs = [f for f in FIELDS if f.kind == "Input" and not f.constant]
    x, *others = inputs
    assert x.usages == (DESKTOP | 0x30,)
    (y,) = [f for f in others if f.usages == (DESKTOP | 0x31,)]
    for axis in (x, y):
        assert (axis.minimum, axis.maximum, axis.bits) == (-32767, 32767, 16)
    buttons = [u for f in others for u in f.usages if u & 0xFFFF0000 == BUTTON]
    assert buttons == [BUTTON | 1, BUTTON | 2]


@pytest.mark.parametrize(
    ("kind", "usage", "values"),
    [
        ("Output", 0x21, (0x22, 0x50, 0x52, 0x53, 0x54, 0x56, 0xA7)),
        ("Output", 0x77, (0x22, 0x7C)),
        ("Output", 0x7D, (0x7E,)),
        ("Output", 0x90, (0x22,)),
        ("Output", 0x5A, (0x22, 0x5B, 0x5C, 0x5D, 0x5E)),
        ("Output", 0x5F, (0x22, 0x23, 0x60, 0x61, 0x62, 0x63, 0x64, 0x65)),
        ("Output", 0x6E, (0x22, 0x70, 0x6F, 0x71, 0x72)),
        ("Output", 0x73, (0x22, 0x70)),
        ("Output", 0x74, (0x22, 0x75, 0x76)),
        ("Feature", 0x7F, (0x80, 0x83, 0xA9)),
        ("Feature", 0x89, (0x22, 0xAC)),
    ],
)
def test_report_has_every_value_that_the_driver_looks_for(
    kind: str, usage: int, values: tuple[int, ...]
) -> None:
    # Without 0xA7 or 0x23 Linux finds no effects (JacKeTUs/linux-steering-wheels#24).
    for value in values:
        _value(_report(kind, usage), value)


def test_effect_types_are_the_same_in_set_effect_and_create_new_effect() -> None:
    set_effect = _array(_report("Output", 0x21), 0x25)
    create = _array(_report("Feature", 0xAB), 0x25)
    assert list(set_effect.usages) == EFFECT_TYPES
    assert create.usages == set_effect.usages


def test_arrays_have_every_choice_and_count_from_one() -> None:
    operation = _array(_report("Output", 0x77), 0x78)
    assert operation.usages == (PID | 0x79, PID | 0x7A, PID | 0x7B)
    status = _array(_report("Feature", 0x89), 0x8B)
    assert status.usages == (PID | 0x8C, PID | 0x8D, PID | 0x8E)
    control = _array(_report("Output", 0x96), 0x96)
    assert control.usages == tuple(PID | u for u in range(0x97, 0x9D))


def test_direction_stands_in_a_collection_of_its_own() -> None:
    (direction,) = [f for f in _report("Output", 0x21) if f.logical[-1] == PID | 0x57]
    assert direction.count == len(direction.usages) == 2
    assert direction.minimum == 0
    # Linux multiplies it with 65535 in 32 bits.
    assert direction.maximum * 0xFFFF < 2**31


def test_block_index_counts_forty_blocks_from_one() -> None:
    indices = [f for f in FIELDS if PID | 0x22 in f.usages]
    assert len(indices) == 10
    assert {(f.minimum, f.maximum, f.bits) for f in indices} == {(1, 40, 8)}


def test_logical_limits_fit_sixteen_signed_bits_and_their_field() -> None:
    for field in FIELDS:
        assert -32767 <= field.minimum < field.maximum <= 32767 or field.constant
        span = field.maximum - min(field.minimum, 0)
        assert field.constant or span < 2**field.bits


def test_every_report_has_one_kind_and_whole_bytes() -> None:
    for report in {f.report for f in FIELDS}:
        of_report = [f for f in FIELDS if f.report == report]
        assert len({f.kind for f in of_report}) == 1
        assert sum(f.bits * f.count for f in of_report) % 8 == 0
    sizes = {report: size for (_, report), size in report_bytes(FIELDS).items()}
    assert sizes == {
        **{0x01: 6, 0x02: 4, 0x11: 17, 0x12: 10, 0x13: 15, 0x14: 10, 0x15: 4, 0x16: 6},
        **{0x1A: 4, 0x1B: 2, 0x1C: 2, 0x1D: 3, 0x21: 4, 0x22: 5, 0x23: 5},
    }


def test_vendor_interface_has_no_game_in_it() -> None:
    items = ReportDescriptor.from_bytes(emulator.usb_report_descriptor(0)).rdesc_items
    assert (items[0].item, items[0].value) == ("Usage Page", 0xFF00)
    with pytest.raises(ValueError, match="no such interface"):
        emulator.usb_report_descriptor(2)


def test_descriptor_bytes_change_only_on_purpose() -> None:
    # Drivers remember a device by its descriptor; a new one is a new device to them.
    descriptor = emulator.usb_report_descriptor(1)
    assert descriptor.startswith(bytes.fromhex("05010904a10185010930160180"))
    assert (
        hashlib.sha256(descriptor).hexdigest()
        == "28109ecc3671dc87a01e5b2d48285cf1f0a6285e8c7f95dfc23ca77fe6c88bb5"
    )
