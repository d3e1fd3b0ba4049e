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


def report_descriptor(device: Path) -> bytes:
    file = os.open(device, os.O_RDWR)
    try:
        size = struct.unpack("i", fcntl.ioctl(file, _GET_SIZE, bytes(4)))[0]
        answer = bytearray(struct.pack("I", size) + bytes(4096))
        fcntl.ioctl(file, _GET_DESCRIPTOR, answer)
    finally:
        os.close(file)
    return bytes(answer[4 : 4 + size])


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
