"""The file of a recording while it is written."""

from __future__ import annotations

import contextlib
import json
import math
import threading
import time
import weakref
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, fields, is_dataclass
from itertools import repeat
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, BinaryIO, Final, Protocol, TypeAlias, cast

import numpy as np

from torsio import _torsio, protocol
from torsio.common.extras import how_to_install
from torsio.common.whole_file import beside
from torsio.common.worker import Worker, exhaust
from torsio.errors import Closed, Error, InvalidArgument, MalformedReport
from torsio.printed.told import Energies
from torsio.recordings.stream import MOVES_OPEN_FILES, Claim, Stream
from torsio.telemetry import TELEMETRY_DTYPE, Record

__all__ = ["COLUMNS", "ENERGIES", "TOPICS", "LoggedReport", "RecordingFile"]
__all__ += ["Source", "missing", "wait_for_all"]

LoggedReport: TypeAlias = tuple[int, bool, bytes]
"""Ticks of the newest thing that the device had said by then, whether it was sent, its bytes."""

# A power cut loses the data in memory: this much at most.
_FLUSH_S: Final = 1.0
_CHUNK_BYTES: Final = 256 * 1024
_LOOK_S: Final = 0.05
# Most bytes of telemetry that wait for the disk.
_MOST_WAITING_BYTES: Final = 64 * 1024 * 1024
TOPICS: Final = (
    *("telemetry", "energies", "events", "device_events", "drop_outs", "reports", "inputs"),
)
_FIELDS: Final[dict[str, dict[str, str]]] = {
    "drop_outs": {"samples_lost": "integer"},
    "events": {"kind": "string"},
    "device_events": {"kind": "string", "state": "string", "faults": "integer", "tick": "integer"},
    "reports": {"tick": "integer", "sent": "boolean", "name": "string", "bytes": "string"},
    "inputs": {"tick": "integer", "kind": "string", "bytes": "string"},
    "energies": {
        of.name: {"int": "integer", "float": "number", "bool": "boolean"}[str(of.type)]
        for of in fields(Energies)
    },
}
COLUMNS: Final = TELEMETRY_DTYPE.names or ()
ENERGIES: Final = tuple(_FIELDS["energies"])
_JSON_TYPES: Final = {"f": "number", "u": "integer", "i": "integer"}


def missing() -> Error:
    """Say which package is missing, and how it is installed."""
    return Error(f"recordings need the Python package mcap: {how_to_install('record')}")


def _schema(topic: str) -> dict[str, Any]:
    """Describe a topic's messages to viewers."""
    types = _FIELDS.get(topic) or {
        name: _JSON_TYPES[TELEMETRY_DTYPE[name].kind] for name in COLUMNS
    }
    columns = {name: {"type": type} for name, type in types.items()}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"torsio.{topic}",
        "type": "object",
        "properties": columns,
        "required": list(columns),
    }


def _plain(value: Any) -> Any:
    """Turn effects, configurations and arrays into what JSON has, with their class's name.

    NaN and infinities become "NaN", "Infinity" and "-Infinity", which `float` reads.
    """
    if is_dataclass(value) and not isinstance(value, type):
        return {"type": type(value).__name__, **{k: _plain(v) for k, v in asdict(value).items()}}
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value


class Source(Protocol):
    """The knob that is recorded. If it goes, the file ends."""

    def device_time_s(self) -> float:
        """Tell the device's time."""

    def take_rest(self) -> None:
        """Give the file what has come and nobody has read."""

    def disarm(self) -> None:
        """Order torque off, as `torsio.Knob.close` does first."""


_writing: Final[dict[int, Worker]] = {}


def wait_for_all() -> None:
    """Wait until all recordings are written. An interrupt ends the wait for one of them."""
    with contextlib.suppress(KeyError):
        while True:
            _writing.popitem()[1].join()


