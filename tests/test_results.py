"""The page of results has the tables that benchmarks print, and says what measured them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.bench import tables

NOTE = re.compile(r"Revision [0-9a-f]{8}, \d+ \w+ \d{4}, .+ with \d+ processors(, GCC [\d.]+)?\.")
STUDIES = sorted(tables.PAGE.parent.glob("results/*.md"))
PAGE = tables.PAGE.read_text(encoding="utf-8")


def _table(page: str, mark: str) -> str:
    (found,) = re.findall(rf"<!-- begin: {mark} -->\n(.*?)<!-- end: {mark} -->", page, re.S)
    return str(found)


def test_reference_promises_no_sooner_off_than_was_measured() -> None:
    hardware = (tables.PAGE.parent / "reference/hardware.md").read_text(encoding="utf-8")
    told = re.findall(r"\| `(\w+)` \| (?:about |[\d.]+ to )?([\d.]+) ms \|", hardware)
    measured: dict[str, list[float]] = {}
    for line in _table(PAGE, "guards").splitlines():
        if fault := re.search(r" ms \| `(\w+)` \|", line):
            times = re.findall(r"([\d.]+) ms \|", line)
            measured.setdefault(fault[1], []).extend(map(float, times))
    faults = {fault for fault, _ in told}
    assert {"emergency_stop", "actuator", "winding", "supply"} <= faults
    for fault in faults & measured.keys():
        assert max(measured[fault]) <= max(float(ms) for of, ms in told if of == fault), fault


def test_every_table_says_when_and_where_it_was_measured_and_by_which_command() -> None:
    parts = re.split(r"^## (.+)$", PAGE, flags=re.M)[1:]
    for title, text in zip(parts[::2], parts[1::2], strict=True):
        if title == "Not tried":
            continue
        assert re.search(r"^    \S|`(\./dev|torsio|python|cmake|git|tests)[ /]", text, re.M), title
        lines = text.splitlines()
        for number, line in enumerate(lines):
            if line.startswith("|--") or line.startswith("| --"):
                head = lines[number - 1]
                if "| last whole run |" not in head:  # it says so row by row
                    assert NOTE.fullmatch(lines[number - 3]), head


@pytest.mark.parametrize("page", STUDIES, ids=lambda page: page.stem)
def test_every_study_says_of_each_table_which_revision_and_machine_measured(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert re.search(r"^    torsio study ", text, re.M)
    marks = re.findall(r"<!-- begin: (.+) -->", text)
    assert len(set(marks)) == len(marks) > 0
    for mark in marks:
        assert NOTE.fullmatch(_table(text, mark).splitlines()[0]), mark
