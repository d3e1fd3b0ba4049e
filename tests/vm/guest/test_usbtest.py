"""The kernel's own tests of USB devices on the knob; docs/usb.md says which, and why not others."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import torsio
from tests.vm.guest.usbtest import Usbtest, loaded, lying_cable
from tests.vm.guest.virtual_bus import VirtualBus, VirtualKnob

pytestmark = pytest.mark.kernels_own_tests


@pytest.fixture(autouse=True)
def _driver(kernel: str) -> Iterator[None]:
    # As strict as it can be: what devices of this world do wrong is not let pass.
    with loaded(kernel, {"realworld": 0}):
        yield


def works(knob: VirtualKnob) -> None:
    """Use a knob that has been through it, on a cable that does not lie."""
    knob.unplug()
    knob.plug()
    with torsio.open(knob.serial) as opened:
        opened.arm()
        opened.play(torsio.Constant(torque_nm=0.01))
        assert len(opened.record(duration_s=0.1)) == 100


def test_control_transfers_and_interrupt_writes(bus: VirtualBus) -> None:
    knob = bus.plug(cable=lying_cable())
    usbtest = Usbtest(knob)
    usbtest.run(0)
    usbtest.run(9, iterations=20)
    usbtest.run(10, iterations=20, sglen=32)
    usbtest.run(25, iterations=100)
    works(knob)


def test_writes_that_are_queued_unlinked_halted_and_too_long(bus: VirtualBus) -> None:
    knob = bus.plug(cable=lying_cable(bulk_out=True))
    usbtest = Usbtest(knob)
    usbtest.run(1, iterations=100)
    usbtest.run(3, iterations=100, length=500, vary=37)
    usbtest.run(5, iterations=5, sglen=16)
    usbtest.run(7, iterations=5, length=500, vary=37, sglen=16)
    usbtest.run(12, iterations=30)
    usbtest.run(13, iterations=10)
    usbtest.run(17, iterations=20)
    usbtest.run(19, iterations=20)
    usbtest.run(24, iterations=10, sglen=8)
    usbtest.run(27, iterations=5, sglen=16)
    usbtest.run(29, iterations=10)
    works(knob)


def test_reads_that_are_unlinked(bus: VirtualBus) -> None:
    knob = bus.plug(cable=lying_cable(bulk_in=True), wait=False)
    knob.wait_addressed()
    usbtest = Usbtest(knob)
    usbtest.run(11, iterations=50)
    works(knob)
