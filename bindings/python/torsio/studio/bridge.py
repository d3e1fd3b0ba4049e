"""A knob passed on to one page: reports as they are, with a byte in front that says which way."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable
from typing import Final

from torsio import _torsio
from torsio.errors import Error

__all__ = ["GET", "GOT", "INPUT", "SET", "STALLED", "TAKEN", "WRITE", "Bridge"]

# First byte of every message; studio/src/bridge_transport.ts has the same.
WRITE: Final = 0
INPUT: Final = 1
GET: Final = 2
SET: Final = 3
GOT: Final = 4
STALLED: Final = 5
TAKEN: Final = 6

_REPORT_BYTES = 64
_READ_S = 0.02
_QUEUED_REPORTS = 20_000


class MessageError(Error):
    """A page sent what is no message of the bridge."""


class Bridge:
    """One open device, and the page at the other end.

    The device is read in a thread of its own, so that a page that is slow loses nothing until the
    queue is full.
    """

    def __init__(self, transport: _torsio.Transport) -> None:
        self._transport = transport
        self._loop = asyncio.get_running_loop()
        self._inputs: asyncio.Queue[bytes | Exception] = asyncio.Queue()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._read, name="torsio-studio", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Disarm, and let go of the device."""
        self._closed.set()
        self._thread.join()
        self._transport.close()

    def _read(self) -> None:
        while not self._closed.is_set():
            try:
                report = self._transport.read(_READ_S)
            except Exception as error:
                self._put(error)
                return
            if report is not None:
                self._put(report)

    def _put(self, item: bytes | Exception) -> None:
        # While the program ends the loop may have gone first.
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._inputs.put_nowait, item)

    async def pump(self, send: Callable[[bytes], Awaitable[None]]) -> None:
        """Hand on what the device says, for ever. Raises what reading the device raises."""
        while True:
            item = await self._inputs.get()
            if isinstance(item, Exception):
                raise item
            if self._inputs.qsize() > _QUEUED_REPORTS:
                raise Error("the page is too slow for this knob's telemetry; load it again")
            await send(bytes([INPUT]) + item)

    async def answer(self, message: bytes) -> bytes | None:
        """Do what a page asks; give what it is to be told.

        Raises
        ------
        MessageError
            If it is no message; nothing was done.
        """
        kind, report = (message[0], message[1:]) if message else (-1, b"")
        expected = 1 if kind == GET else _REPORT_BYTES
        if kind not in (WRITE, GET, SET) or len(report) != expected:
            raise MessageError(f"a message of {len(message)} bytes that begins with {kind}")
        if kind == GET:
            got = await asyncio.to_thread(self._transport.get_feature, report[0])
            return bytes([STALLED]) if got is None else bytes([GOT]) + got
        if kind == SET:
            taken = await asyncio.to_thread(self._transport.set_feature, report)
            return bytes([TAKEN if taken else STALLED])
        while not await asyncio.to_thread(self._transport.write, report):
            await asyncio.sleep(1e-3)  # a full queue empties by one report a millisecond
        return None
