"""The documents' tables of the paper's scenarios, from each board's binary and beside it."""

from __future__ import annotations

import itertools
import re
from typing import Any

import pytest

from tests.board import felt, pico
from tests.studies import bench_binary as binary
from tests.studies.bench_binary import BINARY, EMULATED, NOISE, SCENARIOS, Scenario

# The difference of binary and emulated device by docs/results.md, in N m: root of the
# mean square, and the most.
BOUNDS_NM = {"push": (1e-3, 4e-3), "bounce": (2e-3, 30e-3), "cut": (1e-3, 4e-3)}
# The same if either may be a millisecond late: a bounce has steps of more than 20 mN m in one.
MOST_NM_WITHIN_1_MS = 6e-3


def _cells(document: str, pattern: str) -> list[list[float]]:
    """Give the numbers in each cell of a table's row."""
    text = (pico.TREE / "docs" / document).read_text(encoding="utf-8")
    (row,) = re.findall(rf"^\|{pattern} \| (.*) \|$", text, re.MULTILINE)
    return [[float(n) for n in re.findall(r"-?[\d.]+", cell)] for cell in row.split(" | ")]


def _told(pattern: str, kind: str) -> list[float]:
    """The chosen board's cells in a row of docs/results.md."""
    cells = _cells("results.md", pattern)
    return cells[2 * ["pico2", "pico"].index(pico.chosen.name) + (kind != BINARY)]


def _told_apart(scenario: Scenario, kind: str) -> list[float]:
    """The rows of differences, in the order of the scenarios."""
    text = (pico.TREE / "docs" / "results.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| \| apart: binary; other noise \| (.*) \|$", text, re.MULTILINE)
    cells = rows[SCENARIOS.index(scenario)].split(" | ")
    cell = cells[2 * ["pico2", "pico"].index(pico.chosen.name) + (kind != BINARY)]
    return [float(n) for n in cell.split(", ")]


def _told_of_binary(pattern: str) -> list[float]:
    """The same of the table in docs/results/paper.md, which has the binaries in columns."""
    return _cells("results/paper.md", pattern)[["pico2", "pico"].index(pico.chosen.name)]


def _check_push(found: dict[str, Any], kind: str) -> None:
    errors = [100 * found["tracking_rms_in"], 100 * found["tracking_rms_out"]]
    gap_nm = 1e3 * found["torque_gap_nm"]
    sensor_nm = 1e3 * found["sensor_rms_nm"]
    assert _told(r" push, .* \| error in, out", kind) == pytest.approx(errors, abs=0.15)
    assert _told(r" \| gap on the way out", kind) == pytest.approx([gap_nm], abs=0.3)
    assert _told(r" \| error of the sensor", kind) == pytest.approx([sensor_nm], abs=0.05)
    if kind == BINARY:
        told = _told_of_binary(" scenario 2, .*: error in and out")
        assert told == pytest.approx(errors, abs=0.15)
        assert _told_of_binary(" scenario 2: torque gap") == pytest.approx([gap_nm], abs=0.3)


def _check_bounce(found: dict[str, Any], kind: str) -> None:
    assert _told(r" bounce, .* \| crossings, then", kind) == [found["crossings"]]
    assert found["oscillation_rad"] < 3e-3, "it is not at rest"
    if kind == BINARY:
        assert _told_of_binary(" scenario 1, .*: crossings in 1 s, then") == [found["crossings"]]


def _check_cut(found: dict[str, Any], kind: str) -> None:
    # Where friction holds it depends on the noise.
    depth_mrad = 1e3 * found["final_depth_rad"]
    assert abs(depth_mrad) < 1.5
    assert _told(r" cut, .* \| stops at a depth of", kind) == pytest.approx([depth_mrad], abs=1.5)
    if kind == BINARY:
        told = _told_of_binary(" scenario 3, .*: depth where it stops")
        assert told == pytest.approx([depth_mrad], abs=1.5)


CHECKS = {"push": _check_push, "bounce": _check_bounce, "cut": _check_cut}


@pytest.mark.parametrize(
    ("scenario", "board"),
    zip(SCENARIOS, itertools.cycle(pico.MODELS)),
    ids=lambda one: getattr(one, "name", one),
)
def test_documents_say_what_binary_and_emulated_device_do(scenario: Scenario, board: str) -> None:
    pico.choose(board)
    found = binary.run(scenario)
    for kind in (BINARY, EMULATED):
        CHECKS[scenario.name](scenario.measure(found[kind]), kind)
    for kind in (BINARY, NOISE):
        usual_nm, most_nm = binary.apart_nm(found, kind)
        usual_bound_nm, most_bound_nm = BOUNDS_NM[scenario.name]
        assert usual_nm < usual_bound_nm
        assert most_nm < most_bound_nm
        # Another firmware's ticks meet the noise at other moments.
        told_mnm, most_told_mnm = _told_apart(scenario, kind)
        assert 1e3 * usual_nm == pytest.approx(told_mnm, rel=0.5, abs=0.3)
        assert 1e3 * most_nm == pytest.approx(most_told_mnm, rel=0.5, abs=0.5)
    most_nm = felt.difference_nm(found[BINARY], found[EMULATED], rows=1)[1]
    assert most_nm < MOST_NM_WITHIN_1_MS
