"""Recordings: what a knob did, in a file that Foxglove and PlotJuggler open too.

The file is MCAP, with JSON and its schemas in it. `torsio.Knob.record_to` writes one, `load` reads
it. Both need the extra ``record``.
"""

from __future__ import annotations

import contextlib
import json
import math
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields, is_dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, BinaryIO, Final, TypeAlias

import numpy as np

from torsio import protocol
from torsio.emulator_options import DeviceInput
from torsio.errors import Error, MalformedReport
from torsio.extras import how_to_install
from torsio.telemetry import TELEMETRY_DTYPE, Record
from torsio.told import Energies
from torsio.whole_file import beside

__all__ = ["LoggedReport", "Recorded", "RecordingFile", "load"]

LoggedReport: TypeAlias = tuple[int, bool, bytes]
"""Ticks of the newest thing that the device had said by then, whether it was sent, its bytes."""

# What is in memory when the power goes is lost: this much at most.
_FLUSH_S: Final = 1.0
_CHUNK_BYTES: Final = 256 * 1024
_TOPICS: Final = (
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
_COLUMNS: Final = TELEMETRY_DTYPE.names or ()
_JSON_TYPES: Final = {"f": "number", "u": "integer", "i": "integer"}


def _missing() -> Error:
    return Error(f"recordings need the Python package mcap: {how_to_install('record')}")


def _schema(topic: str) -> dict[str, Any]:
    """Describe a topic's messages to viewers."""
    types = _FIELDS.get(topic) or {
        name: _JSON_TYPES[TELEMETRY_DTYPE[name].kind] for name in _COLUMNS
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


class RecordingFile:
    """A file that is being written; made by `torsio.Knob.record_to`.

    Use it in a ``with`` statement, or `close` it. It is written as the program goes on, and
    whole up to the last second whatever happens to the program.
    """

    def __init__(
        self,
        path: str | Path,
        metadata: Mapping[str, Mapping[str, Any]],
        device_time_s: Callable[[], float],
        on_close: Callable[[], None],
    ) -> None:
        try:
            from mcap.writer import CompressionType, Writer
        except ModuleNotFoundError as error:
            raise _missing() from error
        self.path: Final = Path(path)
        self.samples = 0
        """Written so far."""
        self._on_close = on_close
        # The times of all messages are the device's, laid on the host's clock once.
        self._device_time_s = device_time_s
        self._host_minus_device_ns = time.time_ns() - round(1e9 * device_time_s())
        self._period_ns = 1e9 / metadata["info"]["control_rate_hz"]
        metadata = {"clock": {"host_minus_device_ns": self._host_minus_device_ns}, **metadata}
        self._lock = threading.Lock()
        self._file: BinaryIO = self.path.open("wb")
        self._writer = Writer(self._file, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._writer.start(profile="torsio", library=f"torsio {version('torsio')}")
        self._channels = {}
        for topic in _TOPICS:
            schema = self._writer.register_schema(
                f"torsio.{topic}", "jsonschema", json.dumps(_schema(topic)).encode()
            )
            self._channels[topic] = self._writer.register_channel(topic, "json", schema)
        for name, values in metadata.items():
            text = {key: json.dumps(_plain(value)) for key, value in values.items()}
            self._writer.add_metadata(name, text)
        self._writer.flush()
        self._flushed_at = time.monotonic()
        self._lost: int | None = None
        self._is_open = True

    def __enter__(self) -> RecordingFile:
        """Give the recording itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.close()

    @property
    def is_open(self) -> bool:
        """False once closed."""
        return self._is_open

    def close(self) -> None:
        """Write what is left, and the file's index. Closing twice is fine."""
        if not self._is_open:
            return
        self._on_close()
        with self._lock:
            self._is_open = False
            try:
                self._writer.finish()
            finally:
                self._file.close()

    def note(self, kind: str, **values: Any) -> None:
        """Write an event of the program's own: a mark, a condition of an experiment.

        What JSON has not becomes text: NaN is "NaN" and infinity "Infinity", as `float` reads them.
        """
        self._add("events", round(1e9 * self._device_time_s()), {"kind": kind, **values})

    def write(self, samples: Record, samples_lost: int) -> None:
        """Write telemetry, and what is missing between it and the last; the knob calls it."""
        if len(samples) == 0:
            return
        first_ns = round(1e9 * float(samples["time_s"][0]))
        if self._lost is None:
            self._lost = samples_lost
        if samples_lost > self._lost:
            self._add("drop_outs", first_ns, {"samples_lost": samples_lost - self._lost})
            self._lost = samples_lost
        columns = [samples[name].tolist() for name in _COLUMNS]
        times_ns = np.rint(1e9 * samples["time_s"]).astype(np.int64)
        for at, row in zip(times_ns.tolist(), zip(*columns, strict=True), strict=True):
            self._add("telemetry", at, dict(zip(_COLUMNS, row, strict=True)))
        self.samples += len(samples)

    def write_energies(self, energies: Energies) -> None:
        """Write what was asked after telemetry had come; the knob calls it."""
        self._add("energies", round(1e9 * energies.time_s), asdict(energies))

    def write_reports(self, reports: Iterable[LoggedReport]) -> None:
        """Write reports that travelled, and what the device told of itself; the knob calls it."""
        for tick, sent, content in reports:
            try:
                name, values = protocol.decode(content)
            except MalformedReport:
                name, values = "", {}
            row = {"tick": tick, "sent": sent, "name": name, "bytes": content.hex()}
            at_ns = round(self._period_ns * tick)
            self._add("reports", at_ns, row)
            if name == "event":
                self._add("device_events", round(self._period_ns * values["tick"]), values)

    def write_inputs(self, inputs: Iterable[DeviceInput]) -> None:
        """Write what entered an emulated device; the knob calls it."""
        for one in inputs:
            row = {"tick": one.tick, "kind": one.kind, "bytes": one.bytes.hex()}
            self._add("inputs", round(self._period_ns * one.tick), row)

    def _add(self, topic: str, device_ns: int, message: Mapping[str, Any]) -> None:
        plain = _plain(message)
        data = json.dumps(plain, separators=(",", ":"), default=str, allow_nan=False).encode()
        at_ns = self._host_minus_device_ns + device_ns
        with self._lock:
            if not self._is_open:
                return
            self._writer.add_message(self._channels[topic], at_ns, data, time.time_ns())
            if time.monotonic() - self._flushed_at > _FLUSH_S:
                self._writer.flush()
                self._flushed_at = time.monotonic()


@dataclass(frozen=True)
class Recorded:
    """What a recording holds.

    Attributes
    ----------
    telemetry
        Of `torsio.telemetry.TELEMETRY_DTYPE`, shape (n,).
    events
        What the program asked of the knob and noted, in order; each has ``kind``,
        ``device_time_s``, which is the telemetry's ``time_s``, and ``host_time_ns``, when it was
        written by the host's clock.
    device_events
        What the device told of itself: changes of state, faults, silence; with the same two times.
    reports
        That were sent, and acknowledgements and events that came, in order: the tick of the newest
        thing known then, whether it was sent, and the bytes. First come those of the scene that
        played already, if the same program had played it.
    inputs
        What entered the device from its power-up on, or from the end of an earlier recording, if it
        was an emulated one that was opened with ``EmulatorOptions(log_inputs=True)``.
    samples_lost
        That never arrived.
    metadata
        Who the knob was, its configuration, the versions.
    energies
        Where the energy went, up to eight times a second as the program read, and at the end; empty
        while another law than ``"calibrated"`` was chosen.
    whole
        False if the file ends in the middle, as its program did. What came before is here.
    """

    telemetry: Record
    events: list[dict[str, Any]] = field(default_factory=list)
    samples_lost: int = 0
    metadata: dict[str, dict[str, Any]] = field(default_factory=dict)
    whole: bool = True
    device_events: list[dict[str, Any]] = field(default_factory=list)
    reports: list[LoggedReport] = field(default_factory=list)
    inputs: list[DeviceInput] = field(default_factory=list)
    energies: list[Energies] = field(default_factory=list)

    @property
    def has_all_inputs(self) -> bool:
        """They begin at power-up, so they can be run again."""
        return bool(self.inputs) and self.inputs[0].kind == "stored"

    def save(self, path: str | Path) -> None:
        """Write the telemetry as a table: Parquet or CSV, by the ending of the path's name.

        Raises
        ------
        torsio.Error
            If the ending is another one, or pyarrow is missing for Parquet.
        OSError
            If it cannot be written, whole; a table that was there before is then still there.
        """
        ending = Path(path).suffix
        if ending == ".csv":
            rows = np.column_stack([self.telemetry[name].astype(object) for name in _COLUMNS])
            header = ",".join(_COLUMNS)
            with beside(path) as part:
                np.savetxt(part, rows, fmt="%s", delimiter=",", header=header, comments="")
        elif ending == ".parquet":
            try:
                import pyarrow as pa
                from pyarrow import parquet
            except ModuleNotFoundError as error:
                raise Error(f"Parquet needs pyarrow: {how_to_install('record')}") from error
            table = pa.table(
                {name: np.ascontiguousarray(self.telemetry[name]) for name in _COLUMNS}
            )
            with beside(path) as part:
                parquet.write_table(table, part)
        else:
            raise Error(f"{str(path)!r} ends in neither .csv nor .parquet")


_READ: Final[dict[str, Callable[[dict[str, Any], dict[str, Any]], Any]]] = {
    "telemetry": lambda row, _: tuple(row[name] for name in _COLUMNS),
    "energies": lambda row, _: Energies(**{name: row[name] for name in _FIELDS["energies"]}),
    "events": lambda row, times: {**row, **times},
    "device_events": lambda row, times: {**row, **times},
    "drop_outs": lambda row, _: row["samples_lost"],
    "reports": lambda row, _: (row["tick"], row["sent"], bytes.fromhex(row["bytes"])),
    "inputs": lambda row, _: DeviceInput(row["tick"], row["kind"], bytes.fromhex(row["bytes"])),
}
"""What `load` makes of a message of a topic and of its times; fields that it does not know stay."""


def load(path: str | Path) -> Recorded:
    """Read a recording, also one that was torn in the middle.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    torsio.Error
        If it is no recording of Torsio, has samples that none can be, or is of a version whose
        messages lack something.
    """
    try:
        from mcap.records import Channel, Footer, Message, Metadata
        from mcap.stream_reader import StreamReader
    except ModuleNotFoundError as error:
        raise _missing() from error
    topics: dict[int, str] = {}
    found: dict[str, list[Any]] = {topic: [] for topic in _TOPICS}
    metadata: dict[str, dict[str, Any]] = {}
    whole = False
    with Path(path).open("rb") as file, _explained(path, metadata):
        reader = StreamReader(file, validate_crcs=True, record_size_limit=2**28)
        for record in _until_torn(reader.records):
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            elif isinstance(record, Metadata):
                metadata[record.name] = {k: json.loads(v) for k, v in record.metadata.items()}
            elif isinstance(record, Message) and topics.get(record.channel_id) in found:
                topic = topics[record.channel_id]
                found[topic].append(_READ[topic](json.loads(record.data), _times(record, metadata)))
            elif isinstance(record, Footer):
                whole = True
        if "versions" not in metadata:
            raise Error(f"{str(path)!r} is no recording of Torsio, or was torn before it began")
        return Recorded(
            telemetry=np.array(found["telemetry"], TELEMETRY_DTYPE),
            samples_lost=sum(found["drop_outs"]),
            metadata=metadata,
            whole=whole,
            **{name: found[name] for name in found.keys() - {"telemetry", "drop_outs"}},
        )


def _until_torn(records: Iterable[Any]) -> Iterator[Any]:
    """Give the records before the place where the bytes are torn or damaged."""
    try:
        yield from records
    except OSError:  # the bytes cannot be read at all
        raise
    except Exception:  # whatever the reader and its parts like to raise of such bytes
        return


def _times(message: Any, metadata: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Give when a message was written, by both clocks."""
    at_ns = message.log_time - metadata.get("clock", {}).get("host_minus_device_ns", 0)
    return {"device_time_s": 1e-9 * at_ns, "host_time_ns": message.publish_time}


@contextlib.contextmanager
def _explained(path: str | Path, metadata: Mapping[str, Mapping[str, Any]]) -> Iterator[None]:
    """Say what is wrong with a recording whose bytes are whole."""
    try:
        yield
    except KeyError as error:
        by = metadata.get("versions", {}).get("torsio", "another version")
        raise Error(
            f"{str(path)!r} was written by Torsio {by}, and a message lacks {error}: read it with "
            f"that version; this is {version('torsio')}"
        ) from error
    except (AttributeError, OverflowError, TypeError, ValueError, RecursionError) as error:
        raise Error(f"{str(path)!r} is damaged: a message is none ({error})") from error
