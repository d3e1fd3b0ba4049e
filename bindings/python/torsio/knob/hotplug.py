"""Notice of knobs that are plugged in and pulled out."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from torsio import _torsio
from torsio.common import checks
from torsio.common.worker import Worker
from torsio.errors import Error
from torsio.printed.told import ListedDevice

__all__ = ["DeviceEvent", "DeviceWatch", "watch"]

_LONGEST_S = 1e9  # thirty years


@dataclass(frozen=True)
class DeviceEvent:
    """A knob was plugged in or pulled out.

    Attributes
    ----------
    device
        As `list_devices` has it, but without `board`: a watch never opens the device, so you can.
    """

    kind: Literal["arrived", "departed"]
    device: ListedDevice


class DeviceWatch:
    """Arrivals and departures of knobs, made by `torsio.watch`. Use it in a ``with`` statement.

    An iterator, unless there is a callback. Every method may be called from any thread; those that
    wait let other threads run and can be interrupted with Ctrl-C.
    """

    def __init__(
        self,
        callback: Callable[[DeviceEvent], object] | None,
        timeout_s: float,
        include_present: bool,
        permission_timeout_s: float,
    ) -> None:
        self._watch = _torsio.DeviceWatch(
            include_present=include_present, permission_timeout_s=permission_timeout_s
        )
        self._timeout_s = timeout_s
        self._callback = callback
        self._failure: BaseException | None = None
        self._worker: Worker | None = None
        self._ident = 0  # of its thread
        if callback is not None:
            self._worker = Worker(self._run)
            self._worker.start()

    def __enter__(self) -> DeviceWatch:
        """Give the watch itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the watch."""
        self.stop()

    def __iter__(self) -> DeviceWatch:
        """Give the watch itself. Raises `Error` if it has a callback, which gets the events."""
        if self._worker is not None:
            raise Error("this watch has a callback, which gets the events; make another to iterate")
        return self

    def __next__(self) -> DeviceEvent:
        """Wait for the next event, until the time-out or `stop`."""
        event = self.next(timeout_s=self._timeout_s)
        if event is None:
            raise StopIteration
        return event

    def next(self, timeout_s: float = 1.0) -> DeviceEvent | None:
        """Take the oldest event, and wait for one; None if the time is over or the watch stopped.

        Raises `Error` if it has a callback, which gets the events.
        """
        if self._worker is not None:
            raise Error("this watch has a callback, which gets the events; make another to ask")
        return self._next(checks.number("timeout_s", timeout_s, 0.0, _LONGEST_S))

    def _next(self, timeout_s: float) -> DeviceEvent | None:
        event = self._watch.next(timeout_s)
        return None if event is None else DeviceEvent(event[0], ListedDevice(**event[1]))

    def _run(self) -> None:
        assert self._callback is not None
        self._ident = threading.get_ident()
        try:
            while (event := self._next(_LONGEST_S)) is not None and not self._watch.is_stopped:
                self._callback(event)
        except BaseException as error:  # any exception belongs to the caller of stop()
            self._failure = error
            self._watch.stop()

    def stop(self) -> None:
        """End the watch. Stopping twice is fine.

        When it returns no callback runs any more, except when the callback itself calls it. Raises
        what the callback raised, once.
        """
        self._watch.stop()
        if self._worker is not None and self._ident != threading.get_ident():
            self._worker.join()
            failure, self._failure = self._failure, None
            if failure is not None:
                raise failure

    @property
    def is_stopped(self) -> bool:
        """True after `stop`, and when an error in the callback has ended the watch."""
        return self._watch.is_stopped


def watch(
    callback: Callable[[DeviceEvent], object] | None = None,
    *,
    timeout_s: float | None = None,
    include_present: bool = True,
    permission_timeout_s: float = 2.0,
) -> DeviceWatch:
    """Watch for knobs that arrive and depart, from now on.

    Without a callback this is an iterator of `DeviceEvent`:

    >>> for event in torsio.watch(timeout_s=0.1):
    ...     print(event.kind, event.device.serial)

    It costs next to nothing while nothing happens. It does not tell of emulated knobs.

    Parameters
    ----------
    callback
        Called with each `DeviceEvent`, one after the other, from a thread of the watch; it may open
        knobs and stop the watch. Its exception ends the watch, and `DeviceWatch.stop` raises it.
    timeout_s
        The iteration ends when nothing came or went for so long; None goes on for ever.
    include_present
        Report the knobs that are there already as arrivals, first of all.
    permission_timeout_s
        How long a knob that may not be opened yet is held back, 0 to 60: udev sets the permission a
        moment after the device appears. Past this time it is reported with its `problem`, and once
        more when it can be opened.

    Raises
    ------
    InvalidArgument
        Names the argument.
    """
    if callback is not None:
        checks.function("callback", callback)
    return DeviceWatch(
        callback,
        _LONGEST_S if timeout_s is None else checks.number("timeout_s", timeout_s, 0.0, _LONGEST_S),
        checks.flag("include_present", include_present),
        checks.number("permission_timeout_s", permission_timeout_s, 0.0, 60.0),
    )
