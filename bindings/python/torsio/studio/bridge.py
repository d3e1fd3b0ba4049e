"""A knob passed on to one page: reports as they are, with a byte in front that says which way.

The device's come several in a message, one behind the other. The page says when it `HAVE`s one.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import struct
import threading
import time
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any, Final

from torsio import _torsio
from torsio.common.worker import Worker
from torsio.errors import Error, Timeout
from torsio.printed.hands import Hand, ImpedanceHand, NoHand
from torsio.protocol import decode, encode

__all__ = [
    *("GET", "GOT", "HAND", "HAVE", "INPUT", "PRESS", "SET", "STALLED", "TAKEN", "TRUTH", "WRITE"),
    *("KEPT_REPORTS", "MESSAGES_UNDER_WAY", "TOGETHER_S", "Bridge", "MessageError", "Waiting"),
    *("arms", "lets_go"),
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
HAND: Final = 8
PRESS: Final = 9
TRUTH: Final = 10

# Bytes behind the first of each message from a page. The last two are for an emulated knob.
_LENGTHS: Final = {WRITE: 64, GET: 1, SET: 64, HAVE: 0, HAND: 8, PRESS: 1}
_TELEMETRY: Final = 0x40
_COMMAND: Final = encode("command", {})[0]
_KEEP_ALIVE: Final = encode("command", {"op": "keep_alive"})
_DISARM: Final = encode("command", {"op": "disarm"})
# Longest that a report waits for room, which a full queue has after a millisecond.
_ROOM_S: Final = 1.0
_READ_S: Final = 0.02
# More than a page holds of curves.
KEPT_REPORTS: Final = 8192
MESSAGES_UNDER_WAY: Final = 2
# Telemetry waits so long for more: the page works least with a picture's worth at a time.
TOGETHER_S: Final = 0.034
# A page's sign of life is repeated for so long: a busy machine has it say the next one late.
PAGE_SILENCE_S: Final = 5.0
_ALIVE_EVERY_S: Final = 0.02
# As in studio/src/worker.ts: a hand that is firm without shaking.
_FOLLOW_S: Final = 0.03
# The first columns of TRUTH in studio/src/emulated_device.ts.
_TRUTH: Final = (
    *("angle_rad", "brake_angle_rad", "speed_rad_s", "spring_torque_nm", "brake_torque_nm"),
    *("brake_capacity_nm", "motor_torque_nm", "hand_torque_nm"),
)


class MessageError(Error):
    """A page sent something that is no message of the bridge."""


def _op(message: bytes) -> Any:
    """Give the command that a page's message has, or None."""
    if message[:2] == bytes([WRITE, _COMMAND]):
        with contextlib.suppress(Error):  # the device refuses what nobody understands
            return decode(message[1:])[1]["op"]
    return None


def lets_go(message: bytes) -> bool:
    """Whether a page's message takes the torque off."""
    return _op(message) in ("disarm", "stop")


def arms(message: bytes) -> bool:
    """Whether a page's message puts the torque on or keeps it."""
    return _op(message) in ("arm", "keep_alive")


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


class World:
    """The world round an emulated knob, which is opened with ``log_truth``: the page's hand."""

    def __init__(self, transport: _torsio.Transport) -> None:
        self._transport = transport
        self._held_at_rad: float | None = None
        self._turned_rad = 0.0
        self._truth = (0.0,) * len(_TRUTH)

    def look(self) -> None:
        """Take the truth; the newest is kept."""
        if len(rows := self._transport.truth()):
            self._truth = tuple(float(rows[name][-1]) for name in _TRUTH)

    def told(self) -> bytes:
        """Give the page's message about it."""
        return struct.pack(f"<B{len(_TRUTH)}d", TRUTH, *self._truth)

    def turn(self, turned_rad: float) -> None:
        """Have the hand turn so far from where it took the knob; NaN lets go."""
        hand: Hand = NoHand()
        if math.isnan(turned_rad):
            self._held_at_rad, self._turned_rad = None, 0.0
        else:
            if self._held_at_rad is None:
                self._held_at_rad = self._truth[0]
            path = (self._held_at_rad + self._turned_rad, self._held_at_rad + turned_rad)
            hand = ImpedanceHand(
                inertia_kg_m2=2e-5,
                stiffness_nm_per_rad=0.8,
                damping_nm_s_per_rad=8e-3,
                intended_angle_rad=[(0.0, path[0]), (_FOLLOW_S, path[1])],
            )
            self._turned_rad = turned_rad
        self._transport.set_hand(hand)

    def press(self, *, pressed: bool) -> None:
        """Press or release the emergency stop."""
        self._transport.set_emergency_stop(pressed)


class Bridge:
    """One open device, and the page at the other end.

    The device is read in a thread of its own. Its text goes to the page in as few messages as the
    page is quick: a new one when the page has an older one. That thread also repeats the page's
    sign of life, until the page says disarm or nothing more.
    """

    def __init__(self, transport: _torsio.Transport, world: World | None = None) -> None:
        self._transport = transport
        self._world = world
        self._alive_until_s = 0.0
        self._let_go = 0
        self._waiting = Waiting()
        self._under_way = asyncio.Semaphore(MESSAGES_UNDER_WAY)
        self._closed = threading.Event()
        self._worker = Worker(self._read)
        self._worker.start()

    def close(self) -> None:
        """Disarm the device and let go of it."""
        self._alive_until_s = 0.0
        until_s = time.monotonic() + _ROOM_S
        try:
            with contextlib.suppress(Exception):  # the device may be what is gone
                while not self._transport.write(_DISARM) and time.monotonic() < until_s:
                    time.sleep(1e-3)
        finally:
            self._closed.set()
            self._worker.join()
            self._transport.close()

    def _read(self) -> None:
        again_s = 0.0
        try:
            while not self._closed.is_set():
                report = self._transport.read(_READ_S)
                if report is not None:
                    self._waiting.put(report)
                if (now_s := time.monotonic()) < again_s:
                    continue
                again_s = now_s + _ALIVE_EVERY_S
                if now_s < self._alive_until_s:
                    self._transport.write(_KEEP_ALIVE)
                if self._world is not None:
                    self._world.look()
        except Exception as error:
            self._waiting.end(error)

    async def _write(self, message: bytes) -> None:
        """Hand on a report of the page, and learn whether the knob is to be kept alive."""
        if lets_go(message):
            self._alive_until_s = 0.0
            self._let_go += 1
        before = self._let_go
        until_s = time.monotonic() + _ROOM_S
        while not await asyncio.to_thread(self._transport.write, message[1:]):
            if time.monotonic() > until_s:
                raise Timeout("the knob takes no more reports; plug it in again")
            await asyncio.sleep(1e-3)
            if arms(message) and self._let_go != before:
                return
        if not arms(message):
            return
        if self._let_go == before:
            self._alive_until_s = time.monotonic() + PAGE_SILENCE_S
        else:  # nobody knows which of the two came first
            await self._write(bytes([WRITE]) + _DISARM)

    async def pump(self, send: Callable[[bytes], Awaitable[None]]) -> None:
        """Hand on what the device says, for ever. Raises what reading the device raises."""
        while True:
            await self._under_way.acquire()
            await send(bytes([INPUT]) + b"".join(await self._waiting.take()))
            if self._world is not None:
                await send(self._world.told())

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
        if kind == WRITE:
            await self._write(message)
        elif self._world is None:
            raise MessageError("this knob is real: only a hand turns it")
        elif kind == HAND:
            self._world.turn(struct.unpack("<d", report)[0])
        else:
            self._world.press(pressed=report != b"\0")
        return None
