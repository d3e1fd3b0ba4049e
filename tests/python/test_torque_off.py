"""Whatever fails, the torque goes off, and what was recorded is kept."""

from __future__ import annotations

import gc
import os
import signal
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import torsio
from tests.faults.knobs import Device, device
from tests.python.processes import python
from tests.python.test_disk_full import full_disk
from torsio.calibration import calibrate
from torsio.recordings.writing import wait_for_all

FULL = r"large|space"
SPRING = torsio.Spring(stiffness_nm_per_rad=0.01)


@pytest.fixture(params=[False, True], ids=["virtual", "paced"])
def armed(request: pytest.FixtureRequest) -> Iterator[tuple[Device, torsio.Knob]]:
    made = device(paced=request.param)
    knob = torsio.open(made)
    knob.update(watchdog_s=60.0)
    knob.play(SPRING)
    knob.arm()
    yield made, knob
    knob.close()


def fill(knob: torsio.Knob, recording: torsio.RecordingFile) -> OSError:
    """Record onto a full disk until that is told."""

    def go_on() -> None:
        for number in range(10**6):
            knob.sleep(0.05)
            recording.note("mark", number=number, text=os.urandom(512).hex())

    with pytest.raises(OSError, match=FULL) as told:
        go_on()
    return told.value


def test_full_disk_is_told_once_and_the_torque_goes_off(
    armed: tuple[Device, torsio.Knob], tmp_path: Path
) -> None:
    made, knob = armed
    with full_disk(), knob.record_to(tmp_path / "x.mcap") as recording:
        told = fill(knob, recording)
        assert told.filename == str(tmp_path / "x.mcap")
        assert not recording.is_open
        knob.disarm()
        assert not made.is_armed
        knob.arm()
        knob.stop()
        knob.play(SPRING)
        knob.arm()
        assert len(knob.record(0.02)) > 0
        knob.close()
    assert not made.is_armed
    assert made.is_closed
    assert not torsio.load(tmp_path / "x.mcap").whole


def fill_a_little(recording: torsio.RecordingFile) -> None:
    """Note more than the disk has room for, and less than what is written at once."""
    for number in range(50):
        recording.note("mark", number=number, text=os.urandom(512).hex())


def test_samples_outlive_a_full_disk_and_a_warning_that_is_an_error(
    armed: tuple[Device, torsio.Knob], tmp_path: Path
) -> None:
    _, knob = armed
    path = tmp_path / "x.mcap"
    with knob.record_to(path):
        knob.disarm()
        knob.arm()
        knob.stream_local_model(torque_nm=0.0, deadline_s=0.01)  # missed, so it disarms
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with pytest.raises(torsio.DisarmedWarning) as caught:
                knob.record(0.1)
    samples = caught.value.samples  # type: ignore[attr-defined]
    assert len(samples) > 0
    in_file = torsio.load(path).telemetry
    assert np.isin(samples["tick"], in_file["tick"]).all()
    takes: tuple[Callable[[], object], ...] = (
        lambda: knob.record(0.05),
        knob.read,
        lambda: next(knob.telemetry(0.05)),
    )
    for take in takes:
        with full_disk(), knob.record_to(tmp_path / "full.mcap") as recording:
            fill_a_little(recording)
            recording.put(lambda _: recording.writer._mcap.flush(), [None])
            while recording.is_open:
                pass
            with pytest.raises(OSError, match=FULL) as told:
                take()
        assert len(told.value.samples) > 0  # type: ignore[attr-defined]


def test_interrupt_that_a_program_catches_costs_no_sample(tmp_path: Path) -> None:
    is_catching = False

    def interrupt(_: int, __: object) -> None:
        if is_catching:
            raise KeyboardInterrupt

    path = tmp_path / "x.mcap"
    interrupts, stop = 0, threading.Event()
    pester = threading.Thread(target=_pester, args=(stop,))
    before = signal.signal(signal.SIGUSR1, interrupt)
    try:
        with torsio.open(device(paced=True)) as knob, knob.record_to(path) as recording:
            pester.start()
            while interrupts < 100:
                try:
                    is_catching = True
                    knob.record(0.01)
                    knob.read(timeout_s=0.0)
                    recording.note("mark", number=interrupts)
                    is_catching = False
                except KeyboardInterrupt:
                    is_catching = False
                    interrupts += 1
            newest = int(knob.latest()["tick"])
    finally:
        stop.set()
        pester.join()
        signal.signal(signal.SIGUSR1, before)
    loaded = torsio.load(path)
    ticks = loaded.telemetry["tick"].astype(np.int64)
    assert loaded.whole
    assert ticks[-1] >= newest
    assert set(np.diff(ticks)) == {1}
    assert recording.samples == len(ticks)


def _pester(stop: threading.Event) -> None:
    while not stop.wait(0.003):
        os.kill(os.getpid(), signal.SIGUSR1)


