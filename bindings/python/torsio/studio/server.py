"""The local server: the page's files, and the knob over a WebSocket.

It listens on loopback alone. A page of another origin is not let in, and neither is one without the
token that stands in the address which was printed.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import json
import secrets
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.routing import Mount, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from torsio import _torsio
from torsio.common.emulated import selects_emulated
from torsio.errors import Error
from torsio.knob import Knob
from torsio.knob.opening import open as open_knob
from torsio.printed.emulator_options import EmulatorOptions
from torsio.studio.bridge import KEPT_REPORTS, Bridge, MessageError, World, arms, lets_go
from torsio.studio.calibrating import calibrate_for

__all__ = ["GONE", "Emulated", "Server", "application", "pass_on", "refusal", "serve"]

HOST = "127.0.0.1"
# Codes of a close that are free for programs; the reason is what the page shows.
_REFUSED, GONE = 4403, 4404
_LONGEST_REASON = 120
_HANDOVER_S = 2.0
# Its page is there in real time.
_OPTIONS = EmulatorOptions(control_rate_hz=4000.0, paced=True, log_truth=True)
_CALIBRATED = EmulatorOptions()


@dataclass(frozen=True)
class Emulated:
    """An emulated knob for pages.

    Attributes
    ----------
    options
        As the page has it: in real time, which needs `paced` and `log_truth`.
    calibrated
        As a calibration has it.
    happen
        Is called with the world round each: a new transport, or an `Emulator`.
    """

    options: EmulatorOptions = _OPTIONS
    calibrated: EmulatorOptions = _CALIBRATED
    happen: Callable[[Any], object] = lambda world: None


_DEFAULT = Emulated()
Serve = Callable[[WebSocket], Awaitable[None]]
"""Handles a page until it goes."""


class _Studio:
    """Lets one page at a time at the knob."""

    def __init__(self, selector: str, emulated: Emulated) -> None:
        self._selector = selector
        self._emulated = emulated if selects_emulated(selector) else None
        self._busy = asyncio.Lock()

    async def connect(self, socket: WebSocket) -> None:
        """Pass the knob on to a page."""
        await self._alone(socket, self._serve)

    async def calibrate(self, socket: WebSocket) -> None:
        """Measure the knob for a page, which has let go of it."""
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await self._alone(socket, lambda page: calibrate_for(page, self._open))
            await socket.close()

    def _open(self) -> Knob:
        if self._emulated is None:
            return open_knob(self._selector or None)
        knob = open_knob(self._selector, emulator=self._emulated.calibrated)
        self._emulated.happen(knob.emulator)
        return knob

    async def _alone(self, socket: WebSocket, serve: Serve) -> None:
        try:
            # A page that is loaded again comes before its old self has quite gone.
            await asyncio.wait_for(self._busy.acquire(), _HANDOVER_S)
        except asyncio.TimeoutError:
            await socket.close(_REFUSED, "another page has the knob: close it first")
            return
        try:
            await serve(socket)
        finally:
            self._busy.release()

    async def _serve(self, socket: WebSocket) -> None:
        emulator = self._emulated.options if self._emulated else None
        try:
            transport = await asyncio.to_thread(_torsio.Transport, self._selector, emulator)
        except Error as error:
            await socket.close(GONE, str(error)[:_LONGEST_REASON])
            return
        if self._emulated is not None:
            self._emulated.happen(transport)
        bridge = Bridge(transport, World(transport) if emulator else None)
        title = f"{self._selector or 'knob'}, held by torsio studio"
        try:
            await pass_on(
                bridge, socket, title=title, read_only=False, is_emulated=emulator is not None
            )
        finally:
            await asyncio.to_thread(bridge.close)


def refusal(socket: WebSocket, token: str) -> str:
    """Say why a page may not in; empty if it may."""
    host = socket.headers.get("host", "")
    if socket.headers.get("origin") != f"http://{host}":
        return "this page comes from another place; open the address that torsio studio printed"
    if not hmac.compare_digest(socket.query_params.get("token", "").encode(), token.encode()):
        return "the token is not the right one: open the address that torsio studio printed"
    return ""


class Passed(Protocol):
    """A page's connection."""

    async def pump(self, send: Callable[[bytes], Awaitable[None]]) -> None:
        """Hand on what the device says, for ever."""

    async def answer(self, message: bytes) -> bytes | None:
        """Do what a page asks; give what it is to be told."""


