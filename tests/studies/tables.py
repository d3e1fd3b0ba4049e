"""Prints the tables of a study, from ``out/NAME.json``, into the places that its page has for them.

torsio study impact && .venv/bin/python -m tests.studies.tables impact
"""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Iterable
from typing import Any

from rich.table import Table
from rich.text import Text

from tests.bench.tables import TREE, where


class Shown:
    """A console that keeps tables as Markdown; tables with the same columns are one."""

    def __init__(self) -> None:
        self.tables: dict[tuple[str, ...], list[str]] = {}

    def print(self, *objects: Any, **options: Any) -> None:
        """Keep the tables of what a study prints."""
        for table in (one for one in objects if isinstance(one, Table)):
            titled = [str(table.title)] if table.title else []
            heads = ["of what"] * bool(titled) + [_cell(column.header) for column in table.columns]
            left = "|".join(
                "--:" if column.justify == "right" else "---" for column in table.columns
            )
            begin = [_row(heads), f"|{'---|' * bool(titled)}{left}|"]
            rows = zip(*(column.cells for column in table.columns), strict=True)
            kept = self.tables.setdefault(tuple(heads), begin)
            kept += [_row([*titled, *map(_cell, cells)]) for cells in rows]


def _cell(words: object) -> str:
    return Text.from_markup(str(words)).plain.replace("\n", ", ").replace("|", "\\|")


def _row(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |"


def put_shown(page: str, name: str, shown: Shown, note: str) -> str:
    """Put a study's tables in the places that its page has for them, by their number."""
    for number, lines in enumerate(shown.tables.values(), 1):
        mark = f"torsio study {name} {number} -->"
        begin, found, rest = page.partition(f"<!-- begin: {mark}")
        if found:
            after = rest.partition(f"<!-- end: {mark}")[2]
            table = "\n".join([note, "", *lines])
            page = f"{begin}{found}\n{table}\n<!-- end: {mark}{after}"
    return page


def study(name: str) -> None:
    """Print a study's tables into its page."""
    shown = Shown()
    results = json.loads((TREE / f"out/{name}.json").read_text(encoding="utf-8"))
    importlib.import_module(f"torsio_studies.{name}.study").show(results, shown)
    page = TREE / "docs/results" / f"{name}.md"
    text = put_shown(page.read_text(encoding="utf-8"), name, shown, where())
    page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    study(sys.argv[1])
