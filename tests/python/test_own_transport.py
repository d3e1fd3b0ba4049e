"""A transport that is written in Python: a knob over it is as any other."""

from __future__ import annotations

import sys
import threading
from typing import Any

import numpy as np
import pytest

import torsio
from tests.faults.knobs import Device
from torsio import protocol

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


class Speechless(OSError):
    """Has no text."""

    def __str__(self) -> str:
        raise ValueError("no text")


@pytest.mark.parametrize(
    ("error", "expected", "text"),
    [
        (torsio.Disconnected("the line is down"), torsio.Disconnected, "the line is down"),
        (OSError("no route"), torsio.Disconnected, "OSError: no route"),
        (OSError("no \udcff"), torsio.Disconnected, r"OSError: no \\udcff"),
        (Speechless(), torsio.Disconnected, "Speechless: it does not say what"),
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


class Lying(Simulated):
    """Its next acknowledgement says that a game has the knob."""

    lies = False

    def read(self, timeout_s: float) -> bytes | None:
        report = super().read(timeout_s)
        name, values = protocol.decode(report) if report is not None else ("", {})
        if not self.lies or report is None or name != "acknowledgement":
            return report
        self.lies = False
        del values["sequence"]
        true, false = (protocol.encode(name, {**values, "owner": who}) for who in ("sdk", "game"))
        return bytes(b if a != b else c for a, b, c in zip(true, false, report, strict=True))


@pytest.mark.parametrize("order", ["arm", "keep"])
def test_close_disarms_though_one_report_says_that_a_game_has_the_knob(order: str) -> None:
    transport = Lying()
    knob = torsio.open(transport)
    knob.update(watchdog_s=60.0)
    transport.lies = order == "arm"
    knob.arm()
    if order == "keep":
        transport.lies = True
        knob.play(torsio.Spring(stiffness_nm_per_rad=0.01))
    assert not transport.lies
    assert transport.is_armed
    knob.close()
    assert not transport.is_armed


class Autonomous(Simulated):
    """Takes a configuration, and then gives none."""

    fails = fails_next = False

    def get_feature(self, report_id: int) -> bytes | None:
        if self.fails:
            raise OSError("not now")
        return super().get_feature(report_id)

    def set_feature(self, report: bytes) -> bool:
        self.fails = self.fails_next
        return super().set_feature(report)


@pytest.mark.parametrize("change", ["load_defaults", "update"])
def test_close_disarms_a_knob_that_may_be_autonomous_no_more(change: str) -> None:
    transport = Autonomous()
    knob = torsio.open(transport)
    knob.update(autonomous=True, watchdog_s=60.0)
    transport.fails_next = True
    transport.fails = change == "load_defaults"  # which is no feature report
    call: Any = {
        "load_defaults": knob.load_defaults,
        "update": lambda: knob.update(autonomous=False),
    }[change]
    with pytest.raises(torsio.Error, match="not now"):
        call()
    transport.fails = transport.fails_next = False
    assert transport.config("control")["autonomous"] == "off"
    knob.arm()
    assert transport.is_armed
    knob.close()
    assert not transport.is_armed


def test_autonomous_knob_stays_so_when_another_configuration_is_refused() -> None:
    transport = Simulated()
    knob = torsio.open(transport)
    knob.update(autonomous=True)
    knob.arm()
    with pytest.raises(torsio.Refused):
        knob.update(autonomous=False)  # armed
    knob.close()
    assert transport.is_armed


class Early(Simulated):
    """Its clock begins before zero."""

    def now_ns(self) -> int:
        return super().now_ns() - 10**12

    def advance_to(self, time_ns: int) -> None:
        super().advance_to(time_ns + 10**12)


def test_clock_may_begin_before_zero() -> None:
    with torsio.open(Early()) as knob:
        knob.sleep(0.01)
        assert len(knob.record(0.1)) > 50


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