def test_knob_can_be_armed_again_after_an_exception_has_left_a_recording(tmp_path: Path) -> None:
    with torsio.open("emulated") as knob:
        knob.arm()
        with pytest.raises(ValueError, match="mine"), knob.record_to(tmp_path / "x.mcap"):
            raise ValueError("mine")
        assert knob.health().state == "disarmed"
        knob.arm()
        assert knob.state == "armed"


def test_interrupted_close_of_a_recording_can_be_repeated(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with torsio.open("emulated") as knob:
        recording = knob.record_to(path)
        knob.sleep(0.1)

        def interrupt() -> None:
            del knob._recording.take_rest
            raise KeyboardInterrupt

        knob._recording.take_rest = interrupt  # type: ignore[method-assign]
        with pytest.raises(KeyboardInterrupt):
            recording.close()
        recording.close()
        assert torsio.load(path).whole
        with knob.record_to(path):
            pass


@pytest.mark.parametrize("is_left_early", [False, True])
def test_interrupt_ends_the_wait_for_a_file_and_the_torque_of_all_knobs(
    is_left_early: bool, tmp_path: Path
) -> None:
    made, path, disk = [device(paced=True), device(paced=True)], tmp_path / "x.mcap", []
    armed: list[bool] = []

    def interrupt() -> None:
        armed.extend(one.is_armed for one in made)
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)

    def block(_: object) -> None:
        written.wait()

    def use() -> None:
        with torsio.open(made[0]) as outer, torsio.open(made[1]) as inner:
            for knob in (outer, inner):
                knob.update(watchdog_s=60.0)
                knob.arm()
            with inner.record_to(path) as recording:
                disk.append(recording)
                recording.put(block, [None])
                interrupts.start()
                if is_left_early:
                    raise MemoryError

    written, interrupts = threading.Event(), threading.Timer(1.0, interrupt)
    with pytest.raises(KeyboardInterrupt):
        use()
    assert armed == [True, not is_left_early]
    assert not any(one.is_armed for one in made)
    assert all(one.is_closed for one in made)
    assert not written.is_set()
    written.set()
    disk[0].close()
    assert torsio.load(path).whole


HANDLERS: dict[str, Callable[[torsio.Knob], None]] = {
    "stop": torsio.Knob.stop,
    "disarm": torsio.Knob.disarm,
    "close": torsio.Knob.close,
}
BUSY: dict[str, Callable[[torsio.Knob, torsio.RecordingFile], object]] = {
    "notes": lambda _, recording: recording.note("mark", text="x" * 4096),
    "play": lambda knob, _: knob.play(SPRING),
    "read": lambda knob, _: knob.read(timeout_s=0.0),
    "closing": lambda _, recording: recording.close(),
}


@pytest.mark.parametrize("paced", [False, True])
@pytest.mark.parametrize("what", BUSY)
@pytest.mark.parametrize("handler", HANDLERS)
def test_handler_of_a_signal_may_end_the_torque_at_any_moment(
    handler: str, what: str, paced: bool, tmp_path: Path
) -> None:
    states: list[str] = []
    handled = threading.Event()

    def handle(_: int, __: object) -> None:
        try:
            HANDLERS[handler](knob)
        finally:
            handled.set()

    before = signal.signal(signal.SIGALRM, handle)
    try:
        for number, delay_s in enumerate((1e-4, 1e-3, 5e-3)):
            knob = torsio.open("emulated", emulator=torsio.EmulatorOptions(paced=paced))
            knob.on_event(lambda event: states.append(event.state))
            knob.arm()
            with knob, knob.record_to(tmp_path / f"{number}.mcap") as recording:
                handled.clear()
                signal.setitimer(signal.ITIMER_REAL, delay_s)
                while not handled.is_set():
                    with suppress(torsio.Closed, torsio.Refused):
                        BUSY[what](knob, recording)
                assert not knob.is_open or knob.health().state == "disarmed"
            assert states[-1] == "disarmed"
            assert torsio.load(tmp_path / f"{number}.mcap").whole
    finally:
        signal.signal(signal.SIGALRM, before)


def test_handler_of_a_signal_in_a_transport_is_told_that_it_cannot_use_the_knob() -> None:
    made = Device()
    with torsio.open(made) as knob:
        knob.arm()
        made.advance_to = lambda time_ns: knob.stop()  # type: ignore[method-assign]
        with pytest.raises(torsio.Error, match="cannot use the knob"):
            knob.sleep(0.1)
        del made.advance_to
    assert not made.is_armed


def test_transport_whose_close_closes_the_knob_is_told_that_it_cannot() -> None:
    made = Device()

    def close() -> None:
        with pytest.raises(torsio.Error, match="cannot use the knob"):
            knob.close()
        made.is_closed = True

    made.close = close  # type: ignore[method-assign]
    with torsio.open(made) as knob:
        knob.arm()
    assert made.is_closed
    assert not knob.is_open