class RecordingFile:
    """A file that is being written; made by `torsio.Knob.record_to`.

    Use it in a ``with`` statement, or `close` it. A thread writes it as the program goes on, so
    that nothing that ends a call of the program tears it. Up to 64 MiB of telemetry wait in memory
    for a slow disk. Beyond that a call in virtual time waits for the disk; in real time the file
    does not get the samples, and counts them as lost. The first write that fails ends it; the next
    call that has something for it, or `close`, raises that `OSError`.

    An exception that leaves the ``with`` statement, or an interrupt while the file is written,
    disarms the knob first, unless told to be autonomous.
    """

    def __init__(
        self,
        path: str | Path,
        metadata: Mapping[str, Mapping[str, Any]],
        source: Source,
        samples_lost: int,
    ) -> None:
        try:
            from mcap.writer import CompressionType, Writer
        except ModuleNotFoundError as error:
            raise missing() from error
        self.path: Final = Path(path)
        if self.path.suffix != ".mcap" and (self.path.is_file() or not self.path.exists()):
            raise InvalidArgument(f"a recording's name ends in .mcap, and {str(path)!r} does not")
        self.samples: int = 0
        """Written so far."""
        self.samples_lost: int = 0
        """Missing in the file so far: lost on the way, or because the disk was slow."""
        self._received = 0  # samples that are neither written nor waiting
        # The thread must not keep the knob.
        self._source: Callable[[], Source | None] = weakref.ref(source)
        # The times of all messages are the device's, laid on the host's clock once.
        self._host_minus_device_ns = time.time_ns() - round(1e9 * source.device_time_s())
        self._period_ns = 1e9 / metadata["info"]["control_rate_hz"]
        metadata = {"clock": {"host_minus_device_ns": self._host_minus_device_ns}, **metadata}
        self._file: Stream | None = None
        self._channels: dict[str, int] = {}
        self._newest_ns = 0  # newest sample
        self._restarts_from_ns = 0  # distance of samples before a restart of telemetry
        self._lost = samples_lost
        # Samples of an interrupted call until they are written, and their ticks, which come again.
        self._early: Record | None = None
        self._early_ticks = 0, 0
        self._failure: BaseException | None = None
        # Both may be used in the handler of a signal that comes in the middle of using them.
        self._waiting: SimpleQueue[tuple[Callable[[Any], None], Any] | None] = SimpleQueue()
        self._is_open = True
        self._takes_all = False
        self._is_waited_for = False
        self._worker = Worker(self._work)
        try:
            with Claim(self.path.resolve()) as claim, beside(self.path) as place:
                self._file = Stream(place)
                self._writer = Writer(
                    cast(BinaryIO, self._file),
                    chunk_size=_CHUNK_BYTES,
                    compression=CompressionType.ZSTD,
                )
                self._begin(metadata)
                is_beside = place != self.path.resolve()
                if is_beside and MOVES_OPEN_FILES:
                    claim.take()
                    self._file.lock()
                elif is_beside:
                    self._file.close()
            if is_beside and not MOVES_OPEN_FILES:
                self._file.go_on(self.path)
            self._worker.start()
        except BaseException as error:
            self._is_open = False
            self._waiting.put(None)
            if self._file is not None:
                with contextlib.suppress(OSError):
                    self._file.close()
            if isinstance(error, OSError):
                raise self._named(error) from None
            raise

    def _begin(self, metadata: Mapping[str, Mapping[str, Any]]) -> None:
        self._writer.start(profile="torsio", library=f"torsio {_torsio.__version__}")
        for topic in TOPICS:
            schema = self._writer.register_schema(
                f"torsio.{topic}", "jsonschema", json.dumps(_schema(topic)).encode()
            )
            self._channels[topic] = self._writer.register_channel(topic, "json", schema)
        for name, values in metadata.items():
            text = {key: json.dumps(_plain(value)) for key, value in values.items()}
            self._writer.add_metadata(name, text)
        self._writer.flush()

    def __enter__(self) -> RecordingFile:
        """Give the recording itself."""
        return self

    @_torsio.all_of
    def __exit__(self, kind: object = None, *_: object) -> Iterable[Callable[[], object]]:
        """Close the file."""
        return (self._disarm if kind else _nothing, *self._ends())

    @property
    def is_open(self) -> bool:
        """False once closed, or when a write has failed."""
        return self._is_open and self._worker.runs

    @_torsio.all_of
    def close(self) -> Iterable[Callable[[], object]]:
        """Write what is left, and the file's index. Closing twice is fine.

        An interrupt ends the wait for the file, which is written on. Close again to wait again;
        the end of Python does.
        """
        return self._ends()

    def _ends(self) -> Iterable[Callable[[], object]]:
        self._is_waited_for = False
        return self.end, self.wait, self.tell_failure

    @_torsio.all_of
    def end(self) -> Iterable[Callable[[], object]]:
        """Have the thread write what is left and end; the knob calls it."""
        return self._take_rest, self._end

    def end_of(self, source: Source) -> None:
        """End it for a source that goes: Python may have cleared the references to it."""
        self._source = lambda: source
        try:
            self.end()
        finally:
            self._source = lambda: None

    def _take_rest(self) -> None:
        source = self._source()
        if self.is_open and source is not None:
            self._takes_all = True
            source.take_rest()

    def _end(self) -> None:
        self._is_open = False
        self._waiting.put(None)

    def _disarm(self) -> None:
        source = self._source()
        if source is not None:
            source.disarm()

    def wait(self) -> None:
        """Wait for the thread; the knob calls it.

        `all_of` calls again what was interrupted, and so may those around it. Then do not wait.
        """
        if self._is_waited_for:
            self._disarm()
            return
        self._is_waited_for = True
        self._worker.join()
        self._is_waited_for = False

    def note(self, kind: str, **values: Any) -> None:
        """Write an event of the program's own: a mark, a condition of an experiment.

        Values that JSON lacks become text: NaN is "NaN", as `float` reads it. Raises `Closed` after
        the recording's end.
        """
        is_open = self.is_open and self._source() is not None
        self.note_order(kind, **values)
        if not is_open:
            raise Closed(f"the recording {self.path} has ended")

    def note_order(self, kind: str, **values: Any) -> None:
        """Write an event while the file is open; the knob calls it."""
        source = self._source()
        if self.is_open and source is not None:
            # Encoded here, for it may change, and who wrote it hears that it cannot be.
            at_ns, message = round(1e9 * source.device_time_s()), {"kind": kind, **values}
            self.put(self._write_encoded, [("events", at_ns, _encoded(message), time.time_ns())])
        self.tell_failure()

    def put(self, write: Callable[[Any], None], values: Iterable[Any]) -> None:
        """Have one of the methods below write what an iterator gives; the knob calls it.

        No Python runs between the iterator and the queue, so no interrupt comes there.
        """
        exhaust(map(self._waiting.put, zip(repeat(write), values)))

    def has_room(self, samples_received: int) -> bool:
        """Whether so many samples of the knob's may wait; the knob asks before it takes more."""
        if self._waiting.empty():
            self._received = samples_received - self.samples
        waiting = samples_received - self._received - self.samples
        return self._takes_all or waiting * TELEMETRY_DTYPE.itemsize <= _MOST_WAITING_BYTES

    def wait_for_room(self, samples_received: int) -> None:
        """Wait until they may, or the file has ended."""
        while self.is_open and not self.has_room(samples_received):
            threading.Event().wait(_LOOK_S)

    def tell_failure(self) -> None:
        """Raise the error that ended the file, once; the knob calls it."""
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure

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
            self._failure = self._named(error) if isinstance(error, OSError) else error
        _writing.pop(id(self), None)

    def _write_what_waits(self) -> None:
        """Write until the file is closed or cannot be written."""
        assert self._file is not None
        try:
            flush_at = time.monotonic() + _FLUSH_S
            while True:
                item: tuple[Callable[[Any], None], Any] | None = (_nothing, None)
                with contextlib.suppress(Empty):
                    item = self._waiting.get(timeout=max(_FLUSH_S, _LOOK_S))
                if item is None or (item[0] is _nothing and self._source() is None):
                    break
                write, value = item
                write(value)
                if time.monotonic() >= flush_at:
                    self._writer.flush()
                    flush_at = time.monotonic() + _FLUSH_S
            if item is None:  # else nobody has given the rest: the file is torn
                self._writer.finish()
            self._file.close()
        except BaseException:
            with contextlib.suppress(OSError):  # a full disk is reported already
                self._file.close()
            raise

    def _named(self, error: OSError) -> OSError:
        """Say which file it is; a write does not."""
        return OSError(error.errno, error.strerror or str(error), str(self.path))

    def _write(self, topic: str, device_ns: int, message: Mapping[str, Any]) -> None:
        self._write_encoded((topic, device_ns, _encoded(message), time.time_ns()))

    def _write_encoded(self, message: tuple[str, int, bytes, int]) -> None:
        topic, device_ns, data, host_ns = message
        at_ns = self._host_minus_device_ns + device_ns
        self._writer.add_message(self._channels[topic], at_ns, data, host_ns)


def _encoded(message: Mapping[str, Any]) -> bytes:
    plain = _plain(message)
    return json.dumps(plain, separators=(",", ":"), default=str, allow_nan=False).encode()


def _nothing(_: None = None) -> None:
    """Write nothing."""
