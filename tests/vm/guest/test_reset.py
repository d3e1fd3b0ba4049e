"""A port that is reset under a program that uses the knob."""

from __future__ import annotations

import fcntl
import os

import torsio
from tests.vm.guest.virtual_bus import VirtualKnob

_RESET = 0x5514  # USBDEVFS_RESET of linux/usbdevice_fs.h


def reset_port(knob: VirtualKnob) -> None:
    """Have the kernel reset the port and configure the device anew, as it was."""
    numbers = [int((knob.sysfs / name).read_text()) for name in ("busnum", "devnum")]
    file = os.open("/dev/bus/usb/{:03}/{:03}".format(*numbers), os.O_RDWR)
    try:
        fcntl.ioctl(file, _RESET)
    finally:
        os.close(file)


def test_port_reset_leaves_telemetry_running_and_the_knob_armed(knob: VirtualKnob) -> None:
    """The virtual host controller keeps the reset to itself; a board would disarm."""
    device = knob.hidraw
    with torsio.open(knob.serial) as opened:
        opened.arm()
        opened.start_telemetry()
        assert len(opened.read()) > 0
        for _ in range(3):
            reset_port(knob)
            opened.sleep(0.1)
            opened.read()
            assert len(opened.read(timeout_s=5.0)) > 0
            assert opened.state == "armed"
        opened.play(torsio.Constant(torque_nm=0.01))
        assert opened.clock() is not None
    assert knob.hidraw == device
    with torsio.open(knob.serial) as opened:
        assert len(opened.record(duration_s=0.1)) == 100
