"""Shared by all studies: progress, results that are written whole or not at all, figures."""

from __future__ import annotations

import contextlib
import errno
import json
import math
import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
from matplotlib.figure import Figure

from torsio.common.drawing import drawn
from torsio.common.whole_file import beside, content
from torsio.errors import Error

T = TypeVar("T")
Results = dict[str, Any]

SCHEMA: Final = 1
"""Version of the keys that all results share: schema, study, torsio, quick, seconds, figures."""


class StudyError(Error):
    """A study cannot be run, or its results cannot be read or written."""


@dataclass
class Study:
    """Inputs of a study's `run`.

    Attributes
    ----------
    out
        Folder for the figures; None draws none.
    quick
        Ask for a coarser version that takes a few seconds, for tests.
    settings
        Options that only this study has.
    """

    name: str
    out: Path | None = None
    quick: bool = False
    settings: dict[str, Any] = field(default_factory=dict)
    progress: Callable[[str, float, float], None] | None = None
    figures: list[str] = field(default_factory=list)

    def track(self, items: Iterable[T], label: str, total: int | None = None) -> Iterator[T]:
        """Go through the items with a line of progress."""
        if total is None:
            items = list(items)
            total = len(items)
        count = self.counter(label, total)
        for done, item in enumerate(items, 1):
            yield item
            count(done)

    def counter(self, label: str, total: int) -> Callable[[int], None]:
        """Give a function to be called with how many of `total` are done."""
        progress = self.progress
        if progress is None:
            return lambda _: None
        progress(label, 0, total)
        return lambda done: progress(label, done, total)

    @contextlib.contextmanager
    def figure(
        self, name: str, *, size: tuple[float, float] = (13.5, 6.0), dpi: int = 100
    ) -> Iterator[Figure]:
        """Draw a figure in the project's look; it becomes ``OUT/STUDY_NAME.png``."""
        with drawn(size, dpi) as figure:
            yield figure
            if self.out is None:
                return
            path = self.out / f"{self.name}_{name}.png"
            write_atomically(path, lambda partial: figure.savefig(partial, format="png"))
            self.figures.append(path.name)


def save(results: Results, path: Path) -> None:
    """Write results as JSON, whole or not at all."""
    text = json.dumps(plain(results), indent=2, allow_nan=False) + "\n"
    make_folder(path.parent)
    write_atomically(path, lambda partial: partial.write_text(text, encoding="utf-8"))


def load(path: Path, name: str) -> Results:
    """Read the results of the study `name`.

    Raises
    ------
    StudyError
        If the file cannot be read, is damaged, or holds something else.
    """
    try:
        results = json.loads(content(path).decode())
    except (OSError, UnicodeDecodeError) as error:
        raise StudyError(f"{path} cannot be read: {error}") from None
    except (ValueError, RecursionError) as error:  # numbers and nests without end are both
        raise StudyError(f"{path} is damaged: {error}") from None
    if not isinstance(results, dict) or results.get("study") != name:
        raise StudyError(f"{path} does not hold results of `torsio study {name}`")
    if results.get("schema") != SCHEMA:
        raise StudyError(
            f"{path} has results of schema {results.get('schema')}, this version reads {SCHEMA}"
        )
    return results


def check_replaceable(path: Path, name: str) -> None:
    """Refuse to replace what is not an intact file of results of this study.

    Raises
    ------
    StudyError
        With the reason, and what to do.
    """
    if not path.exists():
        return
    try:
        load(path, name)
    except StudyError as error:
        raise StudyError(f"{error}; it is left alone: move it away or give another name") from None


def make_folder(path: Path) -> None:
    """Make a folder, unless it is there.

    Raises
    ------
    StudyError
        If that fails.
    """
    with _explained(path):
        path.mkdir(parents=True, exist_ok=True)


def write_atomically(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a file beside `path`, and put it in the place of `path` when it is whole.

    Raises
    ------
    StudyError
        If that fails, for want of space for instance; what was at `path` is then still there.
    """
    with _explained(path), beside(path) as partial:
        write(partial)
        with partial.open("rb") as file:
            os.fsync(file.fileno())


@contextlib.contextmanager
def _explained(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        why = "the disk is full" if error.errno == errno.ENOSPC else str(error.strerror or error)
        kept = "; what was there before is kept" if path.exists() else ""
        raise StudyError(f"cannot write {path}: {why}{kept}") from None


def plain(value: Any) -> Any:
    """Give what JSON knows: plain numbers and lists, and null for what is not finite."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
