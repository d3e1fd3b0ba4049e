"""The pages of hardware say what the firmware does."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import torsio

DOCS = Path(__file__).parent.parent / "docs"
PAGE = DOCS / "reference/hardware.md"
GUIDES = [DOCS / f"how-to/{name}.md" for name in ("hardware", "first-power")]


def test_wiring_diagram_shows_the_default_pins() -> None:
    page = PAGE.read_text(encoding="utf-8")
    drawn = set(re.findall(r">(GP\d+) ", (DOCS / "wiring.svg").read_text(encoding="utf-8")))
    table = set(re.findall(r"\| (GP\d+) \|", page))
    assert table <= drawn
    # The second pins of the pairs, and a divider's pin, which no board has by default.
    assert drawn - table == {"GP3", "GP7", "GP9", "GP27"}


PROGRAMS = [
    program
    for guide in GUIDES
    for program in re.findall(
        r"^```python\n(.*?)^```$", guide.read_text(encoding="utf-8"), re.M | re.S
    )
]


def _run(program: str, monkeypatch: pytest.MonkeyPatch, options: torsio.EmulatorOptions) -> None:
    real = torsio.open
    monkeypatch.setattr(torsio, "open", lambda: real("emulated", emulator=options))
    exec(compile(program, "a guide of hardware", "exec"), {})


@pytest.mark.parametrize("program", PROGRAMS, ids=["other parts", "first power"])
def test_programs_of_the_guide_run(program: str, monkeypatch: pytest.MonkeyPatch) -> None:
    _run(program, monkeypatch, torsio.EmulatorOptions(seed=1))
