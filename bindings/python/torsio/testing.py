"""For tests of programs that use a knob: felt torques, hands, faults, virtual time.

Works with any test runner; `torsio_pytest` makes pytest's fixtures of it.
"""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial, wraps
from typing import Any, Final, TypeAlias
from unittest.mock import patch

import numpy as np
import numpy.typing as npt

from torsio.common import checks
from torsio.errors import Closed, Disconnected, Error, InvalidArgument
from torsio.knob import Knob, need_knob
from torsio.knob.emulated import Emulator
from torsio.printed.emulator_options import LinkFaults
from torsio.printed.hands import Hand, NoHand, PrescribedMotion, TorqueHand
from torsio.telemetry import FLAG_STATE_MASK, TRUTH_DTYPE, Record

__all__ = ["Expected", "Faults", "HoldingHand", "assert_felt", "felt_nm", "virtual_time"]

_ARMED, _FAULT = 1, 2  # of the two bits of the state

Floats: TypeAlias = npt.NDArray[np.float64]
Expected: TypeAlias = float | npt.ArrayLike | Callable[[Floats], npt.ArrayLike]
"""A torque on the knob in N m, one for each row, or a function of the angles in rad."""
_CLOCKS: Final = ("monotonic", "perf_counter", "time")
_WALL: Final = {
    name: getattr(time, name) for name in ("sleep", *_CLOCKS, *(f"{name}_ns" for name in _CLOCKS))
}


def felt_nm(log: Record) -> Floats:
    """Give the torque that a hand feels from the device, shape (n,): the shaft's and the motor's.

    Parameters
    ----------
    log
        Telemetry, in which the shaft's torque is sensed and the motor's commanded, or the truth.

    Raises
    ------
    InvalidArgument
        If it is no such record.
    """
    __tracebackhide__ = True
    names = getattr(getattr(log, "dtype", None), "names", None) or ()
    for motor in ("motor_torque_nm", "motor_command_nm"):
        if motor in names and "spring_torque_nm" in names:
            felt: Floats = log["spring_torque_nm"].astype(float) + log[motor].astype(float)
            return felt
    raise InvalidArgument(
        "log must be telemetry, as knob.record(1.0) or torsio.load(path).telemetry gives it, "
        f"or the truth of an emulated knob, is {checks.show(log)}"
    )


def assert_felt(
    log: Record,
    expected: Expected,
    *,
    tolerance_nm: float = 5e-3,
    from_s: float | None = None,
    to_s: float | None = None,
    share: float = 1.0,
) -> None:
    """Assert that a hand felt a torque.

    Parameters
    ----------
    log
        Telemetry, or `Emulator.truth`.
    expected
        N m on the knob, positive along positive angle: a number, one for each row of the log, or a
        function that is given the angles in rad, shape (n,), and gives as many torques.
    tolerance_nm
        How far off a row may be, > 0. The reference actuator is good to 5 mN m.
    from_s, to_s
        Look at this span of the log's own ``time_s`` only.
    share
        So much of the span must be within the tolerance, above 0 to 1.

    Raises
    ------
    AssertionError
        With the worst row, and how many are off.
    InvalidArgument
        If there is nothing to look at, or an argument is out of its range.
    """
    __tracebackhide__ = True
    if getattr(getattr(expected, "dtype", None), "names", None):
        raise InvalidArgument(
            "expected is a record, and not torques in N m: write assert_felt(log, expected)"
        )
    felt = felt_nm(log)
    checks.positive("tolerance_nm", tolerance_nm)
    if not 0.0 < checks.number("share", share) <= 1.0:
        raise InvalidArgument(f"share is {share:g}, allowed is above 0 to 1")
    given = expected(log["angle_rad"].astype(float)) if callable(expected) else expected
    try:
        torques = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"expected must be torques in N m, is {checks.show(given)}") from None
    try:
        wanted = np.broadcast_to(torques, felt.shape)
    except ValueError:
        raise InvalidArgument(
            f"expected must be one torque or {len(felt)}, one for each row of the log, "
            f"has shape {np.shape(given)}"
        ) from None
    if np.isnan(wanted).any():
        raise InvalidArgument("expected is not everywhere a number: there is a NaN, or a None")
    span = np.ones(felt.shape, dtype=bool)
    if from_s is not None:
        span &= log["time_s"] >= checks.number("from_s", from_s)
    if to_s is not None:
        span &= log["time_s"] <= checks.number("to_s", to_s)
    if not span.any():
        times = f"{log['time_s'][0]:g} to {log['time_s'][-1]:g} s" if len(log) else "nothing"
        raise InvalidArgument(f"no row lies in the span; the log has {times}")

    error = np.where(span, np.abs(felt - wanted), 0.0)
    good = error <= tolerance_nm  # false for NaN
    off = int(np.count_nonzero(span & ~good))
    rows = int(np.count_nonzero(span))
    if rows - off >= share * rows:
        return
    worst = int(np.argmax(np.where(np.isnan(error), np.inf, error)))
    row = log[worst]
    raise AssertionError(
        f"felt {_mn(felt[worst])} mN m where {_mn(wanted[worst])} mN m was expected, at "
        f"{row['time_s']:.4f} s and {row['angle_rad']:.4f} rad; {off} of {rows} rows are off by "
        f"more than {_mn(tolerance_nm)} mN m{_without_torque(log[span])}"
    )


