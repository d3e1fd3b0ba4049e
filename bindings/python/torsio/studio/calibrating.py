"""A calibration that a page asks for: it sees each step and the result, and says what then.

Messages are JSON. The server says `step`, then `found` or `refused`, and `kept` at last; the page
says `calibrate`, and after it has `found` something perhaps `keep`. If it goes, the knob stops.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import Callable
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
    try:
        found = await _measure(
            socket, knob, quick=asked.get("quick") is True, supply_v=asked.get("supply_v")
        )
        await socket.send_json(await asyncio.to_thread(described, knob, found))
        if (await _asked(socket)).get("do") == "keep":
            path = await asyncio.to_thread(_keep, knob, found)
            await socket.send_json({"kind": "kept", "path": str(path), "forgets": knob.is_emulated})
    except (calibration.Refusal, Error, TypeError) as error:  # TypeError: the supply is no number
        await socket.send_json({"kind": "refused", "why": str(error)})
    finally:
        await asyncio.to_thread(knob.close)


async def _measure(
    socket: WebSocket, knob: Knob, *, quick: bool, supply_v: Any
) -> calibration.Calibration:
    """Calibrate in a thread, and stop the knob if the page goes or says anything."""
    loop = asyncio.get_running_loop()
    stopped = False

    def tell(step: str) -> None:
        if stopped:
            raise _Stopped
        told = asyncio.run_coroutine_threadsafe(
            socket.send_json({"kind": "step", "name": step}), loop
        )
        with contextlib.suppress(Exception):  # the listener learns that the page has gone
            told.result()

    measuring = asyncio.create_task(
        asyncio.to_thread(
            calibration.calibrate, knob, quick=quick, supply_v=supply_v, progress=tell
        )
    )
    # All that a page can say now is stop.
    listening = asyncio.create_task(socket.receive())
    await asyncio.wait({measuring, listening}, return_when=asyncio.FIRST_COMPLETED)
    if measuring.done():
        listening.cancel()
        await asyncio.gather(listening, return_exceptions=True)
        return measuring.result()
    stopped = True
    while not measuring.done():
        # Again and again: it may be about to arm.
        with contextlib.suppress(Error):
            await asyncio.to_thread(knob.stop)
        await asyncio.wait({measuring}, timeout=_AGAIN_S)
    await asyncio.gather(measuring, return_exceptions=True)
    raise WebSocketDisconnect
