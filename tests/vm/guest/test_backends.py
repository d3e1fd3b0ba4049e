"""Both of hidapi's backends: the library itself, and the SDK on top of it."""

from __future__ import annotations

import contextlib
import ctypes
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import torsio
from tests.python import wire
from tests.vm.guest.virtual_bus import DEVICES, VirtualBus, VirtualKnob, ports
from torsio import protocol

HIDRAW, LIBUSB = "libhidapi-hidraw.so.0", "libhidapi-libusb.so.0"
IDENTITY = 0x01

# The library that answers, and the SDK's work on it.
SDK_PROGRAM = """
import sys, torsio
with open("/proc/self/maps") as maps:
    assert sys.argv[1] in maps.read()
with torsio.watch() as watch:
    print("watching", flush=True)
    event = watch.next(timeout_s=30)
    assert event is not None
    print(event.kind, event.device.serial, event.device.path, flush=True)
sys.stdin.readline()  # until the drivers are there
[listed] = [device for device in torsio.list_devices() if device.serial == sys.argv[2]]
assert listed.path == event.device.path
with torsio.open(listed.path) as knob:
    knob.play(torsio.Constant(torque_nm=0.01))
    knob.arm()
    knob.sleep(0.3)
    log = knob.record(duration_s=0.2)
    assert len(log) == 200, len(log)
    assert abs(log["desired_torque_nm"][-1] - 0.01) < 1e-4
    knob.disarm()
    assert knob.control_config().beta == 0.5
    assert knob.statistics().samples_lost == 0
print("closed", flush=True)
sys.stdin.readline()  # until they are there again
with torsio.open(listed.path) as knob:
    knob.arm()
    knob.start_telemetry()
    knob.read()
    print("reading", flush=True)
    try:
        while True:
            knob.read(timeout_s=60)
    except torsio.Disconnected:
        assert knob.state == "disconnected"
        print("disconnected")
"""


@pytest.mark.parametrize("library", [HIDRAW, LIBUSB])
def test_hidapi_opens_asks_sends_and_receives(knob: VirtualKnob, library: str) -> None:
    hidapi = ctypes.CDLL(library)
    hidapi.hid_open.restype = ctypes.c_void_p
    hidapi.hid_open.argtypes = (ctypes.c_ushort, ctypes.c_ushort, ctypes.c_wchar_p)
    assert hidapi.hid_init() == 0
    device = ctypes.c_void_p(hidapi.hid_open(wire.USB_VENDOR_ID, wire.USB_PRODUCT_ID, knob.serial))
    assert device
    try:
        text = ctypes.create_unicode_buffer(64)
        assert hidapi.hid_get_serial_number_string(device, text, 64) == 0
        assert text.value == knob.serial

        report = ctypes.create_string_buffer(bytes([IDENTITY]), 64)
        assert hidapi.hid_get_feature_report(device, report, 64) == 64
        name, identity = protocol.decode(report.raw)
        assert name == "identity"
        assert identity["fingerprint"] == protocol.fingerprint()

        def acknowledged(report: int) -> str:
            for _ in range(10):
                got = ctypes.create_string_buffer(64)
                assert hidapi.hid_read_timeout(device, got, 64, 5000) == 64
                name, values = protocol.decode(got.raw)
                if name == "acknowledgement" and values["report"] == report:
                    return protocol.STATUS_NAMES[values["status"]]
            raise AssertionError(f"no acknowledgement of report {report}")

        config = protocol.encode("control_config", {"beta": 0.25})
        assert hidapi.hid_send_feature_report(device, config, 64) == 64
        assert acknowledged(config[0]) == "ok"  # it counts from the next tick
        report = ctypes.create_string_buffer(config[:1], 64)
        assert hidapi.hid_get_feature_report(device, report, 64) == 64
        assert protocol.decode(report.raw)[1]["beta"] == 0.25
        # A stall, not a report that nobody knows
        report = ctypes.create_string_buffer(bytes([0x77]), 64)
        assert hidapi.hid_get_feature_report(device, report, 64) == -1

        command = protocol.encode("command", {"op": "arm"})
        assert hidapi.hid_write(device, command, 64) == 64
        assert acknowledged(command[0]) == "ok"
    finally:
        hidapi.hid_close(device)
        hidapi.hid_exit()


def test_sdk_uses_hidraw_by_itself(knob: VirtualKnob) -> None:
    """So that everything else that runs here speaks for this backend."""
    assert HIDRAW in Path("/proc/self/maps").read_text()
    assert torsio.list_devices()[0].path == str(knob.hidraw)


@contextlib.contextmanager
def without_drivers() -> Iterator[None]:
    """Keep all drivers away from what is plugged in meanwhile; give it to them at the end."""
    probing = DEVICES.parent / "drivers_autoprobe"
    probing.write_text("0")
    try:
        yield
    finally:
        probing.write_text("1")
    for _, bus_id in ports().values():
        if (DEVICES / bus_id).exists():
            (DEVICES.parent / "drivers_probe").write_text(bus_id)


@pytest.mark.whole
@pytest.mark.pulls_cable
@pytest.mark.usefixtures("udev")  # tells libusb of arrivals
def test_sdk_works_on_libusb_too_and_sees_a_knob_come_that_is_no_file_and_go(
    bus: VirtualBus,
) -> None:
    program = subprocess.Popen(
        [sys.executable, "-c", SDK_PROGRAM, LIBUSB, "KNOB-1"],
        env={**os.environ, "LD_PRELOAD": LIBUSB},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert program.stdin is not None
    assert program.stdout is not None
    assert program.stdout.readline() == "watching\n"
    with without_drivers():
        knob = bus.plug("KNOB-1", wait=False)
        arrival = program.stdout.readline().split()
        assert not list(Path("/dev").glob("hidraw*"))
    knob.wait_plugged()
    assert arrival[:2] == ["arrived", knob.serial]
    assert arrival[2].startswith(f"{knob.bus_id}:")
    knob.say("still")
    program.stdin.write("\n")
    program.stdin.flush()
    assert program.stdout.readline() == "closed\n"
    assert knob.hidraw.exists()  # the kernel has its driver back
    program.stdin.write("\n")
    program.stdin.flush()
    assert program.stdout.readline() == "reading\n"
    knob.unplug(wait=False)
    output, _ = program.communicate()
    assert (program.returncode, output) == (0, "disconnected\n")
