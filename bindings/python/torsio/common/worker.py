"""A thread whose end an interrupt of its owner does not feign."""

from __future__ import annotations

import _thread
import os
import sys
import threading
import weakref
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from operator import methodcaller
from typing import Any, Final

__all__ = ["Worker", "exhaust"]

_LOOK_S: Final = 0.05
exhaust: Final = deque[Any](maxlen=0).extend


class Worker:
    """A thread for a function that raises nothing; it never keeps Python from ending.

    A Ctrl-C in `is_alive` or `join` makes `threading.Thread` take a thread for dead (Python 3.11),
    and one where a `Thread` is collected is lost.
    """

    def __init__(self, work: Callable[[], object]) -> None:
        self._work = work
        self._pid = os.getpid()
        self._lock = threading.Lock()
        self._lock.acquire()
        self._begin: list[deque[Any]] = [deque(maxlen=0)]
        self._calls = weakref.ref(self._begin[0])

    def start(self) -> None:
        """Start it. The thread alone has its calls, so that it cannot end untold."""
        steps = _trace, self._work, self._lock.release
        calls = map(methodcaller("__call__"), steps)
        _thread.start_new_thread(self._begin.pop().extend, (calls,))

    @property
    def runs(self) -> bool:
        """False once it has ended, and in a forked child."""
        return self._calls() is not None and os.getpid() == self._pid

    def join(self) -> None:
        """Wait until it has ended; where Python ends, threads stand still for ever."""
        while self.runs and not sys.is_finalizing() and not self._lock.acquire(timeout=_LOOK_S):
            pass


def _trace() -> None:
    """Trace it as `threading` says, unless another thread is setting its own (Python 3.11)."""
    if threading.gettrace() is not None:
        with suppress(RuntimeError):
            sys.settrace(threading.gettrace())
