"""Recordings: what a knob did, in a file that Foxglove and PlotJuggler open too.

The file is MCAP, with JSON and its schemas in it. `torsio.Knob.record_to` writes one, `load` reads
it. Both need the extra ``record``.
"""

from __future__ import annotations

import contextlib
import html
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from torsio import _torsio
from torsio.common import checks
from torsio.common.extras import how_to_install
from torsio.common.notebook import Telemetry, picture
from torsio.common.whole_file import beside
from torsio.errors import Error, InvalidArgument
from torsio.printed.emulator_options import DeviceInput
from torsio.printed.told import Energies
from torsio.recordings.file import RecordingFile
from torsio.recordings.messages import COLUMNS, ENERGIES, TOPICS, LoggedReport
from torsio.recordings.writing import missing
from torsio.telemetry import TELEMETRY_DTYPE, Record

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["LoggedReport", "Recorded", "RecordingFile", "load"]


@dataclass(frozen=True, repr=False)
class Recorded:
    """Contents of a recording.

    Attributes
    ----------
    telemetry
        Rows of `torsio.telemetry.TELEMETRY_DTYPE`, shape (n,).
    events
        Orders and notes of the program, in order; each has ``kind``,
        ``device_time_s``, which is the telemetry's ``time_s``, and ``host_time_ns``, when it was
        written by the host's clock.
    device_events
        The device's own events: changes of state, faults, silence; with the same two times.
    reports
        Sent reports, acknowledgements and events, in order: the newest tick known then, whether it
        was sent, and the bytes. First comes the scene that played already, if the same program
        played it.
    inputs
        Inputs of the device from its power-up on, or from the end of an earlier recording, if it
        was an emulated one that was opened with ``EmulatorOptions(log_inputs=True)``.
    samples_lost
        Samples that never arrived.
    metadata
        The knob's identity, its configuration, the versions.
    energies
        Where the energy went, up to eight times a second as the program read, and at the end; empty
        while another law than ``"calibrated"`` was chosen.
    whole
        False if the file ends in the middle, as its program did. Earlier samples are here.
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

    def __repr__(self) -> str:
        """Say how much there is."""
        spans = np.ptp(self.telemetry["time_s"]) if len(self.telemetry) else 0.0
        torn = "" if self.whole else ", torn"
        return (
            f"<torsio.Recorded {len(self.telemetry)} samples, {spans:.3g} s, "
            f"{self.samples_lost} lost, {len(self.events)} events{torn}>"
        )

    def _repr_html_(self) -> str:
        return f"<p>{html.escape(repr(self))}</p>{picture(self.telemetry)}"

    def plot(self) -> Figure:
        """Draw the telemetry: `torsio.Telemetry.plot`."""
        return self.telemetry.view(Telemetry).plot()

    def save(self, path: str | Path, *, separator: str = ",", decimal: str = ".") -> None:
        """Write the telemetry as a table: Parquet or CSV, by the ending of the path's name.

        Parameters
        ----------
        separator, decimal
            For CSV; spreadsheets of many countries read ``";"`` and ``","``. A separator is one of
            ``, ; |``, a tab or a blank.

        Raises
        ------
        torsio.Error
            If the ending is another one, or pyarrow is missing for Parquet.
        OSError
            If it cannot be written, whole; a table that was there before is then still there.
        """
        ending = checks.path("path", path).suffix
        if ending == ".csv":
            if decimal not in (".", ",") or separator == decimal or separator not in _SEPARATORS:
                raise InvalidArgument(
                    f"separator and decimal are {separator!r} and {decimal!r}; allowed are one of "
                    f"{', '.join(map(repr, _SEPARATORS))}, and another one of '.' and ','"
                )
            columns = (self.telemetry[name].astype(object) for name in COLUMNS)
            rows = np.column_stack([[str(v).replace(".", decimal) for v in of] for of in columns])
            header = separator.join(COLUMNS)
            with beside(path) as part:
                np.savetxt(part, rows, fmt="%s", delimiter=separator, header=header, comments="")
        elif ending == ".parquet":
            try:
                import pyarrow as pa
                from pyarrow import parquet
            except ModuleNotFoundError as error:
                raise Error(f"Parquet needs pyarrow: {how_to_install('record')}") from error
            table = pa.table({name: np.ascontiguousarray(self.telemetry[name]) for name in COLUMNS})
            with beside(path) as part:
                parquet.write_table(table, part)
        else:
            raise Error(f"{str(path)!r} ends in neither .csv nor .parquet")


_SEPARATORS: Final = (",", ";", "\t", "|", " ")
_READ: Final[dict[str, Callable[[dict[str, Any], dict[str, Any]], Any]]] = {
    "telemetry": lambda row, _: tuple(row[name] for name in COLUMNS),
    "energies": lambda row, _: Energies(**{name: row[name] for name in ENERGIES}),
    "events": lambda row, times: {**row, **times},
    "device_events": lambda row, times: {**row, **times},
    "drop_outs": lambda row, _: row["samples_lost"],
    "reports": lambda row, _: (row["tick"], row["sent"], bytes.fromhex(row["bytes"])),
    "inputs": lambda row, _: DeviceInput(row["tick"], row["kind"], bytes.fromhex(row["bytes"])),
}
"""`load` makes this of a topic's message and its times. Unknown fields stay."""

