"""The stream that a recording's bytes go through, and the lock that keeps others away."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final

from torsio.errors import Error

if sys.platform != "win32":
    import fcntl

__all__ = ["MOVES_OPEN_FILES", "Stream", "claimed"]

MOVES_OPEN_FILES: Final = sys.platform != "win32"


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

    def lock(self) -> None:
        """Keep others away."""
        _lock(self._file, "LOCK_EX")

    def go_on(self, path: Path) -> None:
        """Append to this file from now on."""
        self._file = path.open("ab")


def _lock(file: BinaryIO, how: str) -> None:
    """Lock a file, unless its disk has no locks. Raises `BlockingIOError` if another one has it."""
    if sys.platform != "win32" and not file.closed:
        try:
            fcntl.flock(file, getattr(fcntl, how) | fcntl.LOCK_NB)
        except BlockingIOError:
            raise
        except OSError:
            pass


@contextlib.contextmanager
def claimed(path: Path) -> Iterator[None]:
    """Have a file's name alone, which another thread or process may ask for at the same instant.

    Raises `Error` if a recording writes it.
    """
    is_made, is_mine = not path.exists(), False
    try:
        with path.open("ab") as file:
            with contextlib.suppress(BlockingIOError):
                _lock(file, "LOCK_EX")
                mine = os.fstat(file.fileno())
                is_mine = os.path.samestat(mine, path.stat())  # or another one has taken its place
            if not is_mine:
                raise Error(f"another recording is being written to {path}: close it first")
            yield
    finally:
        with contextlib.suppress(OSError):
            if is_made and is_mine and os.path.samestat(mine, path.stat()):
                path.unlink()
