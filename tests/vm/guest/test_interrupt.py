"""Ctrl-C and sudden death of a program that uses a knob which the kernel has."""

from __future__ import annotations

import time
from typing import TextIO

import pytest

import torsio
from tests.python.test_interrupt import CALLS
from tests.vm.guest.child import Child
from tests.vm.guest.virtual_bus import VirtualKnob

pytestmark = pytest.mark.kernel("6.12")

# These are about the device inside the process.
NOT_OVER_USB = {"advance", "unpaced", "opening"}
SHORT = ("read",)  # in every run


def open_armed(serial: str) -> torsio.Knob:
    opened = torsio.open(serial)
    opened.play(torsio.Wall(stiffness_nm_per_rad=1.0))
    opened.arm()
    return opened


@pytest.mark.parametrize(
    "call",
    [
        pytest.param(call, marks=[] if call in SHORT else [pytest.mark.whole])
        for call in CALLS
        if call not in NOT_OVER_USB
    ],
)
def test_interrupt_ends_call_at_once_and_disarms(knob: VirtualKnob, call: str) -> None:
    def work(output: TextIO) -> None:
        with open_armed(knob.serial) as opened:
            output.write("ready\n")
            try:
                eval(CALLS[call], {"knob": opened, "torsio": torsio})
            except KeyboardInterrupt:
                output.write(f"interrupted {opened.state}\n")

    child = Child(work)
    assert child.output.readline() == "ready\n"
    time.sleep(0.3)
    begin = time.monotonic()
    child.interrupt()
    assert child.end() == "interrupted armed\n"
    assert time.monotonic() - begin < 1.0
    with torsio.open(knob.serial) as opened:
        assert opened.state == "disarmed"


def test_killed_program_leaves_the_knob_to_its_watchdog(knob: VirtualKnob) -> None:
    def work(output: TextIO) -> None:
        with open_armed(knob.serial) as opened:
            output.write(f"{opened.state}\n")
            opened.sleep(60.0)

    child = Child(work)
    assert child.output.readline() == "armed\n"
    child.kill()
    time.sleep(0.5)  # watchdog_s is 0.25
    with torsio.open(knob.serial) as opened:
        assert opened.state == "disarmed"
