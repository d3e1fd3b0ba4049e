"""A plugin of pytest for ``hunt.py``: tells of each test how it ended, and what it reached."""

from __future__ import annotations

import ctypes
import json
import os
import sys
import threading
from collections.abc import Callable, Generator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest

TOLD, WANTED = "TORSIO_MUTANTS_TOLD", "TORSIO_MUTANTS_WANTED"
_wanted: dict[str, Any] = json.loads(os.environ.get(WANTED, "{}"))
# Numbers of the changes by line, for each Python file.
_lines: dict[str, dict[int, int]] = {
    file: {int(line): number for line, number in lines.items()}
    for file, lines in _wanted.get("lines", {}).items()
}
_reached: set[int] = set()
_files: set[str] = set()
_failed: list[str] = []
_looked_at: dict[CodeType, bool] = {}


def _enter(frame: FrameType, event: str, _: Any) -> Callable[..., Any] | None:
    code = frame.f_code
    lines = _lines.get(code.co_filename)
    if lines is None:
        return None
    _files.add(code.co_filename)
    if code not in _looked_at:
        _looked_at[code] = any(line in lines for _, _, line in code.co_lines())
    return _line if _looked_at[code] else None


def _line(frame: FrameType, event: str, _: Any) -> Callable[..., Any]:
    if number := _lines[frame.f_code.co_filename].get(frame.f_lineno):
        _reached.add(number)
    return _line


def _choices() -> Any:
    """Return which choices the compiled module was asked for, by their numbers."""
    count = _wanted.get("choices", 0)
    if not count:
        return bytearray()
    from torsio import _torsio

    library = ctypes.CDLL(_torsio.__file__)
    return (ctypes.c_ubyte * (count + 1)).in_dll(library, "torsio_mutant_reached")


def _take() -> list[int]:
    """Return what was reached since the last time."""
    asked = _choices()
    found = _reached | {number for number, was in enumerate(asked) if was}
    _reached.clear()
    for number in found:
        if number < len(asked):
            asked[number] = 0
    return sorted(found)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Write a line about a test."""
    _take()
    _files.clear()
    _failed.clear()
    begin_s = sum(os.times()[:4])
    if _lines:
        threading.settrace(_enter)
        sys.settrace(_enter)
    result = yield
    sys.settrace(None)
    one = {
        "test": item.nodeid,
        "failed": bool(_failed),
        "takes_s": sum(os.times()[:4]) - begin_s,
        "reached": _take(),
        "files": sorted(_files),
    }
    with Path(os.environ[TOLD]).open("a", encoding="utf-8") as file:
        file.write(json.dumps(one) + "\n")
    return result


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note what failed."""
    if report.failed:
        _failed.append(report.nodeid)