async def pass_on(
    bridge: Passed, socket: WebSocket, *, title: str, read_only: bool, is_emulated: bool = False
) -> None:
    """Connect a page until it goes, or what it is connected to; it turns an emulated knob."""
    hello = {"title": title, "read_only": read_only, "is_emulated": is_emulated}
    await socket.send_text(json.dumps(hello))
    pump = asyncio.create_task(bridge.pump(socket.send_bytes))
    waiting: asyncio.Queue[bytes] = asyncio.Queue(KEPT_REPORTS)
    receive = asyncio.create_task(_receive(bridge, socket, waiting))
    answer = asyncio.create_task(_answer(bridge, socket, waiting))
    tasks = {pump, receive, answer}
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    for task in done:
        error = task.exception()
        # The server's library raises these two when the page has gone. The knob's errors are
        # RuntimeErrors too.
        has_gone = isinstance(error, WebSocketDisconnect | RuntimeError)
        if isinstance(error, Error) or (error is not None and not has_gone):
            with contextlib.suppress(RuntimeError, WebSocketDisconnect):
                await socket.close(GONE, str(error)[:_LONGEST_REASON])


async def _receive(bridge: Passed, socket: WebSocket, waiting: asyncio.Queue[bytes]) -> None:
    """Take a page's messages; those that take the torque off pass the others."""
    while True:
        try:
            message = await socket.receive_bytes()
        except KeyError:
            raise MessageError("a page sent text where bytes belong") from None
        if not lets_go(message):
            await waiting.put(message)
            continue
        # No older one may put it on again.
        for older in [waiting.get_nowait() for _ in range(waiting.qsize())]:
            if not arms(older):
                waiting.put_nowait(older)
        await bridge.answer(message)


async def _answer(bridge: Passed, socket: WebSocket, waiting: asyncio.Queue[bytes]) -> None:
    while True:
        if (answer := await bridge.answer(await waiting.get())) is not None:
            await socket.send_bytes(answer)


def application(serves: Mapping[str, Serve], page: Path, token: str) -> Starlette:
    """Make the server's application: the page in a folder, and what is behind the token."""

    def gated(serve: Serve) -> Serve:
        async def gate(socket: WebSocket) -> None:
            await socket.accept()
            if reason := refusal(socket, token):
                await socket.close(_REFUSED, reason)
                return
            await serve(socket)

        return gate

    return Starlette(
        routes=[
            *(WebSocketRoute(f"/{name}", gated(serve)) for name, serve in serves.items()),
            Mount("/", StaticFiles(directory=page, html=True)),
        ],
        # Another name for this host would be a way round the origin's check.
        middleware=[Middleware(TrustedHostMiddleware, allowed_hosts=["127.0.0.1", "localhost"])],
    )


class Server(uvicorn.Server):
    """Listens on loopback, and says where, once it does.

    Parameters
    ----------
    serves
        For each address, the function that is called with each admitted page.
    page
        The page's folder.
    port
        0 takes a free one.
    ready
        Is told the address, with its token.
    """

    def __init__(
        self,
        serves: Mapping[str, Serve],
        page: Path,
        port: int,
        ready: Callable[[str], None],
    ) -> None:
        self._token = secrets.token_urlsafe(16)
        self._ready = ready
        super().__init__(
            uvicorn.Config(
                application(serves, page, self._token),
                host=HOST,
                port=port,
                log_level="error",
                ws="websockets-sansio",
                ws_max_size=1024,
                timeout_graceful_shutdown=2,
            )
        )

    async def startup(self, sockets: object = None) -> None:
        """Listen."""
        await super().startup()
        if self.started:
            port = self.servers[0].sockets[0].getsockname()[1]
            self._ready(f"http://{HOST}:{port}/?token={self._token}")


def serve(
    selector: str,
    page: Path,
    port: int,
    ready: Callable[[str], None],
    emulated: Emulated = _DEFAULT,
) -> None:
    """Serve a device until interrupted; tell `ready` the address, with its token.

    Raises
    ------
    torsio.Error
        If nobody may listen on this port.
    """
    studio = _Studio(selector, emulated)
    try:
        Server({"knob": studio.connect, "calibration": studio.calibrate}, page, port, ready).run()
    except SystemExit:
        raise Error(f"port {port} of this machine is in use; choose another with --port") from None
