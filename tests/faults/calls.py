"""Every call on the way to torque-off, ended at each of its lines by each kind of failure."""

from __future__ import annotations

import gc
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import torsio
from tests.faults.knobs import Device, device
from tests.faults.lines import RAISED, Injection, TwoInterrupts
from tests.python.test_firmware import StandIn, image
from torsio.calibration import calibrate
from torsio.knob import knob as knob_module

SPRING = torsio.Spring(stiffness_nm_per_rad=0.01)
BOUNDED = torsio.Excitation(
    duration_s=1.0, travel_rad=1.0, speed_limit_rad_s=50.0, torque_limit_nm=0.05
)


@dataclass
class Bench:
    """A knob that is armed and recorded, and what is to be looked at afterwards."""

    device: Device
    knob: torsio.Knob
    file: Path
    recording: torsio.RecordingFile | None = None
    first: int = 0  # tick that the recording has, or an older one
    others: list[Device] = field(default_factory=list)
    got: list[Any] = field(default_factory=list)


def _exit(bench: Bench) -> None:
    bench.knob.__exit__()


def _configure(bench: Bench) -> None:
    bench.knob.disarm()
    bench.knob.update(law="compensated")
    bench.knob.save()


def _disarmed(call: Callable[[torsio.Knob], None]) -> Callable[[Bench], None]:
    """Make it a call that needs a disarmed knob."""

    def disarm_and_call(bench: Bench) -> None:
        bench.knob.disarm()
        call(bench.knob)

    return disarm_and_call


def _record_to(bench: Bench) -> None:
    if bench.recording is not None:
        bench.recording.close()
    bench.recording = None
    _begin_recording(bench)
    bench.knob.sleep(0.02)


def _begin_recording(bench: Bench) -> None:
    bench.recording = bench.knob.record_to(bench.file)
    bench.first = bench.device.tick


def _record(bench: Bench) -> None:
    bench.got.append(bench.knob.record(0.03))


def _read(bench: Bench) -> None:
    bench.got.append(bench.knob.read())


def _telemetry(bench: Bench) -> None:
    bench.got.extend(bench.knob.telemetry(0.03))


def _arm(bench: Bench) -> None:
    bench.knob.disarm()
    bench.knob.arm()


def _note(bench: Bench) -> None:
    if bench.recording is not None:
        bench.recording.note("mark")


def _every(bench: Bench) -> None:
    steps = bench.knob.every(0.005)
    for _ in range(3):
        next(steps)


def _end_of_python(_: Bench) -> None:
    knob_module._close_all()


CALLS: dict[str, Callable[[Bench], Any]] = {
    "close": lambda bench: bench.knob.close(),
    "__exit__": _exit,
    "end of Python": _end_of_python,
    "disarm": lambda bench: bench.knob.disarm(),
    "stop": lambda bench: bench.knob.stop(),
    "play": lambda bench: bench.knob.play([SPRING, torsio.Damper(damping_nm_s_per_rad=1e-4)]),
    "arm": _arm,
    "note": _note,
    "clear_fault": _disarmed(torsio.Knob.clear_fault),
    "zero": _disarmed(torsio.Knob.zero),
    "record": _record,
    "read": _read,
    "telemetry": _telemetry,
    "sleep": lambda bench: bench.knob.sleep(0.2),
    "record_to": _record_to,
    "stream_local_model": lambda bench: bench.knob.stream_local_model(torque_nm=0.01),
    "configure, save": _configure,
    "load_config": _disarmed(lambda knob: torsio.load_config(knob, torsio.dump_config(knob))),
    "start_telemetry": lambda bench: bench.knob.start_telemetry(),
    "events": lambda bench: bench.knob.events(timeout_s=0.02),
    "every": _every,
    "wait_for": lambda bench: bench.knob.wait_for("disarmed", timeout_s=0.02),
    "excite": lambda bench: bench.knob.excite(BOUNDED),
}
"""In the order of the table."""
CLOSING = ("close", "__exit__", "end of Python")
DISARMING = (*CLOSING, "disarm", "stop")