def _without_torque(log: Record) -> str:
    """Say so if that is why nothing was felt; the truth does not know it."""
    names = log.dtype.names or ()
    if "flags" not in names or (log["flags"] & FLAG_STATE_MASK == _ARMED).any():
        return ""
    if (log["flags"] & FLAG_STATE_MASK == _FAULT).any():
        return "; a fault kept the torque off: knob.faults() names it"
    return "; the knob was disarmed throughout: arm() turns the torque on"


def _mn(torque_nm: float) -> str:
    return f"{1e3 * torque_nm:.2f}"


class HoldingHand:
    """A hand on an emulated knob in virtual time, which does one thing after the other.

    Each act lets its time pass and gives the telemetry of it. Angles are the device's, so that
    ``turn_to(0.5)`` ends where a wall at 0.5 rad begins, also after `Knob.zero`.

    Parameters
    ----------
    knob
        Opened with ``EmulatorOptions(log_truth=True)``; take the truth with :meth:`truth`, not from
        the knob.

    Attributes
    ----------
    rows
        The truth as far as it was taken.
    """

    def __init__(self, knob: Knob) -> None:
        need_knob(knob)
        self._knob = knob
        self.rows: Record = np.zeros(0, dtype=TRUTH_DTYPE)

    def turn_to(self, angle_rad: float, *, duration_s: float = 0.5) -> Record:
        """Turn the knob to an angle at an even speed, whatever torque that takes, and hold it."""
        target_rad = checks.finite("angle_rad", angle_rad)
        duration_s = checks.positive("duration_s", duration_s)
        way_rad = target_rad - self._knob.position_rad()
        here_rad = self._true_angle_rad()
        there_rad = here_rad + way_rad
        return self._act(
            PrescribedMotion(angle_rad=[(0.0, here_rad), (duration_s, there_rad)]), duration_s
        )

    def push(self, torque_nm: float, *, duration_s: float = 0.5, ramp_s: float = 0.1) -> Record:
        """Push with a torque that rises from nothing, and go on pushing."""
        torque_nm = checks.finite("torque_nm", torque_nm)
        ramp_s = checks.positive("ramp_s", ramp_s)
        hand = TorqueHand(torque_nm=[(0.0, 0.0), (ramp_s, torque_nm)])
        return self._act(hand, checks.positive("duration_s", duration_s))

    def let_go(self, *, duration_s: float = 0.1) -> Record:
        """Let go of the knob."""
        return self._act(NoHand(), checks.positive("duration_s", duration_s))

    def truth(self) -> Record:
        """Give what no sensor saw since the knob was opened, one row a control tick."""
        new = self._knob.emulator.truth()
        if len(new):
            self.rows = np.concatenate([self.rows, new])
        return self.rows

    def _act(self, hand: Hand, duration_s: float) -> Record:
        self._knob.emulator.set_hand(hand)
        return self._knob.record(duration_s)

    def _true_angle_rad(self) -> float:
        """Where the plant is; the device's angles begin at another zero."""
        rows = self.truth()
        late_s = self._knob.emulator.time_s - (rows["time_s"][-1] if len(rows) else 0.0)
        if late_s > 2.5 / self._knob.info.control_rate_hz:
            raise Error(
                "somebody else has taken the truth from this knob, so the hand does not know where "
                "it is; take it with HoldingHand.truth() instead of Emulator.truth()"
            )
        if not len(rows):
            return 0.0
        # The last tick's; since then the knob has moved on by a tick.
        last = rows[-1]
        return float(last["angle_rad"] + last["speed_rad_s"] * late_s)


class Faults:
    """Faults of a knob, made on an emulated one.

    Blocks may stand within each other: the outer fault goes on when the inner one ends.

    Parameters
    ----------
    knob
        A knob, or a function that gives the present one, if one takes another's place. A block ends
        on the knob that it began on.
    """

    def __init__(self, knob: Knob | Callable[[], Knob]) -> None:
        self._current = _giver(knob)
        self._stops = 0
        self._link: list[dict[str, float]] = []

    @property
    def _emulator(self) -> Emulator:
        return self._current().emulator

    def unplug(self, *, after_s: float = 0.0) -> None:
        """Pull the plug, now or later. The next call of the knob then raises `Disconnected`."""
        self._emulator.unplug(after_s=after_s)

    @contextmanager
    def emergency_stop(self) -> Iterator[None]:
        """Press the emergency stop for the length of a ``with`` block.

        The device takes it as a fault at its next tick, which stays until `Knob.clear_fault`.
        """
        emulator = self._emulator
        emulator.set_emergency_stop(pressed=True)
        self._stops += 1
        try:
            yield
        finally:
            self._stops -= 1
            _unless_gone(lambda: emulator.set_emergency_stop(pressed=self._stops > 0))

    @contextmanager
    def damage(self, probability: float = 0.1) -> Iterator[None]:
        """Damage reports in both directions for the length of a ``with`` block.

        Parameters
        ----------
        probability
            Probability for each report, 0 to 1. The knob's seed decides which.
        """
        with self._link_faults(corrupt_output=probability, corrupt_input=probability):
            yield

    @contextmanager
    def silence(self) -> Iterator[None]:
        """Let nothing that the host sends arrive for the length of a ``with`` block.

        The device fails passive once its `ControlConfig.watchdog_s` is over, as if the program had
        frozen. Calls that need an answer raise `Timeout`.
        """
        with self._link_faults(drop_output=1.0):
            yield

    @contextmanager
    def _link_faults(self, **faults: float) -> Iterator[None]:
        emulator = self._emulator
        emulator.set_link_faults(self._all_of(*self._link, faults))
        self._link.append(faults)
        try:
            yield
        finally:
            self._link = [other for other in self._link if other is not faults]
            _unless_gone(lambda: emulator.set_link_faults(self._all_of(*self._link)))

    @staticmethod
    def _all_of(*several: dict[str, float]) -> LinkFaults:
        return LinkFaults(**{name: value for faults in several for name, value in faults.items()})


