"""The recording of an open knob: what it has told goes to a file, as the program reads on."""

from __future__ import annotations

import math
import platform
import sys
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from torsio import _torsio
from torsio.common.notebook import Telemetry
from torsio.errors import Error
from torsio.knob import warnings as knob_warnings
from torsio.printed.told import DeviceInfo, Energies
from torsio.protocol import encode, fingerprint
from torsio.recordings.file import RecordingFile
from torsio.telemetry import Record

__all__ = ["KnobRecording", "hang_on"]

_ENERGIES_EVERY_S = 0.12
_COMMIT = encode("commit", {})[0]
_DRIFT = 200e-6  # a crystal is good to half of it


class _DeviceClock:
    """A device's time as its host knows it, without asking."""

    def __init__(self, knob: _torsio.Knob) -> None:
        self._knob = knob
        now_s = knob.emulator_time_s() if knob.is_emulated else knob.clock()["time_s"]
        self._heard_s = time.monotonic()
        self._behind_s = self._heard_s - now_s

    def hear(self, sample_s: float) -> None:
        """Take the time of a sample that has just come, and was some while on the way."""
        now_s = time.monotonic()
        drifted_s = _DRIFT * (now_s - self._heard_s)
        self._behind_s = min(self._behind_s + drifted_s, now_s - sample_s)
        self._heard_s = now_s

    def now_s(self) -> float:
        """Tell it: an emulated knob's exactly, another one's to some milliseconds."""
        if self._knob.is_emulated:
            with suppress(Error):  # gone
                return self._knob.emulator_time_s()
        return time.monotonic() - self._behind_s


