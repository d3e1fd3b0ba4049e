"""The kernel's own tests of USB devices on the knob; docs/reference/usb.md says why not all."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import torsio
from tests.vm.guest.usbtest import Usbtest, loaded, lying_cable
from tests.vm.guest.virtual_bus import VirtualBus, VirtualKnob

pytestmark = pytest.mark.kernels_own_tests


@pytest.fixture(autouse=True)
def _driver(kernel: str) -> Iterator[None]:
    # As strict as possible: common mistakes of other devices do not pass.
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


# The knob answers a report that it does not know. Nobody reads the answers here, so after two dozen
# it takes no more: a test must write less than that, packet by packet.
MOST_WRITES = 16


def test_control_transfers_and_interrupt_writes(bus: VirtualBus) -> None:
    knob = bus.plug(cable=lying_cable())
    usbtest = Usbtest(knob)
    usbtest.run(0)
    usbtest.run(9, iterations=20)
    usbtest.run(10, iterations=20, sglen=32)
    usbtest.run(25, iterations=MOST_WRITES)
    works(knob)


WRITES: dict[int, dict[str, int]] = {
    1: {"iterations": MOST_WRITES},
    3: {"iterations": 3, "length": 300, "vary": 37},
    5: {"iterations": 2, "sglen": 8},
    7: {"iterations": 1, "length": 200, "vary": 37, "sglen": 4},
    12: {"iterations": 20},
    13: {"iterations": 1},
    17: {"iterations": MOST_WRITES},
    19: {"iterations": MOST_WRITES},
    24: {"iterations": 2, "sglen": 8},
    27: {"iterations": 2, "sglen": 8},
    29: {"iterations": 3},
}


# In every run.
SHORT = {1, 29}


@pytest.mark.parametrize(
    "test",
    [pytest.param(test, marks=[] if test in SHORT else [pytest.mark.whole]) for test in WRITES],
)
def test_writes_that_are_queued_unlinked_halted_and_too_long(bus: VirtualBus, test: int) -> None:
    knob = bus.plug(cable=lying_cable(bulk_out=True))
    Usbtest(knob).run(test, **WRITES[test])
    works(knob)


@pytest.mark.whole
def test_reads_that_are_unlinked(bus: VirtualBus) -> None:
    knob = bus.plug(cable=lying_cable(bulk_in=True), wait=False)
    knob.wait_addressed()
    usbtest = Usbtest(knob)
    usbtest.run(11, iterations=50)
    works(knob)
