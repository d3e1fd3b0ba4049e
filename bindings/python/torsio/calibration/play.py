"""Chains of bounded excitations that a calibration plays, and the telemetry of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from torsio import _torsio
from torsio.calibration.drive import Drive, drive_of
from torsio.calibration.quantity import Array, Refusal
from torsio.errors import Error, Refused
from torsio.knob import Knob
from torsio.knob.configuration import put_back
from torsio.printed.scenes import Excitation
from torsio.printed.told import MotorCurrent
from torsio.telemetry import Record

__all__ = ["Player", "Run"]

# When the host is late with the next stretch; then the device disarms.
_SLACK_S = 0.25
_LEAST_SLEEP_S = 1e-3
_SETTLE_S = 2.0
# The library keeps this many unless told otherwise.
_MOST_SAMPLES = 65536


@dataclass(frozen=True)
class Run:
    """The device's samples while one experiment played.

    Attributes
    ----------
    time_s, angle_rad, speed_rad_s, told_nm, motor_nm, brake_nm
        Shape (n,). The motor's command is delayed by half a tick and its lag; `motor_nm` is that
        less what its drive leaves missing, the torque of its moment. The brake's command is as it
        was given.
    counts
        From the device's zero; `count_rad` is one of them.
    period_s, tick_s
        Between two samples, and of the device's control.
    stopped
        Why the device disarmed before the end: a `DisarmReason`, or "".
    faults
        That were latched then.
    """

    time_s: Array
    counts: Array
    angle_rad: Array
    speed_rad_s: Array
    told_nm: Array
    motor_nm: Array
    brake_nm: Array
    count_rad: float
    period_s: float
    tick_s: float
    stopped: str = ""
    faults: tuple[str, ...] = ()

    def refuse_if_stopped(self, step: str, reason: str, sentence: str, **facts: Any) -> None:
        """Raise a `Refusal`, if it left its bounds with this one, else with the device's reason."""
        if self.stopped == "excitation_stopped":
            raise Refusal(step, reason, sentence, **facts)
        if self.stopped:
            why = " and ".join(f"the fault {name}" for name in self.faults) or self.stopped
            raise Refusal(
                step, self.stopped, f"the device disarmed ({why}): torsio doctor says more"
            )

    def between(self, begin_s: float, end_s: float) -> Run:
        """Give the part between two times since the first sample."""
        since = self.time_s - self.time_s[0]
        chosen = (since >= begin_s) & (since < end_s)
        arrays = {
            name: getattr(self, name)[chosen]
            for name in (
                *("time_s", "counts", "angle_rad", "speed_rad_s"),
                *("told_nm", "motor_nm", "brake_nm"),
            )
        }
        return replace(self, **arrays)

    def driven_by(self, drive: Drive) -> Run:
        """Give it as it is if this drive makes the motor's torque."""
        missing_nm = drive.missing_nm(self.told_nm, self.speed_rad_s)
        return replace(self, motor_nm=self.told_nm - missing_nm)


