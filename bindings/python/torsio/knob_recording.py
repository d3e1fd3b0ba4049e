"""The recording of an open knob: what it has told goes to a file, as the program reads on."""

from __future__ import annotations

import math
import platform
import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

from torsio import _torsio
from torsio.emulated_knob import Emulator
from torsio.errors import Error
from torsio.protocol import fingerprint
from torsio.recording import RecordingFile
from torsio.telemetry import Record
from torsio.told import DeviceInfo, Energies

__all__ = ["KnobRecording"]

_ENERGIES_EVERY_S = 0.12
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
    """What an open knob's methods write to a file; nothing while none is under way."""

    def __init__(self, knob: _torsio.Knob, *, logs_inputs: bool) -> None:
        self._knob = knob
        self._logs_inputs = logs_inputs
        self._file: RecordingFile | None = None
        self._tap: _torsio.ReportTap | None = None
        self._asked_s = -math.inf

    @property
    def is_under_way(self) -> bool:
        """False before `begin` and once the file is closed."""
        return self._file is not None

    def refuse_if_under_way(self) -> None:
        """Raise `Error` if there is one already."""
        if self._file is not None:
            raise Error("this knob is being recorded already: close that recording first")

    def begin(self, path: str | Path, info: DeviceInfo, configs: Iterable[Any]) -> RecordingFile:
        """Make the file; what is told from here on is in it."""
        metadata = {
            "info": asdict(info),
            "configuration": {type(config).__name__: asdict(config) for config in configs},
            # Last: what has it has all of them.
            "versions": {
                "torsio": version("torsio"),
                "protocol": info.protocol_version,
                "fingerprint": fingerprint(),
                "firmware": info.firmware_version,
                "python": platform.python_version(),
                "system": f"{platform.system()} {platform.machine()}",
            },
        }
        self._clock = _DeviceClock(self._knob)
        tap = self._knob.tap(with_telemetry=False)
        self._file = RecordingFile(path, metadata, self._clock.now_s, self._end)
        self._asked_s = -math.inf
        self._tap = tap
        return self._file

    def close(self) -> None:
        """End it, if one is under way."""
        if self._file is not None:
            self._file.close()

    def note(self, kind: str, **values: Any) -> None:
        """Write down what was asked of the knob."""
        if self._file is not None:
            self._file.note(kind, **values)

    def keep(self, samples: Record) -> Record:
        """Write samples down, and give them on."""
        if self._file is not None:
            self._file.write(samples, self._knob.statistics()["samples_lost"])
            self._keep_reports()
            if len(samples):
                self._clock.hear(float(samples["time_s"][-1]))
                self._keep_energies(float(samples["time_s"][-1]))
        return samples

    def drain(self) -> None:
        """Write down all that has come and nobody has read."""
        while self._file is not None and len(self.keep(self._knob.read(65536, 0.0))):
            pass

    def _keep_reports(self) -> None:
        if self._file is not None:
            self._file.write_reports(self._tap.take() if self._tap else [])
            if self._logs_inputs:
                self._file.write_inputs(Emulator(self._knob).inputs())

    def _keep_energies(self, now_s: float) -> None:
        """Ask for them, unless that was a moment ago; who has no answer has none to write down."""
        if self._file is None or abs(now_s - self._asked_s) < _ENERGIES_EVERY_S:
            return
        self._asked_s = now_s
        with suppress(Error):
            energies = Energies(**self._knob.energies())
            if energies.kept:
                self._file.write_energies(energies)

    def _end(self) -> None:
        try:
            self.drain()
            self._keep_energies(math.inf)
        except Error as error:
            self.note("lost", why=str(error))
            self._keep_reports()
        self._file = self._tap = None