def kinds_of(call: str) -> tuple[type[BaseException], ...]:
    """Give each kind of failure that it must survive."""
    return (*RAISED, TwoInterrupts) if call in CLOSING else RAISED


PATIENCE_S = 60.0  # longer than an answer takes on any loaded machine


@contextmanager
def bench(call: str, *, paced: bool, recorded: bool) -> Iterator[Bench]:
    """Make an armed knob that plays, and leave nothing of it behind."""
    with tempfile.TemporaryDirectory() as folder:
        made = device(paced=paced)
        knob = torsio.open(made, command_timeout_s=PATIENCE_S)
        this = Bench(made, knob, Path(folder) / "x.mcap")
        if call == "end of Python":
            this.others = [device(paced=paced), device(paced=paced)]
        others = [torsio.open(other, command_timeout_s=PATIENCE_S) for other in this.others]
        all_knobs = [knob, *others]
        try:
            for one in all_knobs:
                one.update(watchdog_s=60.0)
                one.play(SPRING)
                one.arm()
            if recorded:
                _begin_recording(this)
            else:
                knob.start_telemetry()
            knob.sleep(0.01)
            yield this
        finally:
            for one in all_knobs:
                with suppress(Exception):
                    one.close()
            this.knob = None  # type: ignore[assignment]
            del knob, others, all_knobs


def trial(
    call: str, at: int | None, kind: type[BaseException], *, paced: bool, recorded: bool
) -> tuple[str, Injection]:
    """End a call at a line; say what is wrong afterwards, or ""."""
    injection = Injection(at, kind)
    with warnings.catch_warnings(), bench(call, paced=paced, recorded=recorded) as this:
        warnings.simplefilter("ignore")
        newest = int(this.knob.latest()["tick"])
        raised: BaseException | None = None
        try:
            with injection.active():
                CALLS[call](this)
        except BaseException as error:
            raised = error
        try:
            return _wrong(call, this, raised, injection, newest), injection
        except torsio.Error as error:
            return f"told afterwards: {error!r}", injection


def _wrong(
    call: str, this: Bench, raised: BaseException | None, injection: Injection, newest: int
) -> str:
    """Look at the device, the program and the file."""
    if kind_is_lost(raised, injection):
        return "KeyboardInterrupt did not go on"
    devices = [this.device, *this.others]
    if (call in CLOSING or (call in DISARMING and raised is None)) and any(
        one.is_armed for one in devices
    ):
        return "armed"
    if call not in CLOSING:
        if call == "record_to" and this.recording is None:
            _begin_recording(this)
        if this.recording is None:
            with suppress(torsio.Error):
                newest = int(this.knob.latest()["tick"])
            this.got.append(this.knob.read(timeout_s=0.0))
        elif this.recording.is_open or call != "record_to":  # which closes it first
            newest = int(this.knob.record(0.01)["tick"][-1])
        this.knob.close()
        if this.device.is_armed:
            return "armed after close"
    if not all(one.is_closed for one in devices):
        return "not closed"
    if injection.kind is TwoInterrupts:
        return ""  # what the second leaves of the first one's end is not asked
    if raised is not None and hasattr(raised, "samples"):
        this.got.insert(0, raised.samples)
    if this.recording is None:
        return _lost_in_program(call, this, newest)
    with suppress(Exception):  # told already
        this.recording.close()  # an interrupt ends the wait for it
    return _lost_in_file(torsio.load(this.file), this.first, newest)


def kind_is_lost(raised: BaseException | None, injection: Injection) -> bool:
    """An interrupt must reach the program."""
    return (
        injection.where is not None
        and injection.kind is KeyboardInterrupt
        and not isinstance(raised, KeyboardInterrupt)
    )