# More is no recording but a file that fills the memory: of a chunk, and of all that is read for
# each of its bytes. Telemetry of a knob at rest unpacks to 19.
_MOST_BYTES: Final = 64 * 1024 * 1024
_MOST_BYTES_OF_ONE: Final = 400


def load(path: str | Path) -> Recorded:
    """Read a recording, also one that was torn in the middle.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    torsio.Error
        The file is no recording of Torsio, has impossible samples, lacks fields, or would fill the
        memory.
    """
    try:
        from mcap.records import Channel, Footer, Message, Metadata
        from mcap.stream_reader import StreamReader
    except ModuleNotFoundError as error:
        raise missing() from error
    path = checks.path("path", path)
    topics = dict(enumerate(TOPICS, 1))  # as they are written; the first chunk tells it, if whole
    found: dict[str, list[Any]] = {topic: [] for topic in TOPICS}
    metadata: dict[str, dict[str, Any]] = {}
    damaged, whole = False, False
    with path.open("rb") as file, _explained(path, metadata):
        reader = StreamReader(
            file, emit_chunks=True, validate_crcs=True, record_size_limit=_MOST_BYTES
        )
        for record in _until_torn(_unpacked(path, reader.records)):
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            elif isinstance(record, Metadata):
                metadata[record.name] = {k: json.loads(v) for k, v in record.metadata.items()}
            elif isinstance(record, Message) and topics.get(record.channel_id) in found:
                topic = topics[record.channel_id]
                found[topic].append(_READ[topic](json.loads(record.data), _times(record, metadata)))
            elif record is None:
                damaged = True
            elif isinstance(record, Footer):
                whole = not damaged
        if "versions" not in metadata:
            raise Error(f"{str(path)!r} is no recording of Torsio, or was torn before it began")
        rows, lost = found.pop("telemetry"), found.pop("drop_outs")
        telemetry = np.array(rows, TELEMETRY_DTYPE).view(Telemetry)
        return Recorded(telemetry, samples_lost=sum(lost), metadata=metadata, whole=whole, **found)


def _unpacked(path: str | Path, records: Iterable[Any]) -> Iterator[Any]:
    """Give the records of chunks too, of each as soon as it is known not to fill the memory.

    None stands for a chunk that is damaged.
    """
    import zstandard
    from mcap.records import Chunk
    from mcap.stream_reader import breakup_chunk

    room = _MOST_BYTES
    for record in records:
        if not isinstance(record, Chunk):
            yield record
            continue
        try:
            size = record.uncompressed_size
            if record.compression == "zstd":
                # An unpacker believes this one first.
                size = max(size, zstandard.frame_content_size(record.data))
            room += _MOST_BYTES_OF_ONE * len(record.data) - size
            if record.compression not in ("", "zstd") or size > _MOST_BYTES or room < 0:
                raise Error(
                    f"{str(path)!r} would fill the memory: it unpacks to {size} bytes and more"
                )
            unpacked: list[Any] = [*breakup_chunk(record, validate_crc=True)]
        except Error:
            raise
        except Exception:  # this chunk is damaged; the next one need not be
            unpacked = [None]
        yield from unpacked


def _until_torn(records: Iterable[Any]) -> Iterator[Any]:
    """Give the records before the place where the bytes are torn or damaged."""
    try:
        yield from records
    except (OSError, Error):  # the bytes cannot be read at all, or must not be
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
            f"that version; this is {_torsio.__version__}"
        ) from error
    except (AttributeError, OverflowError, TypeError, ValueError, RecursionError) as error:
        raise Error(f"{str(path)!r} is damaged: a message cannot be read ({error})") from error
