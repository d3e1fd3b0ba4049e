"""Raise something at the n-th line that a call runs."""

from __future__ import annotations

import dis
import linecache
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

import mcap

import torsio


class TwoInterrupts(KeyboardInterrupt):
    """Raised again at the next call: a second Ctrl-C, while the first is being dealt with."""


RAISED: tuple[type[BaseException], ...] = (KeyboardInterrupt, MemoryError, OSError)
# Where it is raised: the library, what it calls to write recordings, and modules of Python's own
# that do more than compute.
_OURS = tuple(str(Path(package.__file__ or "").parent) for package in (torsio, mcap))
_PYTHON = Path(threading.__file__).parent
_FOLDERS = (*_OURS, str(_PYTHON))
_COMPUTES = tuple(str(_PYTHON / name) for name in ("copy.py", "dataclasses.py", "json"))
# Python's own steps at the end of a "with", before the call: it looks at no signal there.
_ENDS = ("LOAD_CONST", "PUSH_EXC_INFO", "ROT_TWO", "SWAP", "WITH_EXCEPT_START")


class Injection:
    """Counts the lines that run, and raises at one of them.

    Attributes
    ----------
    lines
        How many have run.
    where
        The line at which something was raised: file and number; None if it never ran.
    """

    def __init__(
        self, at: int | None, kind: type[BaseException], *, in_thread: bool = False
    ) -> None:
        self.lines = 0
        self.where: str | None = None
        self._at, self.kind = at, kind
        self._main = threading.get_ident()
        self._in_thread = in_thread  # in the recording's thread, not the caller's

    @contextmanager
    def active(self) -> Iterator[None]:
        """Watch what runs in this block."""
        before = sys.gettrace()
        (threading if self._in_thread else sys).settrace(self._enter)
        try:
            yield
        finally:
            sys.setprofile(None)
            sys.settrace(before)
            threading.settrace(None)

    def _enter(self, frame: FrameType, event: str, _: Any) -> Callable[..., Any] | None:
        # Python's own modules where what is watched calls them, not where the harness does.
        is_called = frame.f_back is not None and frame.f_back.f_trace is not None
        file = frame.f_code.co_filename
        is_ours = file.startswith(_FOLDERS if is_called else _OURS)
        is_main = threading.get_ident() == self._main
        is_ours = is_ours and not file.startswith(_COMPUTES)
        if event != "call" or not is_ours or is_main == self._in_thread:
            return None
        return self._line

    def _again(self, frame: FrameType, event: str, _: Any) -> None:
        if event in ("call", "c_call") and frame.f_code.co_filename.startswith(_OURS):
            raise TwoInterrupts(f"injected again, after {self.where}")

    def _line(self, frame: FrameType, event: str, _: Any) -> Callable[..., Any]:
        text = linecache.getline(frame.f_code.co_filename, frame.f_lineno).lstrip()
        begins = dis.opname[frame.f_code.co_code[frame.f_lasti]]
        does_nothing = text.rstrip() == "try:" or (text.startswith("with ") and begins in _ENDS)
        if event == "line" and not does_nothing:
            if self.lines == self._at and self.where is None:
                name = Path(frame.f_code.co_filename).name
                self.where = f"{name}:{frame.f_lineno} {text.rstrip()}"
                if self.kind is TwoInterrupts:
                    sys.setprofile(self._again)
                raise self.kind(f"injected at {self.where}")
            self.lines += 1
        return self._line
