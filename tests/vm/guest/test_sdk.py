"""The SDK's own tests, C++ and Python, over a knob that the kernel has."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterator

import pytest
from _pytest.mark import ParameterSet

from tests.vm.guest.virtual_bus import PROGRAM, TREE

TESTS = TREE / "build/asan-ubsan/tests/cpp/torsio_attached_tests"

_WORLD = "tells a world what only the one inside the process can do"
_VIRTUAL = "is about virtual time"
# What cannot run on a knob outside the process, each with its reason.
NOT_OVER_USB = {
    "the emulated knob says who it is": "expects the emulated transport's path",
    "a named emulated knob keeps what was saved, and only that": "cuts the power in a save",
    "a named emulated knob can be open once, an unnamed one as often as one likes": _WORLD,
    "bad options are InvalidArgument, and leave the name free": "is about the options themselves",
    "a plant and a configuration can be given, and one made to match the other": _WORLD,
    "a selector or serial number that cannot be one is InvalidArgument, and not echoed": (
        "is about the options themselves"
    ),
    "closing twice is fine, and everything after it is Closed": _WORLD,
    "reports that are lost or damaged never hang a call": "damages reports on the way",
    "a device that loses every report makes a call time out in its own time": (
        "damages reports on the way"
    ),
    "samples that are lost on the way are counted as gaps": "damages reports on the way",
    "the same seed gives identical telemetry, another one does not": _VIRTUAL,
    "telemetry is the same however calls cut the time": _VIRTUAL,
    "virtual time passes exactly as long as asked, and not in calls that do not wait": _VIRTUAL,
    "record returns every tick of its span, in order, with time and angle that fit": (
        "compares angle and device time from power-up, when the hand of a USB knob starts later"
    ),
    "truth fits telemetry tick by tick": _WORLD,
    "calls of several threads on a paced knob all get their answers": (
        "gives the world hands without end, each a file here; attached/test_threads.cpp does not"
    ),
    "a paced emulated knob keeps to the wall clock": _WORLD,
    "a paced knob can be interrupted while it waits for an answer that never comes": (
        "damages reports on the way"
    ),
    "a local model for a device that stopped unnoticed is counted as refused": (
        "damages reports on the way"
    ),
}


def cases() -> list[str]:
    """Return the names of the cases, or nothing that could be run if there is no program."""
    if not TESTS.exists():
        pytest.fail(f"{TESTS} is not built; run ./dev test usb", pytrace=False)
    listing = subprocess.run(
        [str(TESTS), "--list-test-cases", "--no-colors"],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "ASAN_OPTIONS": "detect_leaks=0"},
    )
    return [
        line
        for line in listing.stdout.splitlines()
        if line and not line.startswith(("[doctest]", "==="))
    ]


CASES = cases()


def run_case(case: str, **environment: str) -> None:
    # Commas separate filters, and a backslash protects one.
    pattern = case.replace(",", "\\,")
    result = subprocess.run(
        [str(TESTS), f"--test-case={pattern}", "--no-colors"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "TORSIO_VIRTUAL_KNOB": str(PROGRAM), **environment},
    )
    output = result.stdout + result.stderr
    if result.returncode != 0 or not re.search(r"test cases: +1 \| +1 passed", output):
        pytest.fail(output, pytrace=False)


def test_list_of_exceptions_has_no_case_that_is_gone() -> None:
    assert set(NOT_OVER_USB) <= set(CASES)


def over_usb() -> Iterator[ParameterSet]:
    """Give the cases that run here."""
    for case in CASES:
        pulls = re.search("unplug|departures", case) is not None
        if case not in NOT_OVER_USB:
            yield pytest.param(case, marks=[pytest.mark.pulls_cable] if pulls else [])


@pytest.mark.kernel("6.1")
@pytest.mark.parametrize("case", over_usb())
def test_cpp(case: str) -> None:
    run_case(case)
