"""The stream that a recording's bytes go through, and the lock that keeps others away."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from typing import BinaryIO

from torsio.errors import Error

if sys.platform != "win32":  # which moves no file over an open one
    import fcntl

__all__ = ["Stream", "check_unwritten"]


class Stream:
    """MCAP's writer writes to this: first a place beside the file, then the file itself."""

    def __init__(self, place: Path) -> None:
        self._file = place.open("wb")
        self._size = 0  # a pipe does not tell it

    def write(self, data: bytes) -> int:
        """Append bytes."""
        self._size += len(data)
        return self._file.write(data)

    def tell(self) -> int:
        """Tell how many there are."""
        return self._size

    def flush(self) -> None:
        """Hand all to the system."""
        self._file.flush()

    def close(self) -> None:
        """Let go of the file, and of its lock."""
        _lock(self._file, "LOCK_UN")  # a forked child may have it open
        self._file.close()

    def go_on(self, path: Path) -> None:
        """Append to this file from now on."""
        self._file = path.open("ab")
        _lock(self._file, "LOCK_EX")


def _lock(file: BinaryIO, how: str) -> None:
    """Lock a file, unless its disk has no locks. Raises `BlockingIOError` if another one has it."""
    if sys.platform != "win32" and not file.closed:
        try:
            fcntl.flock(file, getattr(fcntl, how) | fcntl.LOCK_NB)
        except BlockingIOError:
            raise
        except OSError:
            pass


def check_unwritten(path: Path) -> None:
    """Raise `Error` if a recording writes this file, here or in another process."""
    with contextlib.suppress(FileNotFoundError, PermissionError), path.open("rb") as file:
        try:
            _lock(file, "LOCK_SH")
        except BlockingIOError:
            raise Error(f"another recording is being written to {path}: close it first") from None
