"""The SDK's own C++ tests over a knob that the kernel has.

To start a process with the sanitizers, and to have it look for leaks at its end, takes an emulated
processor as long as a short case does. So one process runs all cases that leave the cable in, and
another one those that pull it. What the kernel logs counts against the first case of each.
"""

from __future__ import annotations

import contextlib
import functools
import io
import os
import re
import subprocess
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.vm.guest.virtual_bus import PROGRAM, TREE

pytestmark = pytest.mark.kernel("6.1")

TESTS = TREE / "build/asan-ubsan/tests/cpp/torsio_attached_tests"
# Time limit of a process, in the guest's time: less than a test's, so that the next need not wait.
LIMIT_S = 800

_WORLD = "tells a world what only the one inside the process can do"
_VIRTUAL = "is about virtual time"
# Tests that cannot run on a knob outside the process, each with its reason.
NOT_OVER_USB = {
    "the emulated knob says who it is": "expects the emulated transport's path",
    "a world that takes longer than it lasts still lets calls in, and closes": _WORLD,
    "a knob that nobody talks to stays armed, because the library gives signs of life": _VIRTUAL,
    "of a report that reaches back behind the begin of its stream the older samples are left out": (
        _VIRTUAL
    ),
    "a named emulated knob keeps what was saved, and only that": "cuts the power in a save",
    "a named emulated knob can be open once, an unnamed one as often as one likes": _WORLD,
    "bad options are InvalidArgument, and leave the name free": "is about the options themselves",
    "a plant and a configuration can be given, and one made to match the other": _WORLD,
    "a selector or serial number that cannot be one is InvalidArgument, and not echoed": (
        "is about the options themselves"
    ),
    "closing twice is fine, and everything after it is Closed": _WORLD,
    "reports that are lost or damaged never hang a call": "damages reports on the way",
    "samples that are lost on the way are counted as gaps": "damages reports on the way",
    "the same seed gives identical telemetry, another one does not": _VIRTUAL,
    "telemetry is the same however calls cut the time": _VIRTUAL,
    "virtual time passes exactly as long as asked, and not in calls that do not wait": _VIRTUAL,
    "record returns every tick of its span, in order, with time and angle that fit": (
        "compares angle and device time from power-up, when the hand of a USB knob starts later"
    ),
    "truth fits telemetry tick by tick": _WORLD,
    "truth without a log is an error that says how to get one": _WORLD,
    "telemetry at 4,000 samples a second loses none, and has room for a dozen answers": (
        "leaves a driver three frames to be late in, and USB/IP's may be later"
    ),
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


# How the cases begin that run in every run, and not with ``./dev test usb`` alone.
IN_EVERY_RUN = (
    *("a knob starts disarmed", "each kind of effect is accepted", "the old scene goes on"),
    *("configuration comes back", "telemetry runs at the rate", "commands in the wrong state"),
    *(
        "calls of several threads on an attached",
        "a watch tells of an attached",
        "an unplug in any",
    ),
)


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
OVER_USB = [case for case in CASES if case not in NOT_OVER_USB]


def pulls_cable(case: str) -> bool:
    return re.search("unplug|departures", case) is not None


def marks(case: str) -> list[pytest.MarkDecorator]:
    pulls = [pytest.mark.pulls_cable] if pulls_cable(case) else []
    return (
        pulls
        if any(case.startswith(begin) for begin in IN_EVERY_RUN)
        else [*pulls, pytest.mark.whole]
    )


@dataclass(frozen=True)
class Run:
    """How a process ended that ran several cases.

    Attributes
    ----------
    problems
        Of each case that came to its end; empty if it passed.
    status
        Of the process: 0 if all passed and the sanitizers have nothing to report.
    output
        What it printed, the sanitizers' reports for example.
    """

    problems: dict[str, str]
    status: int
    output: str


def read_results(text: str) -> dict[str, str]:
    """Return the problem of each case in doctest's XML, empty if it passed.

    Where a crash has cut the text off, the cases before that are returned.
    """
    problems: dict[str, str] = {}
    with contextlib.suppress(ElementTree.ParseError):
        for _, element in ElementTree.iterparse(io.StringIO(text)):
            if element.tag == "TestCase":
                passed = element.find("OverallResultsAsserts[@test_case_success='true']")
                problem = ElementTree.tostring(element, encoding="unicode")
                problems[element.attrib["name"]] = problem if passed is None else ""
    return problems


def run_cases(cases: Sequence[str]) -> Run:
    """Run cases in one process."""
    # Commas separate filters, and a backslash protects one.
    pattern = ",".join(case.replace(",", "\\,") for case in cases)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "results.xml"
        command = [str(TESTS), f"--test-case={pattern}", "--reporters=xml", f"--out={file}"]
        try:
            result = subprocess.run(
                [*command, "--no-skipped-summary"],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                check=False,
                timeout=LIMIT_S,
                env={**os.environ, "TORSIO_VIRTUAL_KNOB": str(PROGRAM)},
            )
            status, output = result.returncode, result.stdout
        except subprocess.TimeoutExpired as late:
            status, output = -1, f"{LIMIT_S} s are over\n{late.stdout!r}"
        text = file.read_text(errors="replace") if file.exists() else ""
    return Run(read_results(text), status, output)


@pytest.fixture(scope="module")
def run_all(request: pytest.FixtureRequest) -> Callable[[bool], Run]:
    """Give what runs, once, all selected cases that pull the cable or all that do not."""
    calls = [getattr(item, "callspec", None) for item in request.session.items]
    selected = [call.params["case"] for call in calls if call and "case" in call.params]

    @functools.cache
    def run(pulls: bool) -> Run:
        cases = [case for case in selected or OVER_USB if pulls_cable(case) == pulls]
        return run_cases(cases)

    return run


def test_list_of_exceptions_has_no_case_that_is_gone() -> None:
    assert set(NOT_OVER_USB) <= set(CASES)


@pytest.mark.parametrize("case", [pytest.param(case, marks=marks(case)) for case in OVER_USB])
def test_cpp(run_all: Callable[[bool], Run], case: str) -> None:
    run = run_all(pulls_cable(case))
    problem = run.problems.get(case)
    if problem is None:
        pytest.fail(f"did not come to its end; status {run.status}\n{run.output}", pytrace=False)
    if problem:
        pytest.fail(f"{problem}\n{run.output}", pytrace=False)


@pytest.mark.parametrize(
    "pulls",
    [False, pytest.param(True, marks=pytest.mark.pulls_cable)],
    ids=["cable stays", "cable is pulled"],
)
def test_cpp_process_ends_well_and_without_a_leak(
    run_all: Callable[[bool], Run], pulls: bool
) -> None:
    run = run_all(pulls)
    if run.status != 0 or not run.problems:
        pytest.fail(f"status {run.status}\n{run.output}", pytrace=False)
