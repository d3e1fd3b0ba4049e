"""`torsio.watch` where there is no USB: what it refuses, how it waits, how it ends.

Arrivals and departures are tested in tests/cpp/sdk/test_device_watch.cpp.
"""

from __future__ import annotations

import contextlib
import itertools
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

import torsio
from tests.faults.lines import Injection
from torsio import _torsio

PROGRAM = """
import torsio
watch = torsio.watch()
print("ready", flush=True)
for event in watch:
    pass
"""

KNOB = {
    "path": "/dev/hidraw3",
    "serial": "TS-1",
    "product": "knob",
    "board": "",
    "transport": "hid",
    "problem": "",
}


class FakeWatch:
    """In the place of the extension's class: two events, then the end of the watch."""

    def __init__(self, **_: Any) -> None:
        self._events: Iterator[Any] = iter([("arrived", KNOB), ("departed", KNOB)])
        self._stopped = threading.Event()

    def next(self, timeout_s: float) -> Any:
        event = None if self.is_stopped else next(self._events, None)
        if event is None:
            self._stopped.wait(min(timeout_s, 20.0))
        return event

    def stop(self) -> None:
        self._stopped.set()

    @property
    def is_stopped(self) -> bool:
        return self._stopped.is_set()


@pytest.fixture
def _fake(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_torsio, "DeviceWatch", FakeWatch)


def test_iteration_ends_when_nothing_comes() -> None:
    with torsio.watch(timeout_s=0.01) as watch:
        assert list(watch) == []
        assert not watch.is_stopped
    assert watch.is_stopped
    assert watch.next(timeout_s=60.0) is None  # at once


@pytest.mark.usefixtures("_fake")
def test_events_come_in_order_with_their_device() -> None:
    events = list(torsio.watch(timeout_s=0.01))
    assert [event.kind for event in events] == ["arrived", "departed"]
    assert events[0].device == torsio.ListedDevice(**KNOB)


@pytest.mark.usefixtures("_fake")
def test_callback_gets_each_event_in_another_thread() -> None:
    events, threads, done = [], set(), threading.Event()

    def take(event: torsio.DeviceEvent) -> None:
        events.append(event.kind)
        threads.add(threading.current_thread())
        if len(events) == 2:
            done.set()

    with torsio.watch(take) as watch:
        assert done.wait(20.0)
        with pytest.raises(torsio.Error, match="has a callback"):
            next(iter(watch))
        with pytest.raises(torsio.Error, match="has a callback"):
            watch.next()
    assert events == ["arrived", "departed"]
    assert threading.current_thread() not in threads


@pytest.mark.usefixtures("_fake")
def test_what_a_callback_raises_ends_the_watch_and_stop_raises_it_once() -> None:
    calls = []

    def fail(event: torsio.DeviceEvent) -> None:
        calls.append(event)
        raise ZeroDivisionError

    watch = torsio.watch(fail)
    assert watch._worker is not None
    watch._worker.join()
    assert watch.is_stopped
    with pytest.raises(ZeroDivisionError):
        watch.stop()
    watch.stop()
    assert len(calls) == 1


@pytest.mark.usefixtures("_fake")
def test_stop_waits_for_the_callback_that_runs() -> None:
    begun, done = threading.Event(), threading.Event()

    def take(_: torsio.DeviceEvent) -> None:
        begun.set()
        time.sleep(0.2)
        done.set()

    watch = torsio.watch(take)
    assert begun.wait(20.0)
    watch.stop()
    assert done.is_set()


@pytest.mark.usefixtures("_fake")
def test_stop_waits_for_the_callback_also_after_an_interrupted_stop() -> None:
    for at in itertools.count():
        begun, done = threading.Event(), threading.Event()

        def take(_: torsio.DeviceEvent, begun: Any = begun, done: Any = done) -> None:
            begun.set()
            time.sleep(0.1)
            done.set()

        watch, injection = torsio.watch(take), Injection(at, KeyboardInterrupt)
        assert begun.wait(20.0)
        with contextlib.suppress(KeyboardInterrupt), injection.active():
            watch.stop()
        watch.stop()
        assert done.is_set(), injection.where
        if injection.where is None:
            break


@pytest.mark.usefixtures("_fake")
def test_callback_may_stop_its_watch() -> None:
    made, calls = threading.Event(), []
    watches: list[torsio.DeviceWatch] = []

    def stop(event: torsio.DeviceEvent) -> None:
        calls.append(event)
        made.wait(20.0)
        watches[0].stop()

    watches.append(torsio.watch(stop))
    made.set()
    assert watches[0]._worker is not None
    watches[0]._worker.join()
    assert not watches[0]._worker.runs
    assert len(calls) == 1


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
