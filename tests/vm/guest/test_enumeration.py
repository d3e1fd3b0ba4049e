"""The kernel's view of a knob that is plugged in."""

from __future__ import annotations

import fcntl
import os
import re
import struct
from pathlib import Path

import pytest

import torsio
from tests.python import wire
from tests.vm.guest.virtual_bus import VirtualBus, VirtualKnob

# HIDIOCGRDESCSIZE and HIDIOCGRDESC of linux/hidraw.h
_GET_SIZE = 0x80044801
_GET_DESCRIPTOR = 0x90044802


def attribute(path: Path) -> str:
    return path.read_text().strip()


def report_descriptor(device: Path) -> bytes:
    file = os.open(device, os.O_RDWR)
    try:
        size = struct.unpack("i", fcntl.ioctl(file, _GET_SIZE, bytes(4)))[0]
        answer = bytearray(struct.pack("I", size) + bytes(4096))
        fcntl.ioctl(file, _GET_DESCRIPTOR, answer)
    finally:
        os.close(file)
    return bytes(answer[4 : 4 + size])


def test_device_is_what_the_board_is(knob: VirtualKnob) -> None:
    # Full speed is 12 Mbit/s.
    expected = {"speed": "12", "bNumConfigurations": "1"}
    expected["idVendor"], expected["idProduct"] = wire.USB_ID.split(":")
    found = {name: attribute(knob.sysfs / name) for name in expected}
    assert found == expected
    assert attribute(knob.sysfs / "serial") == knob.serial
    # A host puts the maker before the product.
    assert attribute(knob.sysfs / "manufacturer") == "Torsio"
    assert attribute(knob.sysfs / "product") == "haptic knob"
    assert attribute(knob.sysfs / "bMaxPacketSize0") == "64"


def test_interface_polls_64_bytes_both_ways_every_millisecond(knob: VirtualKnob) -> None:
    assert attribute(knob.interface / "bInterfaceClass") == "03"
    assert attribute(knob.interface / "bInterfaceSubClass") == "00"  # no boot protocol
    assert (knob.interface / "driver").resolve().name == "usbhid"
    endpoints = {}
    for folder in knob.interface.glob("ep_*"):
        names = ("type", "wMaxPacketSize", "interval")
        endpoints[attribute(folder / "direction")] = [attribute(folder / name) for name in names]
    assert endpoints == {"in": ["Interrupt", "0040", "1ms"], "out": ["Interrupt", "0040", "1ms"]}


def test_descriptors_have_their_own_lengths(knob: VirtualKnob) -> None:
    """Walk the raw bytes as the USB specification tells to."""
    data = (knob.sysfs / "descriptors").read_bytes()
    assert data[:2] == bytes([18, 1])
    assert data[18:20] == bytes([9, 2])
    total = struct.unpack("<H", data[20:22])[0]
    assert len(data) == 18 + total
    place, kinds = 0, []
    while place < len(data):
        assert data[place] >= 2
        kinds.append(data[place + 1])
        place += data[place]
    assert place == len(data)
    # device, configuration, interface, HID, two endpoints
    assert kinds[:6] == [1, 2, 4, 0x21, 5, 5]


def test_report_descriptor_is_ours_and_the_kernel_parsed_it(knob: VirtualKnob) -> None:
    ours = report_descriptor(knob.hidraw)
    hid = next(knob.interface.glob(f"*:{wire.USB_ID}.*"))
    assert (hid / "report_descriptor").read_bytes() == ours
    parsed = Path("/sys/kernel/debug/hid", hid.name, "rdesc").read_text()
    first = bytes.fromhex(parsed.splitlines()[0])
    assert first == ours
    # Number after number as docs/reference/protocol.md has them.
    found = {
        kind: {int(number) for number in re.findall(rf"{kind}\((\d+)\)\[", parsed)}
        for kind in ("INPUT", "OUTPUT", "FEATURE")
    }
    assert found["FEATURE"] == set(range(0x01, 0x0D))
    assert found["OUTPUT"] == {*range(0x10, 0x15), *range(0x20, 0x2D), 0x2F}
    assert found["INPUT"] == {0x40, 0x41, 0x42}
    sizes = set(re.findall(r"Report Size\((\d+)\)", parsed))
    counts = set(re.findall(r"Report Count\((\d+)\)", parsed))
    assert sizes == {"8"}
    assert counts == {"63"}  # and the report's number: 64 bytes


def test_knob_introduces_itself_over_hidapi(knob: VirtualKnob) -> None:
    listed = torsio.list_devices()
    assert [device.serial for device in listed] == [knob.serial, "EMULATED"]
    assert listed[0].path == str(knob.hidraw)
    assert listed[0].problem == ""
    with torsio.open(knob.serial) as opened:
        assert opened.info.transport == "hid"
        assert opened.info.serial == knob.serial
        assert opened.info.fingerprint == torsio.protocol.fingerprint()


@pytest.mark.pulls_cable
def test_two_knobs_are_two(bus: VirtualBus) -> None:
    still, turned = bus.plug("STILL"), bus.plug("TURNED")
    assert still.hidraw != turned.hidraw
    still.say("still")
    turned.say("angle 0.5")
    with torsio.open("STILL") as first, torsio.open("TURNED") as second:
        first.sleep(0.5)
        assert abs(first.position_rad()) < 0.01
        assert abs(second.position_rad() - 0.5) < 0.05
        first.arm()
        assert (first.state, second.state) == ("armed", "disarmed")
        second.arm()
        turned.unplug()
        assert second.wait_for("disconnected", timeout_s=10)
        assert len(first.record(duration_s=0.1)) == 100
        assert first.statistics().samples_lost == 0
