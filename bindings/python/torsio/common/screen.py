"""Output of the commands on a terminal: lines and plain tables. It needs the extra ``cli``."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from rich.console import Console
from rich.progress import Progress, TaskID, TimeElapsedColumn
from rich.table import Table

__all__ = ["asks", "err", "line", "out", "progress", "table"]

out: Console = Console(highlight=False)
err: Console = Console(stderr=True, highlight=False)


def line(console: Console, text: str) -> None:
    """Print a line as it stands, without markup and without wrapping."""
    console.print(text, markup=False, emoji=False, soft_wrap=True)


def table(*headings: str, words: int = 0) -> Table:
    """Make a table without lines; the first so many columns are words, the others numbers."""
    made = Table(box=None, pad_edge=False, header_style="bold")
    for i, heading in enumerate(headings):
        # The first column is never cut.
        made.add_column(heading, justify="left" if i < words else "right", no_wrap=i == 0)
    return made


@contextmanager
def progress(console: Console) -> Iterator[Callable[[str, float, float], None]]:
    """Show lines of progress once there is some: what is done, how much of it, and for how long."""
    bar = Progress(*Progress.get_default_columns()[:3], TimeElapsedColumn(), console=console)
    tasks: dict[str, TaskID] = {}
    with ExitStack() as shown:

        def show(what: str, done: float, total: float) -> None:
            if not tasks:
                shown.enter_context(bar)
            if what not in tasks:
                tasks[what] = bar.add_task(what)
            bar.update(tasks[what], completed=done, total=total)

        yield show


def asks(console: Console, question: str) -> bool:
    """Ask for a yes or no; without a terminal it is no."""
    if not sys.stdin.isatty():
        return False
    return console.input(f"{question} [y/N] ", markup=False).strip().lower() in ("y", "yes")
