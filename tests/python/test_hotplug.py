"""`torsio.watch` where there is no USB: what it refuses, how it waits, how it ends.

Arrivals and departures are tested in tests/cpp/sdk/test_device_watch.cpp.
"""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from typing import Any

import pytest

import torsio

PROGRAM = """
import torsio
watch = torsio.watch()
print("ready", flush=True)
for event in watch:
    pass
"""


def test_iteration_ends_when_nothing_comes() -> None:
    with torsio.watch(timeout_s=0.01) as watch:
        assert list(watch) == []
        assert not watch.is_stopped
    assert watch.is_stopped
    assert watch.next(timeout_s=60.0) is None  # at once


def test_another_thread_runs_while_one_waits_and_may_stop_it() -> None:
    watch = torsio.watch()
    stopper = threading.Timer(0.1, watch.stop)
    stopper.start()
    assert list(watch) == []
    stopper.join()


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({"timeout_s": -1.0}, torsio.InvalidArgument),
        ({"timeout_s": float("nan")}, torsio.InvalidArgument),
        ({"timeout_s": "soon"}, TypeError),
        ({"permission_timeout_s": 61.0}, torsio.InvalidArgument),
        ({"include_present": 1}, TypeError),
        ({"callback": 3}, TypeError),
    ],
)
def test_bad_argument_is_refused_by_name(arguments: dict[str, Any], error: type[Exception]) -> None:
    with pytest.raises(error, match=next(iter(arguments))):
        torsio.watch(**arguments)


def test_interrupt_ends_a_waiting_iteration_at_once() -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=20)
    finally:
        process.kill()
    assert "KeyboardInterrupt" in errors
    assert process.returncode == -signal.SIGINT