def _giver(knob: Knob | Callable[[], Knob]) -> Callable[[], Knob]:
    def give() -> Knob:
        current = knob() if callable(knob) else knob
        need_knob(current)
        return current

    if not callable(knob):
        give()
    return give


def _unless_gone(undo: Callable[[], object]) -> None:
    with suppress(Error):  # closed or unplugged meanwhile: there is nothing left to undo
        undo()


@contextmanager
def virtual_time(knob: Knob | Callable[[], Knob]) -> Iterator[None]:
    """Let the module `time` follow an emulated knob's clock for the length of a ``with`` block.

    ``time.sleep`` lets the knob's time pass, and ``time.monotonic``, ``perf_counter``, ``time`` and
    their ``_ns`` twins tell it. Names that were taken out of the module before, as by
    ``from time import sleep``, stay what they were. Other threads are affected as well. When the
    knob is closed or unplugged, only `sleep` moves the time on. The modules in `WAITING` of
    the standard library keep the wall's clock.

    Parameters
    ----------
    knob
        Or what gives the knob whose clock counts now, if one takes another's place.

    Raises
    ------
    Error
        Unless the knob is emulated.
    """
    clock = _Clock(_giver(knob))

    def now_s(start_s: float) -> float:
        return start_s + clock.elapsed_s()

    def now_ns(start_ns: int) -> int:
        return start_ns + round(1e9 * clock.elapsed_s())

    virtual: dict[str, Any] = {"sleep": clock.sleep}
    for name in _CLOCKS:
        virtual[name] = partial(now_s, getattr(time, name)())
        virtual[f"{name}_ns"] = partial(now_ns, getattr(time, f"{name}_ns")())
    chosen: dict[str, Any] = {name: _unless_waiting(virtual[name], name) for name in virtual}
    with patch.multiple(time, **chosen):
        yield


WAITING: Final = frozenset(
    {
        *("asyncio", "asyncore", "concurrent", "imaplib", "multiprocessing", "queue"),
        *("socketserver", "subprocess", "telnetlib", "threading"),
    }
)
"""Modules and packages of the standard library that compute a deadline and wait for it in C."""


def _unless_waiting(virtual: Callable[..., Any], name: str) -> Callable[..., Any]:
    """Give a function of the module `time` that tells those in `WAITING` the wall's clock."""
    real = _WALL[name]

    @wraps(real)  # to be pickled by its name
    def choose(*arguments: Any) -> Any:
        asks = str(sys._getframe(1).f_globals.get("__name__", ""))
        return (real if asks.partition(".")[0] in WAITING else virtual)(*arguments)

    return choose


class _Clock:
    """The time of emulated knobs one after the other; without a knob, `sleep` moves it."""

    def __init__(self, current: Callable[[], Knob]) -> None:
        self._current = current
        self._knob = current()
        self._begin_s = self._knob.emulator.time_s
        self._of_knob_s = 0.0
        self._besides_s = 0.0
        self._of_one_thread = threading.RLock()

    def elapsed_s(self) -> float:
        with self._of_one_thread:
            knob = self._current()
            with suppress(Error):  # closed
                self._of_knob_s = self._knob.emulator.time_s - self._begin_s
            if knob is not self._knob:
                self._besides_s += self._of_knob_s
                self._knob, self._begin_s, self._of_knob_s = knob, 0.0, 0.0
                return self.elapsed_s()
            return self._of_knob_s + self._besides_s

    def sleep(self, duration_s: float) -> None:
        duration_s = checks.number("duration_s", duration_s, 0.0, math.inf)
        end_s = self.elapsed_s() + duration_s
        try:
            self._knob.sleep(duration_s)
        except (Closed, Disconnected):  # maybe in the middle
            with self._of_one_thread:
                self._besides_s += max(0.0, end_s - self.elapsed_s())
        self.elapsed_s()  # for when the knob is closed next