class Player:
    """Plays excitations on a knob; made by `playing`.

    Attributes
    ----------
    drive
        Source of the motor's torque; None if the motor gives what it is told.
    torque_scale
        The motor's torque over the torque that the board believes, once that is known.
    """

    def __init__(self, knob: Knob) -> None:
        self._knob = knob
        self._actuator, self._control = knob.actuator_config(), knob.control_config()
        self._tick_s = 1.0 / knob.info.control_rate_hz
        self._motor_lag_s = self._actuator.motor_time_constant_s
        self.drive: Drive | None = None
        self.torque_scale: float = 1.0
        self.count_rad: float = 2.0 * np.pi / knob.info.counts_per_rev

    @classmethod
    def playing(cls, knob: Knob) -> Player:
        """Prepare a disarmed knob in a ``with`` statement, and leave its configuration as it was.

        Raises
        ------
        Error
            At the end, if that cannot be.
        """
        return cls(knob)

    def __enter__(self) -> Player:
        """Configure the knob."""
        knob = self._knob
        try:
            knob.stop()
            # With nothing of the brake in its model the device tells the brake's command itself.
            none: dict[str, Any] = dict.fromkeys(
                ("brake_time_constant_s", "brake_release_time_constant_s", "brake_hysteresis_nm"),
                0.0,
            )
            knob.configure(replace(self._actuator, **none))
            knob.configure(replace(self._control, motor_slew_nm_per_s=0.0, autonomous=False))
            self._period_s = 1.0 / knob.start_telemetry()
            self.drive = drive_of(knob)
            self._begin_s = knob.clock().time_s
            return self
        except BaseException:
            self.__exit__()
            raise

    @_torsio.all_of
    def __exit__(self, *_: object) -> Iterable[Callable[[], object]]:
        """Configure it as before."""
        knob = self._knob
        if knob.is_open and knob.state == "disconnected":
            return ()  # it forgets unsaved values
        return (
            self._stop,
            partial(put_back, self._knob, self._actuator, "the calibration"),
            partial(put_back, self._knob, self._control, "the calibration"),
        )

    def _stop(self) -> None:
        with suppress(Error):  # or it cannot be put back, which is told
            self._knob.stop()
            self._knob.stop_telemetry()

    @property
    def seconds(self) -> float:
        """Seconds of the knob's time since the begin."""
        return self._knob.clock().time_s - self._begin_s

    def motor_current(self) -> MotorCurrent:
        """Ask the device what it has measured of the motor's current."""
        return self._knob.motor_current()

    def believe_configured(self) -> None:
        """Reckon with the configured torque constant, where the board does not do so yet.

        It takes a new one when it starts.
        """
        now = self.motor_current()
        if now.measured:
            constant = self._knob.board_config().motor_torque_constant_nm_per_a
            self.torque_scale = constant / now.torque_constant_nm_per_a

    def rescaled(self, log: Run) -> Run:
        """Give a run from before `torque_scale` and `drive` were known as it is with them."""
        told_nm = self.torque_scale * log.told_nm
        log = replace(log, told_nm=told_nm, motor_nm=told_nm)
        return log if self.drive is None else log.driven_by(self.drive)

    def watch(self, duration_s: float) -> Run:
        """Record without torque."""
        self._knob.read(max_samples=_MOST_SAMPLES, timeout_s=0.0)
        self._knob.sleep(duration_s)
        return self._run([self._knob.read(max_samples=_MOST_SAMPLES)])

    def settled(self, duration_s: float, counts: float) -> Run:
        """Record without torque until it moves by so little, or for two seconds in all."""
        end_s = self.seconds + _SETTLE_S
        while True:
            log = self.watch(duration_s)
            if float(np.ptp(log.counts)) <= counts or self.seconds >= end_s:
                return log

    def pulse(self, duration_s: float, **values: float) -> Run:
        """Play one stretch that the device itself ends, to the tick, however late the host is."""
        return self.chain([(duration_s, values)], slack_s=0.0)

    def chain(
        self,
        stretches: Sequence[tuple[float, dict[str, Any]]],
        *,
        look: Callable[[int], MotorCurrent] | None = None,
        look_every_s: float = 5e-3,
        slack_s: float = _SLACK_S,
        **bounds: float,
    ) -> Run:
        """Play stretches one after the other.

        Parameters
        ----------
        stretches
            Duration in seconds, and fields of an `Excitation`.
        look, look_every_s
            Asks the device for its current, at the begin of each stretch, whose number it is told,
            and every so often from then on.
        slack_s
            So long the device goes on with a stretch when the host is late with the next one.
        bounds
            Fields of all of them.
        """
        knob = self._knob
        knob.read(max_samples=_MOST_SAMPLES, timeout_s=0.0)
        pieces: list[Record] = []
        stopped = ""
        faults: tuple[str, ...] = ()
        try:
            knob._arm()  # that it is held low until this is done goes without saying
            for number, (duration_s, values) in enumerate(stretches):
                given = {**bounds, **values}
                knob.excite(Excitation(duration_s=duration_s + slack_s, **given))
                if look is None:
                    knob.sleep(duration_s)
                else:
                    self._look_on(duration_s, look_every_s, partial(look, number))
                pieces.append(knob.read(max_samples=_MOST_SAMPLES))
                if knob.state != "armed":
                    break
        except Refused:
            if knob.state == "armed":
                raise
        if knob.state != "armed":
            last = knob.last_disarm
            stopped = "fault" if knob.state == "fault" or last is None else str(last.reason)
            if stopped == "fault":
                faults = knob.faults()
            pieces.append(knob.read(max_samples=_MOST_SAMPLES, timeout_s=0.1))
        else:
            knob.disarm()
        return replace(self._run(pieces), stopped=stopped, faults=faults)

    def _look_on(self, duration_s: float, every_s: float, look: Callable[[], MotorCurrent]) -> None:
        """Look until a stretch is over by the device's time: a look takes time as well."""
        now_s = look().time_s
        end_s = now_s + duration_s
        while now_s < end_s and self._knob.state == "armed":
            self._knob.sleep(max(min(every_s, end_s - now_s), _LEAST_SLEEP_S))
            now_s = look().time_s

    def _run(self, pieces: list[Record]) -> Run:
        log = np.concatenate(pieces)
        time_s = log["time_s"].astype(np.float64)
        delay_s = 0.5 * self._tick_s + self._motor_lag_s
        motor_nm = log["motor_command_nm"].astype(np.float64)
        counts = log["position_counts"].astype(np.float64)
        told_nm = self.torque_scale * np.interp(time_s - delay_s, time_s, motor_nm)
        run = Run(
            time_s,
            counts,
            counts * self.count_rad,
            log["speed_rad_s"].astype(np.float64),
            told_nm,
            told_nm,
            log["brake_capacity_nm"].astype(np.float64),
            self.count_rad,
            self._period_s,
            self._tick_s,
        )
        return run if self.drive is None else run.driven_by(self.drive)
