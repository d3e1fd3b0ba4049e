"""Cables that are pulled, and put back."""

from __future__ import annotations

import os
import threading
import time
from typing import TextIO

import pytest

import torsio
from tests.endurance import unplugs
from tests.vm.guest.child import Child, become_nobody
from tests.vm.guest.virtual_bus import VirtualBus, VirtualKnob

pytestmark = pytest.mark.pulls_cable


def idle(knob: torsio.Knob) -> None:
    while knob.state != "disconnected":
        time.sleep(0.01)
    knob.arm()


STATES = unplugs.STATES | {"idle": idle}


# `test_many_unplugs_in_every_state` is in the others.
@pytest.mark.parametrize("state", ["idle", "asking", "reading", "streaming"])
def test_unplug_is_disconnected_within_a_second(knob: VirtualKnob, state: str) -> None:
    files = len(os.listdir("/proc/self/fd"))
    with torsio.open(knob.serial) as opened:
        opened.arm()
        pulled = []

        def pull() -> None:
            pulled.append(time.monotonic())
            knob.unplug(wait=False)

        timer = threading.Timer(0.3, pull)
        timer.start()
        with pytest.raises(torsio.Disconnected, match="open it again"):
            STATES[state](opened)
        late_s = time.monotonic() - pulled[0]
        timer.join()
        in_request = state == "asking"
        assert late_s < (unplugs.LATEST_IN_REQUEST_S if in_request else unplugs.LATEST_S)
        assert opened.state == "disconnected"
        with pytest.raises(torsio.Disconnected):
            opened.arm()
    knob.wait_unplugged()
    assert len(os.listdir("/proc/self/fd")) == files


def test_knob_that_comes_back_is_opened_by_its_serial_number(bus: VirtualBus) -> None:
    bus.plug("OTHER")
    knob = bus.plug("MINE")
    for _ in range(3):
        with torsio.open("MINE") as opened:
            opened.arm()
            knob.unplug()
            with pytest.raises(torsio.Disconnected):
                opened.arm()
        with pytest.raises(torsio.DeviceNotFound, match="MINE"):
            torsio.open("MINE")
        knob.plug()
    with torsio.open("MINE") as opened:
        assert opened.state == "disarmed"
        assert opened.info.serial == "MINE"


@pytest.mark.whole
def test_knob_that_is_unplugged_while_it_is_opened_is_an_error(knob: VirtualKnob) -> None:
    told = set()
    # The first program that opens a hidraw device waits for 50 ms in the kernel.
    for step in range(16):
        path = str(knob.hidraw)

        def work(output: TextIO, path: str = path) -> None:
            try:
                torsio.open(path).close()
            except torsio.Error as error:
                output.write(type(error).__name__)

        child = Child(work)
        time.sleep(0.005 * step)
        knob.unplug()
        told.add(child.end())
        knob.plug()
    assert "DeviceNotFound" in told
    assert told <= {"", "DeviceNotFound", "Disconnected", "Timeout"}


@pytest.mark.kernel("6.12")
@pytest.mark.parametrize("cycles", [5, pytest.param(200, marks=pytest.mark.whole)])
def test_many_plug_cycles(knob: VirtualKnob, cycles: int) -> None:
    for _ in range(cycles):
        knob.unplug()
        knob.plug()
    assert [device.serial for device in torsio.list_devices()] == [knob.serial, "EMULATED"]
    torsio.open(knob.serial).close()


def test_knob_without_permission_says_what_to_do(knob: VirtualKnob) -> None:
    def work(output: TextIO) -> None:
        become_nobody()
        try:
            torsio.open(str(knob.hidraw))
        except torsio.Error as error:
            output.write(f"{type(error).__name__}: {error}")

    message = Child(work).end()
    assert message.startswith("PermissionDenied: no permission to open /dev/hidraw")
    assert "60-torsio.rules" in message
