"""A transport that is written in Python: a knob over it is as any other."""

from __future__ import annotations

import sys
import threading
from typing import Any

import numpy as np
import pytest

import torsio
from tests.faults.knobs import Device

TICK_NS = 100_000


class Simulated(Device):
    """The emulated device, one tick at a time, in a time of its own."""

    def __init__(self) -> None:
        super().__init__(TICK_NS)
        self.closed = 0
        self.broken: Exception | None = None
        self.cut_to = 64

    def close(self) -> None:
        self.closed += 1

    def write(self, report: bytes) -> bool:
        assert len(report) == 64
        return super().write(report)

    def read(self, timeout_s: float) -> bytes | None:
        assert 0.0 <= timeout_s <= 0.02
        if self.broken is not None:
            raise self.broken
        report = super().read(timeout_s)
        return None if report is None else bytes(report[: self.cut_to])


class Hurrying(Simulated):
    """In real time, where each look takes a millisecond of the device's time, and from threads."""

    time_is_virtual = False

    def __init__(self) -> None:
        super().__init__()
        self.readers: set[int] = set()

    def read(self, timeout_s: float) -> bytes | None:
        self.readers.add(threading.get_ident())
        with self.lock:
            self.device.advance(1_000_000)
            return super().read(timeout_s)

    def now_ns(self) -> int:
        raise AssertionError("real time is not asked for")

    def advance_to(self, time_ns: int) -> None:
        raise AssertionError("nobody can advance real time")


def test_transport_of_real_time_is_read_by_a_thread_of_the_knob() -> None:
    transport = Hurrying()
    with torsio.open(transport) as knob:
        knob.update(watchdog_s=60.0)  # its time runs away from the library's
        knob.play(torsio.Spring(stiffness_nm_per_rad=0.1))
        knob.arm()
        log = knob.record(0.05)
        assert knob.state == "armed"
    assert len(log) > 0
    assert transport.closed == 1
    assert len(transport.readers) == 1
    assert threading.get_ident() not in transport.readers


def test_knob_over_a_transport_of_python_renders_a_spring_and_tells_it() -> None:
    transport = Simulated()
    with torsio.open(transport) as knob:
        with pytest.raises(torsio.Error, match="no emulator"):
            _ = knob.emulator
        assert knob.info.control_rate_hz == 1e9 / TICK_NS
        knob.play(torsio.Constant(torque_nm=0.03))
        knob.update(law="motor_only")
        knob.arm()
        log = knob.record(0.2)
        assert knob.state == "armed"
    assert transport.closed == 1
    assert log["time_s"][-1] - log["time_s"][0] == pytest.approx(0.2, abs=1e-3)
    # 30 mN m less 8 of friction, on 1e-4 kg m^2, from when they are all there.
    late = log[log["time_s"] - log["time_s"][0] > 0.1]
    acceleration = np.polyfit(late["time_s"], late["angle_rad"], 2)[0] * 2
    slowed = 2.8e-5 * float(np.mean(late["speed_rad_s"]))
    assert acceleration == pytest.approx((0.022 - slowed) / 1e-4, rel=0.02)


@pytest.mark.parametrize("is_paced", [False, True])
def test_close_without_room_says_so_once(monkeypatch: pytest.MonkeyPatch, is_paced: bool) -> None:
    said: list[str] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda given: said.append(str(given.exc_value)))
    transport = Hurrying() if is_paced else Simulated()
    with torsio.open(transport) as knob:
        knob.play(torsio.Spring(stiffness_nm_per_rad=0.1))
        knob.arm()
        monkeypatch.setattr(transport, "write", lambda report: False)
        knob.close()
    assert [text[:50] for text in said] == ["the transport took no order, so the knob was not t"]
    assert transport.closed == 1


@pytest.mark.parametrize(
    ("error", "expected", "text"),
    [
        (torsio.Disconnected("the line is down"), torsio.Disconnected, "the line is down"),
        (OSError("no route"), torsio.Disconnected, "OSError: no route"),
    ],
)
def test_what_a_transport_raises_is_told(
    error: Exception, expected: type[Exception], text: str
) -> None:
    transport = Simulated()
    with torsio.open(transport) as knob:
        knob.arm()
        transport.broken = error
        with pytest.raises(expected, match=text):
            knob.record(0.1)
        with pytest.raises(torsio.Disconnected):
            knob.stop()
        assert not transport.is_armed  # the way still takes
    assert transport.closed == 1


class Relaying(Simulated):
    """Uses another knob in the middle of a write, and then the knob behind it."""

    other: torsio.Knob
    behind: torsio.Knob | None = None
    refused = ""

    def write(self, report: bytes) -> bool:
        if self.behind is not None:
            self.other.disarm()
            try:
                _ = self.behind.state
            except torsio.Error as error:
                self.refused = str(error)
        return super().write(report)


def test_knob_behind_is_refused_also_after_another_knob_was_used() -> None:
    transport = Relaying()
    with torsio.open(Simulated()) as transport.other, torsio.open(transport) as knob:
        transport.behind = knob
        knob.disarm()
        transport.behind = None
    assert "cannot use the knob behind it" in transport.refused


def test_report_of_another_size_is_refused_in_a_sentence() -> None:
    transport = Simulated()
    with torsio.open(transport) as knob:
        transport.cut_to = 12
        with pytest.raises(torsio.Disconnected, match="a report of 12 bytes; every report has 64"):
            knob.record(0.1)


def test_what_is_neither_a_selector_nor_a_transport_is_refused() -> None:
    nothing: Any = object()
    with pytest.raises(TypeError, match="selector"):
        torsio.open(nothing)
