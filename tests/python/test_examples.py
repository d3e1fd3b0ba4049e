"""Every Python example runs on the emulated knob and says what it promises."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

TREE = Path(__file__).parents[2]
EXAMPLES = sorted((TREE / "examples" / "python").glob("*.py"))
PROMISED = {
    "detents": "notch 5:",
    "feel_a_wall": "pushed back with 4",  # 50 mN m less friction
    "learn_a_wall": "the law compensated: -0.",
    "stream_local_model": "0 models refused",
}
# Shorter than by itself.
ARGUMENTS = {"learn_a_wall": ["2"]}


def test_every_example_is_known() -> None:
    assert {example.stem for example in EXAMPLES} == set(PROMISED)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs(example: Path) -> None:
    result = subprocess.run(
        [sys.executable, "-W", "error", str(example), *ARGUMENTS.get(example.stem, [])],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert PROMISED[example.stem] in result.stdout
    assert result.stderr == ""


def test_detents_tells_milliseconds_that_come_to_its_recording() -> None:
    example = TREE / "examples/python/detents.py"
    output = subprocess.run([sys.executable, str(example)], capture_output=True, text=True).stdout
    stays_ms = [int(stay) for stay in re.findall(r"^notch -?\d+: (\d+) ms,", output, re.MULTILINE)]
    assert len(stays_ms) >= 6
    # It records 3.2 s; each line is rounded to a millisecond.
    assert sum(stays_ms) == pytest.approx(3200, abs=len(stays_ms) + 5)
