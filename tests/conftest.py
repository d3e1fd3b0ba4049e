"""Rules for the whole test suite: nothing is ever skipped, and how long it takes is no result."""

from __future__ import annotations

import signal
from collections.abc import Generator

import hypothesis
import pytest

hypothesis.settings.register_profile("torsio", deadline=None)
hypothesis.settings.load_profile("torsio")


def pytest_configure() -> None:
    """Let programs that the tests start be interrupted.

    What a shell starts in the background is deaf to Ctrl-C, and its children with it.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


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


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Name every test of the firmware's binary: they are what speaks for the device."""
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
