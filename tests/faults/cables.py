"""A transport of one's own that fails, once or from then on: each method, in each way."""

from __future__ import annotations

import random
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import Any, cast

import torsio
from tests.faults.calls import BOUNDED, SPRING
from tests.faults.knobs import Device, PacedDevice


def _raise(error: BaseException) -> Any:
    raise error


# A write's other behaviour.
WRITES: dict[str, Callable[..., Any]] = {
    "no room": lambda *_: False,
    "lost": lambda *_: True,
    "cut short": lambda device, _, report: Device.write(device, report[:20].ljust(64, b"\0")),
    "OSError": lambda *_: _raise(OSError("no route")),
    "Disconnected": lambda *_: _raise(torsio.Disconnected("gone")),
    "KeyboardInterrupt": lambda *_: _raise(KeyboardInterrupt()),
    "not a truth": lambda *_: "yes",
}
READS: dict[str, Callable[..., Any]] = {
    "random bytes": lambda _, chance, *__: chance.randbytes(64),
    "12 bytes": lambda _, chance, *__: chance.randbytes(12),
    "known report, random rest": lambda _, chance, *__: (
        bytes([chance.randrange(1, 40)]) + chance.randbytes(63)
    ),
    "no bytes": lambda *_: 7,
    "OSError": lambda *_: _raise(OSError("no route")),
    "KeyboardInterrupt": lambda *_: _raise(KeyboardInterrupt()),
}
FEATURES = {
    "stalled": lambda *_: None,
    "random bytes": READS["random bytes"],
    "12 bytes": READS["12 bytes"],
    "OSError": READS["OSError"],
    "KeyboardInterrupt": READS["KeyboardInterrupt"],
}
RAISING = {k: WRITES[k] for k in ("OSError", "KeyboardInterrupt")}
METHODS: dict[str, dict[str, Callable[..., Any]]] = {
    "write": WRITES,
    "read": READS,
    "get_feature": FEATURES,
    "set_feature": {k: v for k, v in WRITES.items() if k != "cut short"},
    "close": RAISING,
    "now_ns": {
        **RAISING,
        "not a number": lambda *_: "soon",
        "another time": lambda _, chance: chance.randrange(10**12),
    },
    "advance_to": {**RAISING, "does nothing": lambda *_: None},
}
# What is told, or cannot be, when it lasts: a loss nobody sees, a report that is never whole.
UNSEEN = ("lost", "cut short", "not a truth")
LASTING = {
    **{
        method: {k: v for k, v in kinds.items() if k not in UNSEEN}
        for method, kinds in METHODS.items()
        if method != "close"
    },
    "now_ns": {**METHODS["now_ns"], "stands still": lambda *_: 10**9},
}
BLOCKS = {"blocks": lambda device, *_: device.until_over()}
HANGS_S = 30.0


class Faulty(Device):
    """Fails at one call of one method, or from a step on."""

    step, failed_in = -1, -1  # of the steps; before them the knob is opened
    _act: Callable[..., Any] | None = None

    def fail(self, method: str, at: int, act: Callable[..., Any] | None, *, lasts: bool) -> None:
        self.calls, self.method, self._at, self._act = 0, method, at, act
        self.lasts, self._over = lasts, threading.Event()
        self._chance = random.Random(at)

    def until_over(self) -> None:
        self._over.wait()

    def end(self) -> None:
        """Fail no more."""
        self._act = None
        self._over.set()

    def is_closed_soon(self) -> bool:
        """Whether it was closed; by a read that had to come back first."""
        for _ in range(1000):
            if self.is_closed:
                break
            time.sleep(0.01)
        return self.is_closed

    def _do(self, method: str, *given: Any) -> Any:
        if method == self.method and self._act is not None:
            self.calls += 1
            if self.step >= self._at if self.lasts else self.calls - 1 == self._at:
                self.failed_in = self.step
                return self._act(self, self._chance, *given)
        return getattr(super(), method)(*given)

    def write(self, report: bytes) -> bool:
        return cast(bool, self._do("write", report))

    def read(self, timeout_s: float) -> bytes | None:
        return cast("bytes | None", self._do("read", timeout_s))

    def get_feature(self, report_id: int) -> bytes | None:
        return cast("bytes | None", self._do("get_feature", report_id))

    def set_feature(self, report: bytes) -> bool:
        return cast(bool, self._do("set_feature", report))

    def close(self) -> None:
        self._do("close")

    def now_ns(self) -> int:
        return cast(int, self._do("now_ns"))

    def advance_to(self, time_ns: int) -> None:
        self._do("advance_to", time_ns)


class PacedFaulty(Faulty, PacedDevice):
    """The same in real time."""


