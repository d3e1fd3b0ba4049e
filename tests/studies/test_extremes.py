"""Every extreme of the study holds, and what the guards are for is shown to break without them."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from torsio import closed_loop
from torsio.perception import VIBRATION_NM
from torsio.printed import config, hands, scenes
from torsio_studies.execution import execute
from torsio_studies.extremes import dynamics, not_finite

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
    return execute("extremes", out=out, json_file=out / "extremes.json", quick=True)


def test_every_extreme_holds_with_its_guard(results: dict[str, Any]) -> None:
    assert {row["extreme"] for row in results["rows"]} == EXTREMES
    broken = [(row["extreme"], row["case"]) for row in results["rows"] if not row["holds"]]
    assert broken == []
    assert results["all_hold"]


@pytest.mark.parametrize("extreme", sorted(EXTREMES))
def test_each_guard_is_needed(results: dict[str, Any], extreme: str) -> None:
    assert any(row["naive_breaks"] for row in results["rows"] if row["extreme"] == extreme)


def test_figures_and_results_are_written(results: dict[str, Any]) -> None:
    assert results["figures"] == ["extremes_overview.png"]


# Delay --------------------------------------------------------------------------------------------


def test_it_is_the_delay_that_breaks_what_is_shown_with_one() -> None:
    for stiffness, law in ((7.0, "paper"), (1.5, "motor_only")):
        without = dynamics.bounce_vibration_nm(stiffness, law)  # type: ignore[arg-type]
        late = dynamics.bounce_vibration_nm(stiffness, law, delay_ticks=1)  # type: ignore[arg-type]
        assert without < VIBRATION_NM < 20e-3 < late


# Not finite ---------------------------------------------------------------------------------------


def _parts(value: Any) -> Iterator[type]:
    """Give the classes of a value and of all that is in it."""
    if isinstance(value, tuple):
        for item in value:
            yield from _parts(item)
    elif dataclasses.is_dataclass(value):
        yield type(value)
        for one in dataclasses.fields(value):
            yield from _parts(getattr(value, one.name))


def _has_floats(kind: type) -> bool:
    return any("float" in str(hint) for hint in typing.get_type_hints(kind).values())


def test_every_class_with_quantities_is_offered_what_is_not_finite() -> None:
    good_ones = (*not_finite.LOOPS, *not_finite.CONFIGS, not_finite.EXPERIMENT)
    offered = {kind for good in good_ones for kind in _parts(good)}
    public = [
        getattr(module, name)
        for module in (closed_loop, config, hands, scenes)
        for name in module.__all__
    ]
    wanted = {
        one
        for one in public
        if isinstance(one, type) and dataclasses.is_dataclass(one) and _has_floats(one)
    }
    assert {scenes.Ramp, scenes.Timing, hands.ImpedanceHand, config.BoardConfig} <= wanted
    assert wanted <= offered, {one.__name__ for one in wanted - offered}


def test_a_value_that_is_let_in_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not_finite.accepted_in_python()[1] == 0

    def lenient(_: Any, *, motor_command_nm: float = 0.0, brake_command_nm: float = 0.0) -> None:
        pass

    monkeypatch.setattr(closed_loop.ClosedLoop, "hold_command", lenient)
    assert not_finite.accepted_in_python()[1] == 3 * 2
