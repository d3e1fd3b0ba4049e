"""The thread that writes a recording's file."""

from __future__ import annotations

import contextlib
import json
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, BinaryIO, Final, cast

import numpy as np

from torsio import _torsio, protocol
from torsio.common.extras import how_to_install
from torsio.common.whole_file import beside
from torsio.common.worker import Worker
from torsio.errors import Error, MalformedReport
from torsio.printed.told import Energies
from torsio.recordings.messages import COLUMNS, TOPICS, LoggedReport, encoded, plain, schema_of
from torsio.recordings.stream import MOVES_OPEN_FILES, Claim, Stream
from torsio.telemetry import Record

__all__ = ["FileWriter", "missing", "wait_for_all"]

# A power cut loses the data in memory: this much at most.
_FLUSH_S: Final = 1.0
_CHUNK_BYTES: Final = 256 * 1024
# After so long without anything to write it looks whether the knob is still there.
_QUIET_S: Final = 1.0


def missing() -> Error:
    """Say which package is missing, and how it is installed."""
    return Error(f"recordings need the Python package mcap: {how_to_install('record')}")


_writing: Final[dict[int, Worker]] = {}


def wait_for_all() -> None:
    """Wait until all recordings are written. An interrupt ends the wait for one of them."""
    with contextlib.suppress(KeyError):
        while True:
            _writing.popitem()[1].join()


