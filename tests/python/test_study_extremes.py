"""Every extreme of the study holds, and what the guards are for is shown to break without them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from torsio.studies import common

EXTREMES = {
    "turning",
    "counter wraps",
    "clock wraps",
    "stiffness",
    "critical torque",
    "beta",
    "friction",
    "brake lag",
    "inertia ratio",
    "subnormals",
    "delay",
    "not finite",
    "precision",
}


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    out: Path = tmp_path_factory.mktemp("out")
    return common.execute("extremes", out=out, json_file=out / "extremes.json", quick=True)


def test_every_extreme_holds_with_its_guard(results: dict[str, Any]) -> None:
    assert {row["extreme"] for row in results["rows"]} == EXTREMES
    broken = [(row["extreme"], row["case"]) for row in results["rows"] if not row["holds"]]
    assert broken == []
    assert results["all_hold"]


@pytest.mark.parametrize("extreme", sorted(EXTREMES - {"beta"}))
def test_each_guard_is_needed(results: dict[str, Any], extreme: str) -> None:
    assert any(row["naive_breaks"] for row in results["rows"] if row["extreme"] == extreme)


def test_figures_and_results_are_written(results: dict[str, Any]) -> None:
    assert results["figures"] == ["extremes_overview.png"]
