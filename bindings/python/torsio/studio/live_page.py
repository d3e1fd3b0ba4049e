"""A page that looks on while a program drives a knob."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import Final

from starlette.websockets import WebSocket

from torsio import _torsio
from torsio.common.worker import Worker
from torsio.errors import Closed, Error
from torsio.knob import Knob
from torsio.studio.bridge import (
    GET,
    GOT,
    HAVE,
    INPUT,
    MESSAGES_UNDER_WAY,
    STALLED,
    TOGETHER_S,
    MessageError,
)
from torsio.studio.server import Server, pass_on

__all__ = ["LivePage"]

_CLOSED: Final = "the program has closed its knob"


class _Onlooker:
    """One page; it has a tap of its own."""

    def __init__(self, knob: _torsio.Knob) -> None:
        self._knob = knob
        self._tap = knob.tap(with_telemetry=True)
        self._under_way = asyncio.Semaphore(MESSAGES_UNDER_WAY)

    async def pump(self, send: Callable[[bytes], Awaitable[None]]) -> None:
        """Hand on what the device says, for ever."""
        while True:
            await self._under_way.acquire()
            await send(bytes([INPUT]) + b"".join(await self._reports()))

    async def _reports(self) -> list[bytes]:
        while True:
            # Wait first: otherwise reports that came during the last send would go alone.
            await asyncio.sleep(TOGETHER_S)
            if reports := [content for _, sent, content in self._tap.take() if not sent]:
                return reports
            if not self._knob.is_open:
                raise Closed(_CLOSED)

    async def answer(self, message: bytes) -> bytes | None:
        """Tell a page what it asks for; nothing that it says reaches the device."""
        if message == bytes([HAVE]):
            self._under_way.release()
            return None
        if len(message) != 2 or message[0] != GET:
            raise MessageError("this page may only watch")
        try:
            return bytes([GOT]) + await asyncio.to_thread(self._knob.feature, message[1])
        except Closed:
            raise Closed(_CLOSED) from None
        except Error:
            return bytes([STALLED])


class LivePage:
    """A server of pages that look on; made by `torsio.live`.

    Closing it leaves the knob as it is.
    """

    address: str
    """To be opened in a browser of this machine."""

    def __init__(self, knob: Knob, page: Path, port: int) -> None:
        self._knob = knob
        ready = threading.Event()

        def told(address: str) -> None:
            self.address = address
            ready.set()

        self._server = Server({"knob": self._connect}, page, port, told)
        self._worker = Worker(partial(self._run, ready))
        self._failed = False
        self._worker.start()
        ready.wait()
        if self._failed:
            raise Error(f"port {port} of this machine is in use; choose another")

    def _run(self, ready: threading.Event) -> None:
        try:
            self._server.run()
        except SystemExit:
            self._failed = True
        finally:
            ready.set()

    async def _connect(self, socket: WebSocket) -> None:
        title = f"{self._knob.info.path}, driven by a program"
        await pass_on(_Onlooker(self._knob._knob), socket, title=title, read_only=True)

    def _repr_html_(self) -> str:
        return f'<iframe src="{self.address}" width="100%" height="720"></iframe>'

    def close(self) -> None:
        """End it; pages say that the connection is gone."""
        self._server.should_exit = True
        self._worker.join()

    def __enter__(self) -> LivePage:
        """Give the server itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()
