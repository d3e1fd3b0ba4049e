"""The choice of a method for a tolerance, and the study that measures it."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from typer.testing import CliRunner

import torsio
from tests.python.parts_oracle import Rows
from tests.python.plant_oracle import OraclePlant, OracleRun
from torsio.cli import app
from torsio.emulator import Plant
from torsio.studies import common, fidelity

MS = 1_000_000
Array = npt.NDArray[np.float64]


def commands(count: int) -> tuple[Array, Array]:
    tick = np.arange(count)
    motor = -0.01 - 0.005 * (tick // 40 % 3)
    brake = 0.03 + 0.01 * (tick // 90 % 4)
    return motor.astype(np.float64), brake.astype(np.float64)


def relative_error(angles: Array, truth: Array) -> float:
    twist, true_twist = angles[:, 0] - angles[:, 1], truth[:, 0] - truth[:, 1]
    return max(
        float(np.abs(angles[:, 0] - truth[:, 0]).max() / np.ptp(truth[:, 0])),
        float(np.abs(twist - true_twist).max() / np.abs(true_twist).max()),
    )


def oracle(profile: list[tuple[float, float]], motor: Array, brake: Array) -> Array:
    """Angles of knob and brake at the ticks' ends, from an independent simulation."""
    times, values = np.asarray(profile).T
    run = OracleRun(OraclePlant(), hand_torque_nm=lambda t: float(np.interp(t, times, values)))
    rows = []
    for command in zip(motor, brake, strict=True):
        run.advance(1e-3, *map(float, command))
        rows.append(run.y[:2].copy())
    return np.asarray(rows)


@pytest.mark.parametrize("tolerance", [0.5, 0.1, 1e-3])
def test_estimate_bounds_the_true_error_against_an_independent_simulation(
    tolerance: float,
) -> None:
    motor, brake = commands(300)
    profile = [(0.0, 0.0), (0.1, 0.07), (0.2, 0.07), (0.3, -0.05)]
    plant = Plant(hand=torsio.TorqueHand(torque_nm=profile), tolerance=tolerance)
    error = relative_error(plant.drive(motor, brake), oracle(profile, motor, brake))
    took = plant.fidelity
    assert error <= tolerance
    assert took["estimated_error"] <= tolerance
    # The oracle itself is good to some 1e-10.
    assert took["estimated_error"] >= 0.9 * error - 1e-9
    assert took["estimated_error"] <= 50 * error + 1e-9


def test_estimate_bounds_the_error_of_cheap_steps_against_an_independent_simulation() -> None:
    params = torsio.PlantParams(belt=torsio.Belt(stiffness_nm_per_rad=1e4))
    path = [(0.0, 0.0), (0.4, 0.4)]
    hand = torsio.ImpedanceHand(
        intended_angle_rad=path,
        stiffness_nm_per_rad=1.0,
        damping_nm_s_per_rad=10e-3,
        inertia_kg_m2=1e-4,
    )

    def hand_nm(time_s: float, angle_rad: float, speed_rad_s: float) -> float:
        return 1.0 * (time_s - angle_rad) + 10e-3 * (1.0 - speed_rad_s)

    ticks = 250
    motor, brake = np.full(ticks, -0.01), np.full(ticks, 0.03)
    plant = Plant(params, hand, tolerance=0.1)
    rows = plant.record(motor, brake)
    truth, seen = Rows(params, hand_nm, hand_kg_m2=1e-4, max_step_s=math.inf), []
    for command in zip(motor, brake, strict=True):
        truth.advance(*map(float, command))
        seen.append(truth.seen())
    errors = []
    for key, true in zip(("angle_rad", "spring_torque_nm"), np.asarray(seen).T, strict=True):
        got = np.append(rows[key][1:], plant.state[key])
        errors.append(float(np.abs(got - true).max()) / float(np.abs(true).max()))
    took = plant.fidelity
    assert took["steps_trapezoid"] > 0
    assert 1e-6 < max(errors) <= 0.1  # far beyond the error of exact steps, and of SciPy
    assert 0.9 * max(errors) <= took["estimated_error"] <= 0.1


def test_cheaper_methods_err_as_their_order_says_and_smoothed_friction_never_gets_there() -> None:
    motor, brake = commands(300)
    profile = [(0.0, 0.0), (0.1, 0.07), (0.2, 0.07), (0.3, -0.05)]
    hand = torsio.TorqueHand(torque_nm=profile)
    truth = oracle(profile, motor, brake)

    def error(method: str, step_us: int) -> float:
        plant = Plant(hand=hand, method=method, step_ns=1000 * step_us)  # type: ignore[arg-type]
        return relative_error(plant.drive(motor, brake), truth)

    assert error("exact", 1000) < 1e-9
    assert error("trapezoid", 10) < 0.1 * error("trapezoid", 250) < 0.1
    assert error("semi_implicit", 10) < 0.2 * error("semi_implicit", 250)
    assert error("trapezoid", 10) < error("semi_implicit", 10)
    assert error("regularised", 10) > 1e-3


