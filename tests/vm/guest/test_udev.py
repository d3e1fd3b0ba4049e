"""The udev rule, installed by ``./dev udev``, with the real udev and a knob that the kernel has."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from tests.vm.guest.udev import RULE, run
from tests.vm.guest.virtual_bus import TREE, VirtualBus, VirtualKnob
from torsio.apps.doctor import facts as doctor_facts


def tags(device: Path) -> set[str]:
    """Return the tags that udev has given a device in /sys."""
    properties = run("udevadm", "info", "--query=property", f"--path={device}").splitlines()
    found = dict(line.partition("=")[::2] for line in properties)
    return set(filter(None, found.get("CURRENT_TAGS", "").split(":")))


def nodes(knob: VirtualKnob) -> dict[Path, Path]:
    """Return what the rule is about: devices in /sys and their files."""
    numbers = [int((knob.sysfs / name).read_text()) for name in ("busnum", "devnum")]
    return {
        Path("/sys/class/hidraw", knob.hidraw.name).resolve(): knob.hidraw,
        knob.sysfs.resolve(): Path("/dev/bus/usb", *(f"{number:03}" for number in numbers)),
    }


@pytest.mark.kernel("6.12")
@pytest.mark.usefixtures("udev")
def test_rule_hands_the_knob_to_the_seat_and_to_nobody_else(bus: VirtualBus) -> None:
    early = bus.plug("EARLY")
    run("udevadm", "settle")
    for device in nodes(early):
        assert "uaccess" not in tags(device)
    assert doctor_facts.find_permission().rule == ""

    run(TREE / "dev", "udev")
    late = bus.plug("LATE")
    run("udevadm", "settle")
    # One was plugged in when the rule came, the other came after it.
    for knob in (early, late):
        for device, file in nodes(knob).items():
            assert "uaccess" in tags(device), file
            assert stat.S_IMODE(file.stat().st_mode) & stat.S_IWOTH == 0
    [hidraw, _] = nodes(late)
    assert str(RULE) in run("udevadm", "test", hidraw)
    permission = doctor_facts.find_permission()
    assert (permission.rule, permission.udev_runs) == (str(RULE), True)

    run(TREE / "dev", "udev", "--remove")
    for device in nodes(early):
        assert "uaccess" not in tags(device)