class FileWriter:
    """Writes what waits to a file, in a thread of its own.

    Parameters
    ----------
    has_source
        Tells whether the knob is still there. The thread must not keep it.

    Attributes
    ----------
    waiting
        What to write: one of the methods below, and what it is called with. None ends the file.
    samples, samples_lost
        Written so far, and missing in the file so far.
    failure
        Why the thread ended early.
    """

    def __init__(
        self,
        path: Path,
        metadata: Mapping[str, Mapping[str, Any]],
        samples_lost: int,
        has_source: Callable[[], bool],
    ) -> None:
        self._path, self._metadata, self._has_source = path, metadata, has_source
        self._host_minus_device_ns: int = metadata["clock"]["host_minus_device_ns"]
        self._period_ns = 1e9 / metadata["info"]["control_rate_hz"]
        self.samples: int = 0
        self.samples_lost: int = 0
        self.failure: BaseException | None = None
        # A signal's handler may use it in the middle of its use.
        self.waiting: SimpleQueue[tuple[Callable[[Any], None], Any] | None] = SimpleQueue()
        self._channels: dict[str, int] = {}
        self._newest_ns = 0  # newest sample
        self._restarts_from_ns = 0  # distance of samples before a restart of telemetry
        self._lost = samples_lost
        # Samples of an interrupted call until they are written, and their ticks, which come again.
        self._early: Record | None = None
        self._early_ticks = 0, 0
        self._file: Stream | None = None
        self._worker = Worker(self._work)

    def start(self) -> None:
        """Make the file, and start the thread."""
        try:
            from mcap.writer import CompressionType, Writer
        except ModuleNotFoundError as error:
            raise missing() from error
        try:
            with Claim(self._path.resolve()) as claim, beside(self._path) as place:
                self._file = Stream(place)
                self._mcap = Writer(
                    cast(BinaryIO, self._file),
                    chunk_size=_CHUNK_BYTES,
                    compression=CompressionType.ZSTD,
                )
                self._begin()
                is_beside = place != self._path.resolve()
                if is_beside and MOVES_OPEN_FILES:
                    claim.take()
                    self._file.lock()
                elif is_beside:
                    self._file.close()
            if is_beside and not MOVES_OPEN_FILES:
                self._file.go_on(self._path)
            self._worker.start()
        except BaseException as error:
            self.waiting.put(None)
            if self._file is not None:
                with contextlib.suppress(OSError):
                    self._file.close()
            if isinstance(error, OSError):
                raise self._named(error) from None
            raise

    def _begin(self) -> None:
        self._mcap.start(profile="torsio", library=f"torsio {_torsio.__version__}")
        for topic in TOPICS:
            schema = self._mcap.register_schema(
                f"torsio.{topic}", "jsonschema", json.dumps(schema_of(topic)).encode()
            )
            self._channels[topic] = self._mcap.register_channel(topic, "json", schema)
        for name, values in self._metadata.items():
            text = {key: json.dumps(plain(value)) for key, value in values.items()}
            self._mcap.add_metadata(name, text)
        self._mcap.flush()

    @property
    def runs(self) -> bool:
        """False once the file is closed, or when a write has failed."""
        return self._worker.runs

    def join(self) -> None:
        """Wait until the file is closed."""
        self._worker.join()

    # In the thread --------------------------------------------------------------------------

    def write(self, samples: Record) -> None:
        """Write telemetry, but what was written early only once."""
        if len(samples) == 0:
            return
        begin, end = self._early_ticks
        self._write_rows(samples[samples["tick"] < begin])
        self.write_early(None)
        self._write_rows(samples[samples["tick"] >= end])

    def hold_early(self, samples: Record) -> None:
        """Keep what an interrupted call had: it can still be read, or is written at the end."""
        self.write_early(None)
        self._early = samples
        self._early_ticks = int(samples["tick"][0]), int(samples["tick"][-1]) + 1

    def write_early(self, _: None) -> None:
        """Write what is held."""
        if self._early is not None:
            self._write_rows(self._early)
            self._early = None

    def _write_rows(self, samples: Record) -> None:
        if len(samples) == 0:
            return
        columns = [samples[name].tolist() for name in COLUMNS]
        times_ns = np.rint(1e9 * samples["time_s"]).astype(np.int64)
        if self._restarts_from_ns and self._newest_ns:
            between_ns = int(times_ns[0]) - self._newest_ns
            self.write_missed(round(between_ns / self._restarts_from_ns) - 1)
        self._restarts_from_ns = 0
        for at, row in zip(times_ns.tolist(), zip(*columns, strict=True), strict=True):
            self._write("telemetry", at, dict(zip(COLUMNS, row, strict=True)))
        self._newest_ns = int(times_ns[-1])
        self.samples += len(samples)

    def write_lost(self, samples_lost: int) -> None:
        """Write what is missing before the last samples, by the knob's count."""
        if samples_lost > self._lost:
            self.write_missed(samples_lost - self._lost)
            self._lost = samples_lost

    def write_restart(self, rate_hz: float) -> None:
        """Have the next samples tell what lies between them and the last ones of this rate."""
        self._restarts_from_ns = round(1e9 / rate_hz)

    def write_missed(self, samples: int) -> None:
        """Write that the device gave samples and the file did not get them."""
        if samples > 0:
            self._write("drop_outs", self._newest_ns, {"samples_lost": samples})
            self.samples_lost += samples

    def write_energies(self, energies: Energies) -> None:
        """Write what was asked after telemetry had come."""
        self._write("energies", round(1e9 * energies.time_s), asdict(energies))

    def write_reports(self, reports: Iterable[LoggedReport]) -> None:
        """Write reports that travelled, and what the device told of itself."""
        for tick, sent, content in reports:
            try:
                name, values = protocol.decode(content)
            except MalformedReport:
                name, values = "", {}
            row = {"tick": tick, "sent": sent, "name": name, "bytes": content.hex()}
            self._write("reports", round(self._period_ns * tick), row)
            if name == "event":
                self._write("device_events", round(self._period_ns * values["tick"]), values)

    def write_inputs(self, inputs: Iterable[Mapping[str, Any]]) -> None:
        """Write what entered an emulated device."""
        for one in inputs:
            row = {**one, "bytes": one["bytes"].hex()}
            self._write("inputs", round(self._period_ns * one["tick"]), row)

    def _work(self) -> None:
        try:
            _writing[id(self)] = self._worker
            self._write_what_waits()
        except BaseException as error:
            self.failure = self._named(error) if isinstance(error, OSError) else error
        _writing.pop(id(self), None)

    def _write_what_waits(self) -> None:
        """Write until the file is closed or cannot be written."""
        assert self._file is not None
        try:
            flush_at = time.monotonic() + _FLUSH_S
            while True:
                try:
                    item = self.waiting.get(timeout=_QUIET_S)
                except Empty:
                    if not self._has_source():
                        break  # nobody has given the rest: the file is torn
                else:
                    if item is None:
                        self._mcap.finish()
                        break
                    write, value = item
                    write(value)
                if time.monotonic() >= flush_at:
                    self._mcap.flush()
                    flush_at = time.monotonic() + _FLUSH_S
            self._file.close()
        except BaseException:
            with contextlib.suppress(OSError):  # a full disk is reported already
                self._file.close()
            raise

    def _named(self, error: OSError) -> OSError:
        """Say which file it is; a write does not."""
        return OSError(error.errno, error.strerror or str(error), str(self._path))

    def _write(self, topic: str, device_ns: int, message: Mapping[str, Any]) -> None:
        self.write_encoded((topic, device_ns, encoded(message), time.time_ns()))

    def write_encoded(self, message: tuple[str, int, bytes, int]) -> None:
        """Write a message: its topic, the device's time, its bytes, the host's time."""
        topic, device_ns, data, host_ns = message
        at_ns = self._host_minus_device_ns + device_ns
        self._mcap.add_message(self._channels[topic], at_ns, data, host_ns)