class KnobRecording:
    """The file that an open knob's methods write to, if there is a recording."""

    def __init__(self, knob: _torsio.Knob, *, logs_inputs: bool, time_waits: bool) -> None:
        self._knob = knob
        self._time_waits = time_waits
        self._logs_inputs = logs_inputs
        self._awaits_arm = False  # a scene was played, and the knob was not armed since
        self._disarm_before: dict[str, Any] | None = None
        self._scene: Any = None  # the last one of this program
        self._file: RecordingFile | None = None
        self._tap: _torsio.ReportTap | None = None
        self._asked_s = -math.inf
        self._claim = threading.Lock()
        self._stream: tuple[float | None, bool, float] | None = None

    @property
    def is_under_way(self) -> bool:
        """False before `begin`, once the file is closed, and when it cannot be written."""
        return self._file is not None and self._file.is_open

    def begin(self, path: str | Path, info: DeviceInfo, configs: Iterable[Any]) -> RecordingFile:
        """Make the file; it has everything from here on.

        Raises `Error` if there is one already.
        """
        metadata = {
            "info": asdict(info),
            "configuration": {type(config).__name__: asdict(config) for config in configs},
            # Last: a file with this has all of them.
            "versions": {
                "torsio": _torsio.__version__,
                "protocol": info.protocol_version,
                "fingerprint": fingerprint(),
                "firmware": info.firmware_version,
                "python": platform.python_version(),
                "system": f"{platform.system()} {platform.machine()}",
            },
        }
        with self._claim:
            if self.is_under_way:
                raise Error("this knob is being recorded already: close that recording first")
            tap = self._knob.tap(with_telemetry=False)
            lost: int = self._knob.statistics()["samples_lost"]
            self._asked_s = -math.inf
            self._disarm_before = self._knob.last_disarm()
            self._clock = _DeviceClock(self._knob)
            before = self._file
            try:
                begun = tap.take()
                self._tap = tap
                self._file = RecordingFile(path, metadata, self, lost)
                self.__class__ = _UnderWay
                self._file.put(self._file.writer.write_reports, [begun])
                if any(content[0] == _COMMIT for _, sent, content in begun if sent):
                    self._file.note_order("playing", scene=self._scene)
                # What came before is not in it.
                self._stream = None, False, self._knob.start_telemetry(None, False)
                return self._file
            except BaseException:
                self._tap = None  # or it keeps every report from now on
                if self._file is not None and self._file is not before:
                    self._file.close()
                raise

    def end(self) -> None:
        """End it, if one is under way, and let its thread go on."""
        if self._file is not None:
            self._file.end()

    def let_go(self) -> None:
        """End it, and let go of the device."""
        try:
            self.end()
        finally:
            self._knob.close()

    def wait(self) -> None:
        """Wait until it is written, if that was not interrupted before."""
        if self._file is not None:
            self._file.wait()

    def tell_failure(self) -> None:
        """Raise what ended it, if nobody has heard."""
        if self._file is not None:
            self._file.tell_failure()

    def device_time_s(self) -> float:
        """Tell the device's time, without asking."""
        return self._clock.now_s()

    def disarm(self) -> None:
        """Order torque off, unless told to be autonomous."""
        self._knob.disarm_to_close()

    def note(self, kind: str, **values: Any) -> None:
        """Write down what was asked of the knob."""
        if self._file is not None:
            self._file.note_order(kind, **values)

    def played(self, scene: Sequence[Any], *, is_disarmed: bool) -> None:
        """Hear that a scene plays."""
        self._awaits_arm = bool(scene) and is_disarmed
        self._scene = scene
        self.note("play", scene=scene)

    def armed(self) -> None:
        """Hear that the torque is on; `note` writes the order down before it is sent."""
        self._awaits_arm = False

    def stopped(self) -> None:
        """Hear that torque and scene are gone."""
        self._awaits_arm = False
        self.note("stop")

    def warn_if_never_armed(self) -> None:
        """Say so, once for each scene, when a reading has come to its end or was left early.

        A program that plays no scene, or armed it before, wants a knob without torque.
        """
        if not self._awaits_arm or sys.exc_info()[0] not in (None, GeneratorExit):
            return
        if self._knob.is_open and self._knob.state == "disarmed":
            self._awaits_arm = False
            knob_warnings.warn(knob_warnings.never_armed())

    def start_telemetry(self, rate_hz: float | None, prompt: bool) -> float:
        """Start the stream anew; not if it runs so already, or the file would miss some samples."""
        self.drain()
        before = self._stream if self.is_under_way else None
        if before is not None and before[:2] == (rate_hz, prompt):
            return before[2]
        if before is not None and self._file is not None:
            self._file.put(self._file.writer.write_restart, [before[2]])
        self._stream = rate_hz, prompt, self._knob.start_telemetry(rate_hz, prompt)
        return self._stream[2]

    def stop_telemetry(self) -> None:
        """Stop it."""
        self._knob.stop_telemetry()
        self._stream = None

    def read(self, max_samples: int, timeout_s: float) -> Telemetry:
        """Take samples out of the knob, for the program and for the file.

        Any later exception has them as its attribute `samples`.
        """
        kept: list[Record] = []
        try:
            self._take_samples(self._knob.read, max_samples, timeout_s, kept)
            self._knob.pass_on()
            self._keep_rest(kept[0])
            return kept[0].view(Telemetry)
        except BaseException as error:
            hang_on(error, kept)
            raise

    def record(
        self, duration_s: float, rate_hz: float | None, must_stay_armed: bool, kept: list[Any]
    ) -> None:
        """Record, for the program and for the file.

        Parameters
        ----------
        kept
            Gets the samples, however it ends; if it ends well also how the torque went, or None,
            and whether it came late.
        """
        if self.is_under_way and rate_hz is not None:
            self.start_telemetry(rate_hz, False)
            rate_hz = None
        self.drain()  # old samples would be in the way
        try:
            self._take_samples(self._knob.record, duration_s, rate_hz, must_stay_armed, kept)
            self._knob.pass_on()
        except BaseException:
            if len(kept) == 1:
                self._keep_early(kept[0])
            raise
        self._keep_rest(kept[0])

    def drain(self) -> None:
        """Write down all that has come and nobody has read."""
        while self.is_under_way and len(self.read(65536, 0.0)):
            pass

    def _take(self, write: Callable[[Any], None], call: Callable[..., Any], *given: Any) -> None:
        """Take something out of the knob and into the file's queue, also if an error follows."""
        if self._file is None or not self._file.is_open:
            call(*given)
        else:
            self._file.put(write, map(call, *zip(given)))

    def _take_samples(self, call: Callable[..., Any], *given: Any) -> None:
        """Take samples; the file gets them as soon as it has room, or else how many they are."""
        if self._file is not None and self._file.is_open:
            received: int = self._knob.statistics()["samples_received"]
            if self._time_waits:
                self._file.wait_for_room(received)
            elif not self._file.has_room(received):
                self._file.put(self._file.writer.write_missed, map(len, map(call, *zip(given))))
                return
            self._file.put(self._file.writer.write, map(call, *zip(given)))
            return
        call(*given)

    def _keep_early(self, samples: Record) -> None:
        """Write what a recording had that ended early. It can still be read, but not written."""
        if self._file is not None and len(samples):
            self._file.put(self._file.writer.hold_early, [samples])

    def _keep_rest(self, samples: Record) -> None:
        """Write down what else has come meanwhile."""
        if self._file is None:
            return
        if self._file.is_open:
            self._file.put(self._file.writer.write_lost, [self._knob.statistics()["samples_lost"]])
            self._keep_reports()
            if len(samples):
                self._clock.hear(float(samples["time_s"][-1]))
                self._keep_energies(float(samples["time_s"][-1]))
        self._file.tell_failure()

    def _keep_reports(self) -> None:
        if self._file is not None and self._tap is not None:
            self._take(self._file.writer.write_reports, _torsio.ReportTap.take, self._tap)
            if self._logs_inputs:
                self._take(self._file.writer.write_inputs, _torsio.Knob.inputs, self._knob)

    def _keep_energies(self, now_s: float) -> None:
        """Ask for them, unless that was a moment ago. Without an answer write nothing down."""
        if self._file is None or abs(now_s - self._asked_s) < _ENERGIES_EVERY_S:
            return
        self._asked_s = now_s
        with suppress(Error):
            energies = Energies(**self._knob.energies())
            if energies.kept:
                self._file.put(self._file.writer.write_energies, [energies])

    def take_rest(self) -> None:
        """Write down what is left, before the file ends."""
        try:
            self.drain()
            if self._file is not None:
                self._file.put(self._file.writer.write_early, [None])
            self._keep_energies(math.inf)
        except Error as error:
            self.note("lost", why=str(error))
            self._keep_reports()
        finally:
            self._tap = None  # or it keeps every report from now on
            self.__class__ = KnobRecording
        if self._knob.is_open and self._knob.last_disarm() == self._disarm_before:
            self.warn_if_never_armed()


class _UnderWay(KnobRecording):
    """One that has a file. Python drops a Ctrl-C that falls into `__del__`: others have none."""

    def __del__(self) -> None:
        """Order torque off and end the file: nobody has the knob any more."""
        if self._file is not None and self._file.is_open:
            self.disarm()
            self._file.end_of(self)


def hang_on(error: BaseException, kept: list[Any]) -> None:
    """Give the samples to the exception, if they had come."""
    if kept:
        error.samples = kept[0]  # type: ignore[attr-defined]
