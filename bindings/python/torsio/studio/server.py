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
from collections.abc import Callable
from pathlib import Path

import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.routing import Mount, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from torsio import _torsio
from torsio.errors import Error
from torsio.protocol import encode
from torsio.studio.bridge import Bridge, MessageError

__all__ = ["application", "serve"]

HOST = "127.0.0.1"
# Codes of a close that are free for programs; the reason is what the page shows.
_REFUSED, _GONE = 4403, 4404
_LONGEST_REASON = 120
_HANDOVER_S = 2.0


class _Studio:
    """Lets one page at a time at the knob."""

    def __init__(self, selector: str, token: str) -> None:
        self._selector = selector
        self._token = token
        self._busy = asyncio.Lock()

    async def connect(self, socket: WebSocket) -> None:
        await socket.accept()
        if reason := self._refusal(socket):
            await socket.close(_REFUSED, reason)
            return
        try:
            # A page that is loaded again comes before its old self has quite gone.
            await asyncio.wait_for(self._busy.acquire(), _HANDOVER_S)
        except asyncio.TimeoutError:
            await socket.close(_REFUSED, "another page has the knob: close it first")
            return
        try:
            await self._serve(socket)
        finally:
            self._busy.release()

    async def _serve(self, socket: WebSocket) -> None:
        try:
            transport = await asyncio.to_thread(_torsio.Transport, self._selector)
        except Error as error:
            await socket.close(_GONE, str(error)[:_LONGEST_REASON])
            return
        bridge = Bridge(transport)
        try:
            await self._pass_on(bridge, socket)
        finally:
            with contextlib.suppress(Exception):  # the device may be what is gone
                await asyncio.to_thread(transport.write, encode("command", {"op": "disarm"}))
            await asyncio.to_thread(bridge.close)

    def _refusal(self, socket: WebSocket) -> str:
        host = socket.headers.get("host", "")
        if socket.headers.get("origin") != f"http://{host}":
            return "this page comes from another place; open the address that torsio studio printed"
        token = socket.query_params.get("token", "")
        if not hmac.compare_digest(token.encode(), self._token.encode()):
            return "the token is not the right one: open the address that torsio studio printed"
        return ""

    async def _pass_on(self, bridge: Bridge, socket: WebSocket) -> None:
        title = f"{self._selector or 'knob'}, held by torsio studio"
        await socket.send_text(json.dumps({"title": title, "read_only": False}))
        pump = asyncio.create_task(bridge.pump(socket.send_bytes))
        answer = asyncio.create_task(_answer(bridge, socket))
        done, others = await asyncio.wait({pump, answer}, return_when=asyncio.FIRST_COMPLETED)
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)
        for task in done:
            error = task.exception()
            if error is not None and not isinstance(error, WebSocketDisconnect | RuntimeError):
                with contextlib.suppress(RuntimeError, WebSocketDisconnect):
                    await socket.close(_GONE, str(error)[:_LONGEST_REASON])


async def _answer(bridge: Bridge, socket: WebSocket) -> None:
    while True:
        try:
            answer = await bridge.answer(await socket.receive_bytes())
        except KeyError:
            raise MessageError("a page sent text where bytes belong") from None
        if answer is not None:
            await socket.send_bytes(answer)


def application(selector: str, page: Path, token: str) -> Starlette:
    """Make the server's application: the page in a folder, and a device behind a token."""
    studio = _Studio(selector, token)
    return Starlette(
        routes=[
            WebSocketRoute("/knob", studio.connect),
            Mount("/", StaticFiles(directory=page, html=True)),
        ],
        # Another name for this host would be a way round the origin's check.
        middleware=[Middleware(TrustedHostMiddleware, allowed_hosts=["127.0.0.1", "localhost"])],
    )


class _Server(uvicorn.Server):
    """Says where it listens, once it does."""

    def __init__(self, config: uvicorn.Config, ready: Callable[[int], None]) -> None:
        super().__init__(config)
        self._ready = ready

    async def startup(self, sockets: object = None) -> None:
        await super().startup()
        if self.started:
            self._ready(self.servers[0].sockets[0].getsockname()[1])


def serve(selector: str, page: Path, port: int, ready: Callable[[str], None]) -> None:
    """Serve until interrupted; tell `ready` the address, with its token.

    Raises
    ------
    torsio.Error
        If nobody may listen on this port.
    """
    token = secrets.token_urlsafe(16)
    config = uvicorn.Config(
        application(selector, page, token),
        host=HOST,
        port=port,
        log_level="error",
        ws="websockets-sansio",
        ws_max_size=1024,
        timeout_graceful_shutdown=2,
    )
    server = _Server(config, lambda chosen: ready(f"http://{HOST}:{chosen}/?token={token}"))
    try:
        server.run()
    except SystemExit:
        raise Error(f"port {port} of this machine is in use; choose another with --port") from None
