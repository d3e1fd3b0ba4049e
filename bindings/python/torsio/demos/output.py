"""Files that a demonstration writes: looked at before it runs, and written wholly or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path

from torsio.common.whole_file import beside


class OutputError(Exception):
    """A file cannot be written; the message names the option and says what to do."""


def check(files: Iterable[Path], option: str) -> None:
    """Look whether files can be written, and change nothing.

    Parameters
    ----------
    option
        Where the files' places come from, for the message.
    """
    for file in files:
        # No links either: /dev/stdout is one, and what it leads to must not be replaced.
        if file.is_symlink() or (file.exists() and not file.is_file()):
            raise OutputError(f"{option}: {file} exists and is no plain file; choose another place")
        folder = file.parent
        while not folder.exists() and folder != folder.parent:
            folder = folder.parent
        if not folder.is_dir():
            raise OutputError(f"{option}: {folder} is a file, not a folder; choose another place")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise OutputError(f"{option}: {folder} is not writable; choose another place")


def write(writers: Mapping[Path, Callable[[Path], object]], option: str) -> None:
    """Write all files beside their places, and put them there when all are complete."""
    try:
        with ExitStack() as places:
            for file, writer in writers.items():
                file.parent.mkdir(parents=True, exist_ok=True)
                writer(places.enter_context(beside(file)))
    except OSError as error:
        raise OutputError(
            f"{option}: cannot write there ({error.strerror or error}); choose another place"
        ) from error
