"""The hardware guide says what the firmware does."""

from __future__ import annotations

import re
from pathlib import Path

from tools import wiring_table

DOCS = Path(__file__).parent.parent / "docs"


def test_table_of_the_hardware_guide_is_the_one_of_the_header() -> None:
    page = wiring_table.PAGE.read_text(encoding="utf-8")
    assert page == wiring_table.page_with_table(page)


def test_wiring_diagram_shows_the_default_pins() -> None:
    page = wiring_table.PAGE.read_text(encoding="utf-8")
    drawn = set(re.findall(r">(GP\d+) ", (DOCS / "wiring.svg").read_text(encoding="utf-8")))
    table = set(re.findall(r"\| (GP\d+) \|", page))
    assert table <= drawn
    assert drawn - table == {"GP3", "GP7", "GP9"}  # the second pins of the pairs
