"""A calibration that a page asks for: it sees each step and the result, and says what then.

Messages are JSON. The server says `step`, then `found` or `refused`, and `kept` at last; the page
says `calibrate`, and after it has `found` something perhaps `keep`. If it goes, the knob stops.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import partial
from pathlib import Path
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from torsio import calibration
from torsio.calibration import report
from torsio.errors import Error
from torsio.knob import Knob

__all__ = ["calibrate_for", "described"]

# A picture in a page shows no more.
_MOST_POINTS = 600
_AGAIN_S = 0.02


class _Stopped(Exception):
    """The page has gone, or has said stop."""


def _points(fit: calibration.Fit) -> dict[str, Any]:
    """Give a fit's data and model, thinned, with the digits that a picture shows."""
    step = -(-len(fit.x) // _MOST_POINTS)
    columns = {name: getattr(fit, name)[::step] for name in ("x", "measured", "fitted")}
    return {
        "title": fit.title,
        "x_label": fit.x_label,
        "y_label": fit.y_label,
        "residual_rms": fit.residual_rms,
        **{name: [float(f"{value:.5g}") for value in of] for name, of in columns.items()},
    }


def described(knob: Knob, found: calibration.Calibration) -> dict[str, Any]:
    """Give what a page shows of a result: values, drift, pictures, and what is proposed."""
    before = calibration.kept(knob.info.serial)
    changed = [] if before is None else calibration.drifts(before, found)
    return {
        "kind": "found",
        "seconds": found.seconds,
        "quantities": [(name, value, about) for name, value, _, about in report.lines(found)],
        "changes": report.proposals(knob, found),
        "compared_with": None if before is None else before["conditions"].get("date", ""),
        "drifted": [[drift.name, drift.before, drift.now] for drift in changed],
        "fits": [_points(fit) for fit in found.fits],
    }


def _keep(knob: Knob, found: calibration.Calibration) -> Path:
    calibration.apply(knob, found)
    knob.save()
    return calibration.keep(found)


async def _asked(socket: WebSocket) -> dict[str, Any]:
    """Receive what the page asks for: nothing, if it is no JSON object."""
    try:
        asked = json.loads(await socket.receive_text())
    except (ValueError, KeyError, RecursionError):
        return {}
    return asked if isinstance(asked, dict) else {}


async def calibrate_for(socket: WebSocket, open_knob: Callable[[], Knob]) -> None:
    """Open the knob, measure it as the page asks, and close it; the page may go at any moment.

    Without the page's `keep` nothing is changed.
    """
    asked = await _asked(socket)
    if asked.get("do") != "calibrate":
        await socket.send_json(
            {"kind": "refused", "why": "a page sent an unknown message about calibration"}
        )
        return
    try:
        knob = await asyncio.to_thread(open_knob)
    except Error as error:
        await socket.send_json({"kind": "refused", "why": str(error)})
        return
    loop, stopped = asyncio.get_running_loop(), threading.Event()
    # Nothing cancels its thread, so the knob is closed after all else.
    work = ThreadPoolExecutor(1)
    try:
        measure = partial(
            calibration.calibrate,
            knob,
            drift=asked.get("drift") is True,
            supply_v=asked.get("supply_v"),
            progress=partial(_tell, socket, loop, stopped),
        )
        found = await _unless_told(socket, loop.run_in_executor(work, measure))
        await socket.send_json(await loop.run_in_executor(work, described, knob, found))
        if (await _asked(socket)).get("do") == "keep":
            path = await loop.run_in_executor(work, _keep, knob, found)
            await socket.send_json({"kind": "kept", "path": str(path), "forgets": knob.is_emulated})
    except (calibration.Refusal, Error, TypeError) as error:  # TypeError: the supply is no number
        await socket.send_json({"kind": "refused", "why": str(error)})
    finally:
        stopped.set()
        await asyncio.to_thread(_stop_until, work.submit(knob.close), knob)


def _stop_until(closed: Future[None], knob: Knob) -> None:
    """Stop the knob again and again: a measurement may be about to arm it."""
    while not closed.done():
        with contextlib.suppress(Error):
            knob.stop()
        wait({closed}, _AGAIN_S)
    closed.result()


def _tell(
    socket: WebSocket, loop: asyncio.AbstractEventLoop, stopped: threading.Event, step: str
) -> None:
    """Tell the page a step, in the thread that measures."""
    if stopped.is_set():
        raise _Stopped
    told = asyncio.run_coroutine_threadsafe(socket.send_json({"kind": "step", "name": step}), loop)
    with contextlib.suppress(Exception):  # the listener learns that the page has gone
        told.result()


async def _unless_told(
    socket: WebSocket, measuring: asyncio.Future[calibration.Calibration]
) -> calibration.Calibration:
    """Wait for a measurement, but no longer if the page goes or says anything."""
    # Nobody may be left to hear its error.
    measuring.add_done_callback(lambda of: of.cancelled() or of.exception())
    # All that a page can say now is stop.
    listening = asyncio.create_task(socket.receive())
    both: set[asyncio.Future[Any]] = {measuring, listening}
    try:
        await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
    finally:
        listening.cancel()
    await asyncio.gather(listening, return_exceptions=True)
    if not measuring.done():
        raise WebSocketDisconnect
    return measuring.result()