AT_END = """
import sys, torsio
from tests.faults.knobs import Device, PacedDevice
from tests.python.test_disk_full import full_disk
made = [Device(), PacedDevice(), Device()]
knobs = [torsio.open(one) for one in made]
for knob in knobs:
    knob.update(watchdog_s=60.0)
    knob.arm()
import atexit
def look():
    print([one.is_armed for one in made], [one.is_closed for one in made])
full = full_disk()
full.__enter__()
recordings = [knob.record_to(f"{sys.argv[1]}/{n}.mcap") for n, knob in enumerate(knobs)]
from tests.python.test_torque_off import fill_a_little
for recording in recordings:
    fill_a_little(recording)
import torsio.knob
atexit.unregister(torsio.knob.knob._close_all)
atexit.register(look)
atexit.register(torsio.knob.knob._close_all)
"""


def test_every_knob_is_closed_when_python_ends_though_one_cannot_tell_its_file(
    tmp_path: Path,
) -> None:
    ended = python(AT_END, tmp_path)
    assert ended.stdout == "[False, False, False] [True, True, True]\n", ended.stderr
    assert ended.returncode == 0
    assert "large" in ended.stderr or "space" in ended.stderr


AT_END_OF_A_FILE_THAT_HANGS = """
import os, sys, threading, time, torsio
from tests.faults.knobs import PacedDevice
made = [PacedDevice(), PacedDevice()]
knobs = [torsio.open(one) for one in made]
for knob in knobs:
    knob.update(watchdog_s=60.0)
    knob.arm()
def look():
    while not all(one.is_closed for one in made[1:]) or any(one.is_armed for one in made):
        time.sleep(0.01)
    print("disarmed", flush=True)
    os._exit(0)
recording = knobs[0].record_to(sys.argv[1] + "/x.mcap")
recording.put(lambda _: threading.Event().wait(), [None])
threading.Thread(target=look, daemon=True).start()
"""


def test_end_of_python_disarms_all_knobs_before_it_waits_for_a_file(tmp_path: Path) -> None:
    ended = python(AT_END_OF_A_FILE_THAT_HANGS, tmp_path)
    assert (ended.stdout, ended.stderr) == ("disarmed\n", "")


@pytest.mark.parametrize("in_cycle", [False, True])
def test_dropped_knob_that_is_recorded_disarms_and_its_file_ends(
    in_cycle: bool, tmp_path: Path
) -> None:
    made, path = device(paced=True), tmp_path / "x.mcap"

    def drop() -> None:
        knob = torsio.open(made)
        if in_cycle:
            cycle: list[object] = [knob]
            cycle.append(cycle)
        knob.record_to(path)
        knob.start_telemetry()
        knob.arm()
        while knob.statistics().samples_received < 300:
            knob.sleep(0.01)

    drop()
    gc.collect()
    assert made.is_closed
    assert not made.is_armed
    wait_for_all()
    loaded = torsio.load(path)
    assert loaded.whole
    assert len(loaded.telemetry) >= 300  # nobody has read them


def test_one_of_two_recordings_that_begin_at_once_is_refused(tmp_path: Path) -> None:
    for _ in range(10):
        with torsio.open("emulated") as knob:
            refused: list[str] = []
            both = threading.Barrier(2)

            def begin(
                name: str,
                knob: torsio.Knob = knob,
                both: threading.Barrier = both,
                refused: list[str] = refused,
            ) -> None:
                both.wait()
                try:
                    knob.record_to(tmp_path / name)
                except torsio.Error as error:
                    refused.append(str(error))

            threads = [threading.Thread(target=begin, args=[f"{name}.mcap"]) for name in "ab"]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            assert len(refused) == 1
            assert "recorded already" in refused[0]


def test_calibration_that_cannot_put_the_configuration_back_says_so() -> None:
    knob = torsio.open("emulated")
    with pytest.raises(torsio.Error, match="ActuatorConfig from before"):
        calibrate(knob, drift=True, progress=lambda _: knob.close())


@pytest.mark.parametrize("paced", [False, True])
def test_thread_that_arms_again_and_again_ends_with_close(paced: bool) -> None:
    def keep_armed(knob: torsio.Knob, closed: threading.Event) -> None:
        with suppress(torsio.Closed):
            while not closed.is_set():
                if knob.state != "armed":
                    knob.arm()

    for _ in range(20):
        made, closed = device(paced=paced), threading.Event()
        with torsio.open(made) as knob:
            knob.update(watchdog_s=60.0)
            threads = [
                threading.Thread(target=keep_armed, args=(knob, closed), daemon=True)
                for _ in range(2)
            ]
            for thread in threads:
                thread.start()
            knob.wait_for("armed", timeout_s=5.0)
            knob.sleep(0.001)
        assert not made.is_armed
        closed.set()
        for thread in threads:
            thread.join()
        assert not made.is_armed
