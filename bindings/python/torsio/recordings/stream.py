"""The stream that a recording's bytes go through, and the lock that keeps others away."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import BinaryIO, Final

from torsio import _torsio
from torsio.errors import Error

if sys.platform != "win32":
    import fcntl

__all__ = ["MOVES_OPEN_FILES", "Claim", "Stream"]

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


class Claim:
    """Has a file's name alone, which another thread or process may ask for at the same instant."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: BinaryIO | None = None
        self._is_new = False  # nothing was there before

    def __enter__(self) -> Claim:
        """Give the claim itself."""
        return self

    def take(self) -> None:
        """Claim it. Raises `Error` if a recording writes it."""
        while True:
            self._is_new = not self._path.exists()
            self._file = open(self._path, "rb", opener=_open_any)  # noqa: SIM115
            try:
                _lock(self._file, "LOCK_EX")
            except BlockingIOError:
                self._is_new = False
                text = f"another recording is being written to {self._path}: close it first"
                raise Error(text) from None
            with contextlib.suppress(FileNotFoundError):
                if self._is_there(self._file):
                    return
            self._close()  # another has put its own there, or taken this away

    @_torsio.all_of
    def __exit__(self, *_: object) -> Iterable[Callable[[], object]]:
        """Give it up, and take away what was put there only to claim it."""
        return self._clear, self._close

    def _clear(self) -> None:
        with contextlib.suppress(OSError):
            if self._is_new and self._file is not None:
                _lock(self._file, "LOCK_EX")  # if an exception came before that
                if self._is_there(self._file):
                    self._path.unlink()

    def _is_there(self, file: BinaryIO) -> bool:
        return os.path.samestat(os.fstat(file.fileno()), self._path.stat())

    def _close(self) -> None:
        if self._file is not None:
            _lock(self._file, "LOCK_UN")  # a forked child may have it open
            self._file.close()


def _open_any(path: str, _: int) -> int:
    """Open a file that may be write-protected, or make it. Disks of a network lock for writing."""
    try:
        return os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except PermissionError:
        return os.open(path, os.O_RDONLY)
