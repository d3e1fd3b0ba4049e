"""The short form of ``./dev faults``."""

from __future__ import annotations

import pytest

from tests.faults import cables, calls, faults

CALLS_EVERY = {"note": 1, "record_to": 61}  # not divided by the kinds, nor is 7


@pytest.mark.parametrize("recorded", [False, True])
@pytest.mark.parametrize("call", calls.CALLS)
def test_failure_at_a_line_leaves_nothing_armed_and_nothing_lost(call: str, recorded: bool) -> None:
    lines = calls.lines_of(call, paced=False, recorded=recorded)
    for at in range(0, lines, CALLS_EVERY.get(call, 7)):
        kinds = calls.kinds_of(call)
        kind = kinds[at % len(kinds)]
        wrong, injection = calls.trial(call, at, kind, paced=False, recorded=recorded)
        assert wrong == "", (kind.__name__, injection.where)


def test_interrupted_close_of_a_paced_knob_leaves_nothing_armed() -> None:
    for at in range(0, calls.lines_of("close", paced=True, recorded=True), 11):
        wrong, injection = calls.trial("close", at, KeyboardInterrupt, paced=True, recorded=True)
        assert wrong == "", injection.where


def test_calibration_that_ends_early_puts_the_configuration_back() -> None:
    _, counted = calls.interrupt_calibration(None, KeyboardInterrupt)
    for share in (0.05, 0.5, 0.999):
        at = int(share * counted.lines)
        assert calls.interrupt_calibration(at, KeyboardInterrupt)[0] == ""


# Python closes the file when an exception comes before the thread does.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_thread_of_a_file_that_fails_is_told_or_has_lost_nothing() -> None:
    outcomes = list(faults.of_thread(every=499))
    assert [outcome for outcome in outcomes if outcome[2]] == []
    assert {kind for _, kind, *_ in outcomes} == {"MemoryError", "OSError"}


def test_transport_that_fails_leaves_nothing_armed_and_hangs_nothing() -> None:
    outcomes = [*cables.once(every=2), *cables.lasting(every=5)]
    assert [outcome for outcome in outcomes if outcome[2]] == []


def test_file_operation_that_fails_once_is_told_and_loses_nothing() -> None:
    names = ("recording", "configuration file", "table", "trade's results", "firmware update")
    outcomes = list(faults.of_files(3, *names))
    assert {call for call, *_ in outcomes} == set(names)
    assert [outcome for outcome in outcomes if outcome[2]] == []


def test_allocation_that_fails_once_ends_the_example_in_c_with_a_sentence() -> None:
    outcomes = list(faults.of_allocations(every=9))
    assert [outcome for outcome in outcomes if outcome[2]] == []
    assert any("no wall" in where or "torsio_" in where for *_, where in outcomes)


def test_update_that_ends_early_is_told() -> None:
    for at in range(0, 400, 7):
        wrong, injection = calls.interrupt_update(at, KeyboardInterrupt)
        assert wrong == ""
        if injection.where is None:  # it has no more lines; how many, depends on Python
            break
    assert at > 150
