"""The file of a recording while it is written."""

from __future__ import annotations

import threading
import time
import weakref
from collections.abc import Callable, Iterable, Mapping
from itertools import repeat
from pathlib import Path
from typing import Any, Final, Protocol

from torsio import _torsio
from torsio.common.worker import exhaust
from torsio.errors import Closed, InvalidArgument
from torsio.recordings.messages import encoded
from torsio.recordings.writing import FileWriter
from torsio.telemetry import TELEMETRY_DTYPE

__all__ = ["RecordingFile", "Source"]

_LOOK_S: Final = 0.05
# Most bytes of telemetry that wait for the disk.
_MOST_WAITING_BYTES: Final = 64 * 1024 * 1024


class Source(Protocol):
    """The knob that is recorded. If it goes, the file ends."""

    def device_time_s(self) -> float:
        """Tell the device's time."""

    def take_rest(self) -> None:
        """Give the file what has come and nobody has read."""

    def disarm(self) -> None:
        """Order torque off, as `torsio.Knob.close` does first."""


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
        self.path: Final = Path(path)
        if self.path.suffix != ".mcap" and (self.path.is_file() or not self.path.exists()):
            raise InvalidArgument(f"a recording's name ends in .mcap, and {str(path)!r} does not")
        self._received = 0  # samples that are neither written nor waiting
        # The file must not keep the knob.
        self._source: Callable[[], Source | None] = weakref.ref(source)
        # The times of all messages are the device's, laid on the host's clock once.
        clock = {"host_minus_device_ns": time.time_ns() - round(1e9 * source.device_time_s())}
        self._takes_all = False
        self._is_waited_for = False
        self._is_open = True  # a signal's handler may set it at any time
        self.writer: Final = FileWriter(
            self.path, {"clock": clock, **metadata}, samples_lost, self._has_source
        )
        try:
            self.writer.start()
        except BaseException:
            self._end()
            raise

    def _has_source(self) -> bool:
        return self._source() is not None

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
        return self._is_open and self.writer.runs

    @property
    def samples(self) -> int:
        """Written so far."""
        return self.writer.samples

    @property
    def samples_lost(self) -> int:
        """Missing in the file so far: lost on the way, or because the disk was slow."""
        return self.writer.samples_lost

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
        self.writer.waiting.put(None)

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
        self.writer.join()
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
            self.put(
                self.writer.write_encoded, [("events", at_ns, encoded(message), time.time_ns())]
            )
        self.tell_failure()

    def put(self, write: Callable[[Any], None], values: Iterable[Any]) -> None:
        """Have one of the writer's methods write what an iterator gives; the knob calls it.

        No Python runs between the iterator and the queue, so no interrupt comes there.
        """
        exhaust(map(self.writer.waiting.put, zip(repeat(write), values)))

    def has_room(self, samples_received: int) -> bool:
        """Whether so many samples of the knob's may wait; the knob asks before it takes more."""
        if self.writer.waiting.empty():
            self._received = samples_received - self.samples
        waiting = samples_received - self._received - self.samples
        return self._takes_all or waiting * TELEMETRY_DTYPE.itemsize <= _MOST_WAITING_BYTES

    def wait_for_room(self, samples_received: int) -> None:
        """Wait until they may, or the file has ended."""
        while self.is_open and not self.has_room(samples_received):
            threading.Event().wait(_LOOK_S)

    def tell_failure(self) -> None:
        """Raise the error that ended the file, once; the knob calls it."""
        failure, self.writer.failure = self.writer.failure, None
        if failure is not None:
            raise failure


def _nothing() -> None:
    """Do nothing."""
