"""A transport of one's own that fails once: each write, and each read."""

from __future__ import annotations

import random
import sys
import warnings
from collections.abc import Callable, Iterator
from typing import Any, cast

import torsio
from tests.faults.calls import BOUNDED, SPRING
from tests.faults.knobs import Device


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
METHODS: dict[str, dict[str, Callable[..., Any]]] = {
    "write": WRITES,
    "read": READS,
    "get_feature": FEATURES,
    "set_feature": {k: v for k, v in WRITES.items() if k != "cut short"},
    "close": {k: WRITES[k] for k in ("OSError", "KeyboardInterrupt")},
}


class Faulty(Device):
    """Fails at one call of one method."""

    def __init__(self, method: str, at: int, act: Callable[..., Any] | None) -> None:
        super().__init__()
        self.calls, self._method, self._at, self._act = 0, method, at, act
        self.step, self.failed_in = -1, -1  # of STEPS; before them the knob is opened
        self._chance = random.Random(at)

    def _do(self, method: str, *given: Any) -> Any:
        if method == self._method:
            self.calls += 1
            if self.calls - 1 == self._at and self._act is not None:
                self.failed_in = self.step
                return self._act(self, self._chance, *given)
        return getattr(Device, method)(self, *given)

    def write(self, report: bytes) -> bool:
        return cast(bool, self._do("write", report))

    def read(self, timeout_s: float) -> bytes | None:
        return cast("bytes | None", self._do("read", timeout_s))

    def get_feature(self, report_id: int) -> bytes | None:
        return cast("bytes | None", self._do("get_feature", report_id))

    def set_feature(self, report: bytes) -> bool:
        return cast(bool, self._do("set_feature", report))

    def close(self) -> None:
        super().close()
        self._do("close")


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
    lambda knob: knob.update(law="paper"),
)


def _use(made: Faulty) -> None:
    with torsio.open(made, command_timeout_s=0.05) as knob:
        for step, act in enumerate(STEPS):
            made.step = step
            act(knob)
        made.step = len(STEPS)


def trial(method: str, at: int, kind: str | None) -> tuple[str, int]:
    """Let one call fail; say what is wrong afterwards, and how many calls there were."""
    act = None if kind is None else METHODS[method][kind]
    made = Faulty(method, at, act)
    raised: BaseException | None = None
    # Errors of close() go there.
    unraisable: list[Any] = []
    before, sys.unraisablehook = sys.unraisablehook, unraisable.append
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            _use(made)
        except BaseException as error:
            raised = error
        finally:
            sys.unraisablehook = before
    calls = made.calls
    if made.is_armed:
        return "armed", calls
    if kind is None and raised is not None:
        return f"told by {raised!r}", calls
    if raised is not None and not made.is_closed:
        return "not closed", calls
    if kind == "KeyboardInterrupt" and calls > at and not isinstance(raised, KeyboardInterrupt):
        return f"told by {type(raised).__name__}", calls
    if isinstance(raised, KeyboardInterrupt) and made.step != made.failed_in:
        return f"step {made.failed_in} was interrupted, step {made.step} raised", calls
    if (method, kind) == ("close", "OSError") and calls > at and not unraisable:
        return "not told", calls
    if raised is None or isinstance(raised, torsio.Error | KeyboardInterrupt):
        return "", calls
    return f"told by {type(raised).__name__}: {raised}", calls


def trials(every: int) -> Iterator[tuple[str, str, str, str]]:
    """Give method, kind, what is wrong, and where."""
    for method, kinds in METHODS.items():
        wrong, calls = trial(method, -1, None)
        assert wrong == ""
        for kind in kinds:
            for at in range(0, calls, every):
                yield f"transport, {method}", kind, trial(method, at, kind)[0], f"call {at}"
