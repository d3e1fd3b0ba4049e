"""The benchmark measures the figures of the brake's coil on the page of results."""

from __future__ import annotations

import re
from pathlib import Path
from typing import cast

import pytest

from tests.bench.bench_stiffness import springs
from tests.studies import bench_brake as brake
from torsio.printed.config import Law

TEXT = (Path(__file__).parents[2] / "docs" / "results.md").read_text(encoding="utf-8")
ROWS = re.findall(
    r"^\| `(\w+)` \| (.+?) \| ([\d.]+) mN m \| ([\d.]+) % \| (\d+) ms \| (\d+) ms \| "
    r"(never|\d+)(?: N m/rad)? \|$",
    TEXT,
    re.MULTILINE,
)
WAYS = {way.name: way for way in brake.WAYS}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row[0]}, {row[1]}")
def test_table_of_the_coil_s_drives_is_the_benchmark_s(row: tuple[str, ...]) -> None:
    law, way = cast(Law, row[0]), WAYS[row[1]]
    gap_mnm, error_percent, fall_ms, exit_ms = map(float, row[2:6])
    push = brake.pushed(law, way)
    # The last digits on the page.
    assert 1e3 * push.torque_gap_nm == pytest.approx(gap_mnm, abs=0.06)
    assert 100 * push.tracking_rms_out == pytest.approx(error_percent, abs=0.06)
    assert 1e3 * brake.fall_s(way) == pytest.approx(fall_ms, abs=0.6)
    left_s = brake.exit_s(law, way)
    assert left_s is not None
    assert 1e3 * left_s == pytest.approx(exit_ms, abs=0.6)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row[0]}, {row[1]}")
def test_springs_of_the_table_rest_and_the_next_one_buzzes(row: tuple[str, ...]) -> None:
    # All that are softer take ten times as long.
    law, way, told = cast(Law, row[0]), WAYS[row[1]], row[-1]
    series = springs(brake.STEP)
    if told == "never":
        assert brake.rest(law, way, series[-1:]) == [True]
        return
    at = min(range(len(series)), key=lambda n: abs(series[n] - float(told)))
    assert brake.rest(law, way, series[at - 1 : at + 2]) == [True, True, False]


def test_table_of_the_coil_s_drives_is_there() -> None:
    assert len(ROWS) >= 9


def test_little_is_left_of_a_brake_that_is_demagnetised() -> None:
    (least, most) = re.findall(
        r"mN m here \(`BrakeHysteresis`\), ([\d.]+) to ([\d.]+) are left", TEXT
    )[0]
    driven = [way for way in brake.WAYS if way.inductance_h > 0]
    left_mnm = [1e3 * brake.left_nm(way) for way in driven]
    assert min(left_mnm) == pytest.approx(float(least), abs=0.06)
    assert max(left_mnm) == pytest.approx(float(most), abs=0.06)
