"""A knob passed on to one page: reports as they are, with a byte in front that says which way.

The device's come several in a message, one behind the other. The page says when it `HAVE`s one.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Final

from torsio import _torsio
from torsio.errors import Error

__all__ = [
    *("GET", "GOT", "HAVE", "INPUT", "SET", "STALLED", "TAKEN", "WRITE"),
    *("KEPT_REPORTS", "MESSAGES_UNDER_WAY", "TOGETHER_S", "Bridge", "MessageError", "Waiting"),
]

# First byte of every message; studio/src/bridge_transport.ts has the same.
WRITE: Final = 0
INPUT: Final = 1
GET: Final = 2
SET: Final = 3
GOT: Final = 4
STALLED: Final = 5
TAKEN: Final = 6
HAVE: Final = 7

# Of what a page may send: bytes behind the first.
_LENGTHS: Final = {WRITE: 64, GET: 1, SET: 64, HAVE: 0}
_TELEMETRY: Final = 0x40
_READ_S: Final = 0.02
# More than a page holds of curves.
KEPT_REPORTS: Final = 8192
MESSAGES_UNDER_WAY: Final = 2
# Telemetry waits so long for what follows: a picture's worth at a time costs the page least.
TOGETHER_S: Final = 0.034


class MessageError(Error):
    """A page sent what is no message of the bridge."""


class Waiting:
    """Reports of the device that no page has yet; put in by one thread, taken by the loop's.

    A page that is slow loses telemetry, the oldest first, and sees in its ticks that it did.
    Answers and events are never lost.
    """

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._lock = threading.Lock()
        self._reports: deque[bytes] = deque()
        self._error: Exception | None = None
        self._news = asyncio.Event()
        self._urgent = asyncio.Event()

    def put(self, report: bytes) -> None:
        """Keep a report."""
        with self._lock:
            self._reports.append(report)
            if len(self._reports) > KEPT_REPORTS:
                telemetry = (i for i, kept in enumerate(self._reports) if kept[0] == _TELEMETRY)
                del self._reports[next(telemetry, 0)]
            is_first = len(self._reports) == 1
        if is_first or report[0] != _TELEMETRY:
            self._tell(urgent=report[0] != _TELEMETRY)

    def end(self, error: Exception) -> None:
        """Raise this once all reports are taken."""
        self._error = error
        self._tell(urgent=True)

    def _tell(self, *, urgent: bool) -> None:
        # While the program ends the loop may have gone first.
        if not self._loop.is_closed():
            for event in (self._news, self._urgent) if urgent else (self._news,):
                self._loop.call_soon_threadsafe(event.set)

    async def take(self) -> list[bytes]:
        """Wait for reports and take all, oldest first; telemetry alone is given time to gather."""
        with contextlib.suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._urgent.wait(), TOGETHER_S)
        while True:
            self._news.clear()
            self._urgent.clear()
            with self._lock:
                taken = list(self._reports)
                self._reports.clear()
            if taken:
                return taken
            if self._error is not None:
                raise self._error
            await self._news.wait()


class Bridge:
    """One open device, and the page at the other end.

    The device is read in a thread of its own. What it says goes to the page in as few messages as
    the page is quick: a new one when it has an older one.
    """

    def __init__(self, transport: _torsio.Transport) -> None:
        self._transport = transport
        self._waiting = Waiting()
        self._under_way = asyncio.Semaphore(MESSAGES_UNDER_WAY)
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._read, name="torsio-studio", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Let go of the device."""
        self._closed.set()
        self._thread.join()
        self._transport.close()

    def _read(self) -> None:
        try:
            while not self._closed.is_set():
                report = self._transport.read(_READ_S)
                if report is not None:
                    self._waiting.put(report)
        except Exception as error:
            self._waiting.end(error)

    async def pump(self, send: Callable[[bytes], Awaitable[None]]) -> None:
        """Hand on what the device says, for ever. Raises what reading the device raises."""
        while True:
            await self._under_way.acquire()
            await send(bytes([INPUT]) + b"".join(await self._waiting.take()))

    async def answer(self, message: bytes) -> bytes | None:
        """Do what a page asks; give what it is to be told.

        Raises
        ------
        MessageError
            If it is no message; nothing was done.
        """
        kind, report = (message[0], message[1:]) if message else (-1, b"")
        if _LENGTHS.get(kind) != len(report):
            raise MessageError(f"a message of {len(message)} bytes that begins with {kind}")
        if kind == HAVE:
            self._under_way.release()
            return None
        if kind == GET:
            got = await asyncio.to_thread(self._transport.get_feature, report[0])
            return bytes([STALLED]) if got is None else bytes([GOT]) + got
        if kind == SET:
            taken = await asyncio.to_thread(self._transport.set_feature, report)
            return bytes([TAKEN if taken else STALLED])
        while not await asyncio.to_thread(self._transport.write, report):
            await asyncio.sleep(1e-3)  # a full queue empties by one report a millisecond
        return None