def _lost_in_program(call: str, this: Bench, newest: int) -> str:
    if call not in ("record", "read", "telemetry"):
        return ""
    records = [record["tick"] for record in this.got if len(record)]
    ticks = np.unique(np.concatenate([*records, np.zeros(0, np.uint64)]))
    if len(ticks) == 0:
        return "no samples"
    return "samples lost" if _missing(ticks) or ticks[-1] < newest else ""


def _lost_in_file(loaded: torsio.Recorded, first: int, newest: int) -> str:
    """Say what a whole file lacks: every sample between two ticks is there, or counted as lost."""
    ticks = loaded.telemetry["tick"]
    if not loaded.whole:
        return "file torn"
    if len(ticks) == 0 or ticks[0] > first or ticks[-1] < newest:
        return f"ticks {first} to {newest} became {ticks[:1]} to {ticks[-1:]}"
    if len(ticks) != len(np.unique(ticks)):
        return "samples twice"
    missing = _missing(ticks)
    return "" if missing == loaded.samples_lost else f"{missing} lost, {loaded.samples_lost} told"


def _missing(ticks: Any) -> int:
    return int(np.sum(np.diff(ticks.astype(np.int64)) - 1))


def lines_of(call: str, *, paced: bool, recorded: bool) -> int:
    """How many lines a call runs when nothing happens."""
    _, injection = trial(call, None, KeyboardInterrupt, paced=paced, recorded=recorded)
    gc.collect()
    return injection.lines


def interrupt_calibration(at: int | None, kind: type[BaseException]) -> tuple[str, Injection]:
    """End a calibration at a line; the configuration must be as before."""
    injection = Injection(at, kind)
    with torsio.open("emulated") as knob:
        before = [knob.actuator_config(), knob.control_config()]
        try:
            with injection.active():
                calibrate(knob, drift=True)
        except BaseException as error:
            if kind_is_lost(error, injection):
                return "KeyboardInterrupt did not go on", injection
        if knob.state != "disarmed":
            return "armed", injection
        after = [knob.actuator_config(), knob.control_config()]
        return "" if before == after else "the configuration is another one", injection


def interrupt_thread(at: int, kind: type[BaseException]) -> tuple[str, Injection]:
    """End the thread of a recording's file at a line; that is told, or the file has all."""
    injection = Injection(at, kind, in_thread=True)
    made = device(paced=False)
    told: BaseException | None = None
    first = newest = 0
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "x.mcap"
        try:
            with injection.active(), torsio.open(made) as knob, knob.record_to(file):
                first = made.tick
                knob.arm()
                knob.sleep(0.05)
                newest = int(knob.latest()["tick"])
        except BaseException as error:
            told = error
        loaded = torsio.load(file)
    if made.is_armed or not made.is_closed:
        return "armed", injection
    if told is None:
        return _lost_in_file(loaded, first, newest), injection
    if injection.where is None or not isinstance(told, kind):
        return f"told by {told!r}", injection
    return "samples lost, unmarked" if _missing(loaded.telemetry["tick"]) else "", injection


def interrupt_update(at: int, kind: type[BaseException]) -> tuple[str, Injection]:
    """End a firmware update at a line; the drive has the file whole, or the call told why not."""
    injection = Injection(at, kind)
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        (folder / "system").mkdir()
        file = folder / "torsio-pico2.uf2"
        file.write_bytes(image())
        board = StandIn(folder / "system")
        told: BaseException | None = None
        try:
            with injection.active():
                torsio.update_firmware(file, host=board, timeout_s=10.0)
        except BaseException as error:
            told = error
        if board.taken or (board.mount / "torsio.uf2").exists():
            board.taking.join()
        is_armed = board.knob.state != "disarmed"
        board.knob.close()
    if kind_is_lost(told, injection):
        return "KeyboardInterrupt did not go on", injection
    if is_armed:
        return "armed", injection
    if told is None:
        return "" if board.taken == image() else "not whole, and nobody told", injection
    if board.taken not in (b"", image()):
        return "the drive has taken something else", injection
    is_told = injection.where is not None and isinstance(told, kind | torsio.Error)
    return "" if is_told else f"told by {told!r}", injection
