"""A knob's telemetry, read in several ways."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from torsio import _torsio
from torsio.common import checks
from torsio.common.notebook import Telemetry
from torsio.errors import Timeout
from torsio.knob import warnings as knob_warnings
from torsio.knob.recording import KnobRecording, hang_on
from torsio.printed.told import Disarm
from torsio.telemetry import Record

__all__ = ["KnobTelemetry"]

# A quarter of an hour at 20 kHz; more is a slip of the pen.
_MAX_SAMPLES = 2**24
# Thirty years. A timeout of nothing would end before anything can have come.
_LONGEST_S, _SHORTEST_TIMEOUT_S = 1e9, 1e-3


class KnobTelemetry:
    """The part that a `torsio.Knob` has for its telemetry."""

    def __init__(self, knob: _torsio.Knob, recording: KnobRecording) -> None:
        self._knob = knob
        self._recording = recording
        self._is_started = False

    def start_telemetry(self, rate_hz: float | None = None, *, prompt: bool = False) -> float:
        """Start telemetry, or change its rate, and forget what was not read.

        Parameters
        ----------
        rate_hz
            Highest rate wanted, up to the control rate and 4,000 Hz. None takes the highest up to
            3,600 Hz, which leaves the cable room for answers; above that samples are lost if
            commands are sent all the time.
        prompt
            Have the device report in every frame, a millisecond, the newest samples that are there,
            at most 4, instead of full reports: for loops that use `latest`. Without a rate this is
            2,000 Hz. The rate may be the control rate then, for the newest tick that there is;
            above 4,000 Hz what a report has no room for is left out, and counted as lost.

        Returns
        -------
        float
            The true rate: the device sends every n-th control tick.

        Raises
        ------
        InvalidArgument
            Says which rates this knob has.
        """
        self._is_started = True
        return self._recording.start_telemetry(_rate(rate_hz), checks.flag("prompt", prompt))

    def stop_telemetry(self) -> None:
        """Stop telemetry; a `record` in another thread keeps it until that is done.

        Warns as `record` does if a scene was played and never armed; so does `Knob.close`.
        """
        self._recording.stop_telemetry()
        self.end()

    def end(self) -> None:
        """Warn at the end of a reading, if there was one."""
        if self._is_started:
            self._recording.warn_if_never_armed()
        self._is_started = False

    def latest(self) -> Record:
        """Give the newest sample that has arrived; it can still be read.

        Waits only for the very first. Raises `Error` if no telemetry runs.

        Returns
        -------
        Record
            One row of `torsio.telemetry.TELEMETRY_DTYPE`, shape ().
        """
        return self._knob.latest().reshape(())

    def read(self, *, max_samples: int = 4096, timeout_s: float = 1.0) -> Telemetry:
        """Take samples, oldest first; wait until there is one or the time is over.

        Returns
        -------
        Telemetry
            Rows of `torsio.telemetry.TELEMETRY_DTYPE`, shape (n,), 0 <= n <= max_samples.
        """
        return self._recording.read(
            checks.whole("max_samples", max_samples, 0, _MAX_SAMPLES),
            checks.number("timeout_s", timeout_s),
        )

    def record(
        self,
        duration_s: float,
        *,
        rate_hz: float | None = None,
        must_stay_armed: bool = False,
    ) -> Telemetry:
        """Let time pass and give every sample of that span.

        Starts telemetry if it does not run, or if a rate is given. Threads may record at the same
        time. If it ends early the samples that came can still be read, and the exception, also
        KeyboardInterrupt, has all of them as its attribute `samples`.

        Parameters
        ----------
        must_stay_armed
            Raise `Disarmed` if the knob is not armed, or when the torque goes meanwhile. Otherwise
            a recording gives a `DisarmedWarning` at its end if the torque was off for a part of it,
            or if a scene was played before and never armed.

        Returns
        -------
        Telemetry
            Rows of `torsio.telemetry.TELEMETRY_DTYPE`, shape (n,).
        """
        duration_s = checks.number("duration_s", duration_s)
        rate_hz = _rate(rate_hz)
        must_stay_armed = checks.flag("must_stay_armed", must_stay_armed)
        kept: list[Any] = []
        try:
            self._recording.record(duration_s, rate_hz, must_stay_armed, kept)
            samples: Record
            samples, disarm, armed_late = kept
            # Last: you may have turned warnings into errors.
            if disarm is not None:
                knob_warnings.warn(knob_warnings.disarmed(Disarm(**disarm)))
            elif armed_late:
                knob_warnings.warn(knob_warnings.armed_late())
            else:
                self._recording.warn_if_never_armed()
            return samples.view(Telemetry)
        except BaseException as error:
            hang_on(error, kept)
            raise

    def telemetry(
        self,
        duration_s: float | None = None,
        *,
        rate_hz: float | None = None,
        max_samples: int = 4096,
        timeout_s: float = 1.0,
    ) -> Iterator[Telemetry]:
        """Iterate over telemetry as it comes, in arrays of one sample or more.

        The end, and a break, warn as `record` does if a scene was played and never armed.

        Parameters
        ----------
        duration_s
            None goes on for ever.
        rate_hz
            As in `start_telemetry`, which the first step calls.
        max_samples
            Longest array.
        timeout_s
            `Timeout` is raised when nothing has come for so long, 1 ms or more.
        """
        # Here and not in the generator, which would complain only when it is first asked.
        if duration_s is not None:
            duration_s = checks.number("duration_s", duration_s, 0.0, _LONGEST_S)
        rate_hz = _rate(rate_hz)
        max_samples = checks.whole("max_samples", max_samples, 1, _MAX_SAMPLES)
        timeout_s = checks.number("timeout_s", timeout_s, _SHORTEST_TIMEOUT_S, _LONGEST_S)
        return self._telemetry(duration_s, rate_hz, max_samples, timeout_s)

    def _telemetry(
        self, duration_s: float | None, rate_hz: float | None, max_samples: int, timeout_s: float
    ) -> Iterator[Telemetry]:
        rate_hz = self.start_telemetry(rate_hz)
        left = None if duration_s is None else round(duration_s * rate_hz)
        while left is None or left > 0:
            size = max_samples if left is None else min(max_samples, left)
            kept: list[Record] = []
            try:
                kept.append(self._recording.read(size, timeout_s))
                if len(kept[0]) == 0:
                    raise Timeout(f"no telemetry for {timeout_s} s")
                if left is not None:
                    left -= len(kept[0])
                yield kept[0].view(Telemetry)
            except BaseException as error:
                hang_on(error, kept)
                self._recording.warn_if_never_armed()  # after a break
                raise
        self._recording.warn_if_never_armed()


def _rate(rate_hz: float | None) -> float | None:
    return None if rate_hz is None else checks.number("rate_hz", rate_hz)