STEPS: tuple[Callable[[torsio.Knob], object], ...] = (
    lambda knob: knob.update(watchdog_s=0.01),  # with signs of life in each wait
    lambda knob: knob.play(SPRING),
    lambda knob: knob.arm(),
    lambda knob: knob.record(0.01),
    lambda knob: knob.stream_local_model(torque_nm=0.01, deadline_s=1.0),
    lambda knob: knob.sleep(0.01),
    lambda knob: [*zip(range(3), knob.every(0.005), strict=False)],
    lambda knob: knob.wait_for("disarmed", timeout_s=0.01),
    lambda knob: knob.start_telemetry(),
    lambda knob: knob.latest(),
    lambda knob: knob.read(),
    lambda knob: knob.excite(BOUNDED),
    lambda knob: knob.sleep(0.01),
    lambda knob: knob.health(),
    lambda knob: knob.disarm(),
    lambda knob: knob.update(law="motor_only"),
    lambda knob: knob.save(),
    lambda knob: knob.update(law="paper", watchdog_s=60.0),
    lambda knob: knob.play(SPRING),
    lambda knob: knob.arm(),
)
"""They end armed, and the watchdog is of no help then."""
LASTING_STEPS: tuple[Callable[[torsio.Knob], object], ...] = (
    lambda knob: knob.update(watchdog_s=60.0),
    lambda knob: knob.play(SPRING),
    lambda knob: knob.arm(),
    lambda knob: knob.record(0.01),
    lambda knob: knob.sleep(0.01),
    lambda knob: knob.stream_local_model(torque_nm=0.01, deadline_s=50.0),
    lambda knob: knob.health(),
    lambda knob: knob.latest(),
)


def _use(made: Faulty, steps: Sequence[Callable[[torsio.Knob], object]]) -> None:
    with torsio.open(made, command_timeout_s=0.05) as knob:
        for step, act in enumerate(steps):
            made.step = step
            act(knob)
        made.step = len(steps)


def _hangs(act: Callable[[], None]) -> bool:
    """Run it in a thread: what hangs may not hear a Ctrl-C."""
    thread = threading.Thread(target=act, daemon=True)
    thread.start()
    thread.join(HANGS_S)
    return thread.is_alive()


def trial(
    method: str, at: int, kind: str | None, *, lasts: bool = False, paced: bool = False
) -> tuple[str, int]:
    """Let calls fail; say what is wrong afterwards, and how many calls there were."""
    made = PacedFaulty() if paced else Faulty()
    kinds = {**(LASTING if lasts else METHODS)[method], **BLOCKS}
    made.fail(method, at, (lambda *_: None) if kind is None else kinds[kind], lasts=lasts)
    raised: list[BaseException] = []
    # Errors of close() go there.
    unraisable: list[Any] = []

    def use() -> None:
        try:
            _use(made, LASTING_STEPS if lasts else STEPS)
        except BaseException as error:
            raised.append(error)

    before, sys.unraisablehook = sys.unraisablehook, unraisable.append
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            hangs = _hangs(use)
    finally:
        sys.unraisablehook = before
        made.end()
    told = [str(each.exc_value) for each in unraisable]
    wrong = "hangs" if hangs else _wrong(made, kind, raised[0] if raised else None, told)
    return wrong + (", armed" if hangs and made.is_armed else ""), made.calls


def _wrong(made: Faulty, kind: str | None, raised: BaseException | None, told: list[str]) -> str:
    is_told = any("not told to disarm" in text for text in told)
    is_told |= kind == "Disconnected" and isinstance(raised, torsio.Disconnected)
    if made.is_armed and not (made.lasts and made.method == "write" and is_told):
        return "armed" + (", nothing said" if raised is None and not told else "")
    if is_told and kind != "Disconnected" and not made.lasts:
        return "said that it is armed"
    if kind is None:
        return "" if raised is None else f"told by {raised!r}"
    if raised is not None and not made.is_closed_soon():
        return "not closed"
    has_failed = made.failed_in != -1
    if kind == "KeyboardInterrupt" and has_failed and not isinstance(raised, KeyboardInterrupt):
        return f"told by {type(raised).__name__}"
    if isinstance(raised, KeyboardInterrupt) and made.step != made.failed_in and not made.lasts:
        return f"step {made.failed_in} was interrupted, step {made.step} raised"
    if (made.method, kind) == ("close", "OSError") and has_failed and not told:
        return "not told"
    if raised is None or isinstance(raised, torsio.Error | KeyboardInterrupt):
        return ""
    return f"told by {type(raised).__name__}: {raised}"


def trials(every: int) -> Iterator[tuple[str, str, str, str]]:
    """Give method, kind, what is wrong, and where."""
    yield from once(every)
    yield from lasting(every)


def once(every: int) -> Iterator[tuple[str, str, str, str]]:
    """Let one call fail."""
    for method, kinds in METHODS.items():
        wrong, calls = trial(method, -2, None)
        assert wrong == ""
        for kind in kinds:
            for at in range(0, calls, every):
                yield f"transport, {method}", kind, trial(method, at, kind)[0], f"call {at}"


def lasting(every: int) -> Iterator[tuple[str, str, str, str]]:
    """Let each call fail from a step on, in virtual and in paced time; at first from the end."""
    for paced in (False, True):
        pace = "paced" if paced else "virtual"
        for method, kinds in LASTING.items():
            if paced and method in ("now_ns", "advance_to"):
                continue
            for kind in {**kinds, **BLOCKS} if paced and method == "read" else kinds:
                for at in range(len(LASTING_STEPS), -1, -every):
                    wrong, _ = trial(method, at, kind, lasts=True, paced=paced)
                    yield f"transport, {method}, from then on", kind, wrong, f"{pace}, step {at}"
