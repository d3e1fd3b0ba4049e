"""Rules for the whole test suite: nothing is ever skipped, and how long it takes is no result."""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

import hypothesis
import pytest

from tests.vm.guests import GUEST_VARIABLE
from tools.dev import building, groups, plans

hypothesis.settings.register_profile("torsio", deadline=None)
hypothesis.settings.load_profile("torsio")


TREE = Path(__file__).parent.parent


def pytest_configure(config: pytest.Config) -> None:
    """Let programs that the tests start be interrupted.

    A program that a shell starts in the background ignores Ctrl-C, and so do its children.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    config.addinivalue_line("markers", "slow: runs with `./dev test slow` alone")
    config.addinivalue_line("markers", "pages: holds a page's figures; runs where both boards do")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Run what is marked as slow when that is asked for, and then nothing else."""
    wanted = groups.SLOW_VARIABLE in os.environ
    left = [item for item in items if (item.get_closest_marker("slow") is not None) != wanted]
    if building.EVERY_BOARD_VARIABLE not in os.environ:
        left += [item for item in items if item.get_closest_marker("pages")]
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item in items if item not in left]
    # The first one waits for a machine that runs as long as all other tests: a worker begins with
    # it. Each has an equal share of the tests at first, one after another.
    guests = [item for item in items if item.path == TREE / "tests/vm/test_guest.py"]
    others = [item for item in items if item not in guests]
    share = len(items) // int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    begin = max(0, len(others) - max(0, share - len(guests)))
    items[:] = [*others[:begin], *guests, *others[begin:]]


# Files of the tree that the running test has opened.
OPENED: set[str] = set()


def _note(event: str, arguments: tuple[object, ...]) -> None:
    if event == "open" and isinstance(arguments[0], str) and arguments[0].startswith(f"{TREE}/"):
        OPENED.add(arguments[0])


if GUEST_VARIABLE not in os.environ:
    sys.addaudithook(_note)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup() -> None:
    OPENED.clear()


@pytest.fixture(autouse=True)
def _opens_what_its_group_covers(request: pytest.FixtureRequest) -> Iterator[None]:
    """Fail a test that reads a file whose change would not have it run."""
    yield
    opened = [str(Path(path).relative_to(TREE)) for path in OPENED.copy()]  # threads add to it
    test = request.node.nodeid
    chosen = getattr(request.config, "workerinput", {}).get("groups", RUN)
    assert groups.not_covered(test, opened, chosen) == [], (
        "tools/dev/groups.py lacks it for this test"
    )


# Not for the programs and the pytest processes that tests start.
RUN = json.loads(os.environ.pop(groups.RUN_VARIABLE, "{}"))


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Tell a worker of pytest-xdist too."""
    node.workerinput["groups"] = list(RUN)


def _fail_instead_of_skip(report: pytest.TestReport | pytest.CollectReport) -> None:
    # An expected failure (xfail) is reported as skipped too, but it did run.
    if report.outcome == "skipped" and not hasattr(report, "wasxfail"):
        report.outcome = "failed"
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
        report.longrepr = f"{reason}\nA skipped test proves nothing, so here it counts as failed."


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    _fail_instead_of_skip(report)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    report = yield
    _fail_instead_of_skip(report)
    return report


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, exitstatus: pytest.ExitCode
) -> None:
    """Sum up each group, name every test of the firmware's binary, and remember what passed."""
    terminalreporter.section("groups of tests, and the seconds of all workers")
    for line in groups.sums(terminalreporter.stats, chosen=RUN):
        terminalreporter.line(line)
    if exitstatus in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        stats = terminalreporter.stats
        bad = [report for outcome in ("failed", "error") for report in stats.get(outcome, [])]
        plans.remember(RUN, [report.nodeid for report in bad])
    lines = [
        f"{outcome} {report.nodeid}"
        for outcome in ("passed", "failed", "error")
        for report in terminalreporter.stats.get(outcome, [])
        if report.nodeid.startswith("tests/board/")
    ]
    if lines:
        terminalreporter.section("the firmware in the emulated board")
        for line in sorted(lines):
            terminalreporter.line(line)