@pytest.mark.parametrize("tolerance", [0.0, -1.0, 1e-12, float("nan"), float("inf")])
def test_tolerance_that_nothing_can_keep_is_refused_by_name(tolerance: float) -> None:
    with pytest.raises(torsio.InvalidArgument, match="tolerance"):
        torsio.open("emulated", emulator=torsio.EmulatorOptions(tolerance=tolerance))
    with pytest.raises(ValueError, match="tolerance"):
        Plant(tolerance=tolerance)


def test_going_on_is_refused_once_rounding_alone_exceeds_the_tolerance() -> None:
    # A shaft that swings 3e5 times a tick.
    plant = Plant(torsio.PlantParams(shaft_stiffness_nm_per_rad=1e14), tolerance=1e-9)
    ticks = np.arange(300)
    with pytest.raises(RuntimeError, match=r"nothing keeps the tolerance 1e-09 .*rounding"):
        plant.record(0.08 * np.sin(0.3 * ticks), np.full(len(ticks), 0.01))


def test_open_knob_tells_what_it_took_for_a_tolerance() -> None:
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(tolerance=1e-3)) as knob:
        knob.sleep(0.2)
        took = knob.emulator.fidelity()
    assert took.tolerance == 1e-3
    assert took.steps_exact + took.steps_trapezoid + took.steps_semi_implicit >= 200
    assert took.estimated_error <= 1e-3
    with torsio.open("emulated") as knob:
        assert knob.emulator.fidelity().tolerance == 0
        assert knob.emulator.fidelity().method == "exact"


def test_demo_with_a_tolerance_feels_the_same_and_reports_the_choice(tmp_path: Path) -> None:
    result = CliRunner().invoke(
        app, ["demo", "wall", "--out", str(tmp_path), "--tolerance", "0.01"]
    )
    assert result.exit_code == 0, result.output
    numbers = json.loads((tmp_path / "virtual_wall.json").read_text())
    assert numbers["fidelity"]["tolerance"] == 0.01
    assert numbers["fidelity"]["estimated_error"] <= 0.01
    assert numbers["tracking_rms_in"] <= 0.07
    assert "estimated" in result.output


def test_demo_refuses_a_tolerance_that_nothing_can_keep(tmp_path: Path) -> None:
    arguments = ["demo", "wall", "--out", str(tmp_path), "--tolerance", "1e-15"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code != 0
    assert "tolerance" in result.output


def test_best_fixed_is_the_fastest_own_way_that_keeps_the_tolerance() -> None:
    def row(method: str, error: float, factor: float, scenario: int = 2) -> dict[str, Any]:
        return {
            "scenario": scenario,
            "method": method,
            "error": error,
            "realtime_factor": factor,
        }

    rows = [
        row("exact", 1e-12, 10.0),
        row("trapezoid", 1e-4, 20.0),
        row("semi_implicit", 5e-3, 40.0),
        row("mujoco", 1e-6, 100.0),
        row("trapezoid", 1e-6, 80.0, scenario=3),
        row("regularised", math.inf, 90.0),
    ]
    for tolerance, expected in ((1e-2, rows[2]), (1e-3, rows[1]), (1e-6, rows[0]), (1e-15, None)):
        asked = {"scenario": 2, "tolerance": tolerance}
        assert fidelity.best_fixed(rows, asked) is expected


def test_study_fidelity_sets_every_method_beside_the_truth(tmp_path: Path) -> None:
    results = common.execute(
        "fidelity", json_file=tmp_path / "fidelity.json", out=tmp_path, quick=True
    )
    assert results == common.load(tmp_path / "fidelity.json", "fidelity")
    assert (tmp_path / "fidelity_pareto.png").stat().st_size > 20_000
    rows = results["rows"]
    methods = {"exact", "trapezoid", "semi_implicit", "regularised", "mujoco", "mujoco_default"}
    for number in (2, 3):
        own = [row for row in rows if row["scenario"] == number]
        assert {row["method"] for row in own} == methods | {"automatic"}
        for row in own:
            assert row["realtime_factor"] > 0
            if row["method"] == "exact":
                assert row["error"] < 1e-8
            if row["method"] in ("regularised", "mujoco_default"):
                assert row["error"] > 1e-3
            if row["method"] == "automatic":
                assert row["error"] <= row["tolerance"]
                assert row["estimated_error"] <= row["tolerance"]
    for summary in results["summary"]:
        assert summary["target_error"] == 1e-3
        assert summary["exact"]["error"] <= 1e-3
        # No assertion on time beyond what no load of the machine can turn round.
        if summary["ratio"] is not None:
            assert summary["ratio"] > 10
            assert summary["mujoco"]["error"] <= 1e-3
