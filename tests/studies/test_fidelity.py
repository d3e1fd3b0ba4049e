"""The methods that step the plant, and the study that sets them beside the truth."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import torsio
from tests.python.plant_oracle import OraclePlant, OracleRun
from torsio_studies import common
from torsio_studies.execution import execute
from torsio_studies.fidelity import drake_model
from torsio_studies.fidelity.truth import PLANT, hand_torque
from torsio_studies.steppers import METHODS, Method, make_plant

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


def test_cheaper_methods_err_as_their_order_says_and_smoothed_friction_never_gets_there() -> None:
    motor, brake = commands(300)
    profile = [(0.0, 0.0), (0.1, 0.07), (0.2, 0.07), (0.3, -0.05)]
    hand = torsio.TorqueHand(torque_nm=profile)
    truth = oracle(profile, motor, brake)

    def error(method: Method, step_us: int) -> float:
        plant = make_plant(method, hand=hand, step_ns=1000 * step_us)
        return relative_error(plant.drive(motor, brake), truth)

    assert error("exact", 1000) < 1e-9
    # Sums and differences lose some of 24 bits and keep most.
    assert 2.0**-24 < error("exact_single", 1000) < 2.0**-14
    assert error("trapezoid", 10) < 0.1 * error("trapezoid", 250) < 0.1
    assert error("semi_implicit", 10) < 0.2 * error("semi_implicit", 250)
    assert error("trapezoid", 10) < error("semi_implicit", 10)
    assert error("regularised", 10) > 1e-3


@pytest.mark.slow
def test_drake_comes_nearer_to_the_truth_with_its_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install = (*("-m", "pip", "install", "-q", "--no-deps", "--target"), str(tmp_path))
    subprocess.run([sys.executable, *install, "drake>=1.51", "mosek"], check=True)
    monkeypatch.syspath_prepend(tmp_path)
    motor, brake = commands(300)
    profile = [(0.0, 0.0), (0.1, 0.07), (0.2, 0.07), (0.3, -0.05)]
    hand, truth = hand_torque(torsio.TorqueHand(torque_nm=profile)), oracle(profile, motor, brake)
    errors = {}
    for choice in drake_model.choices((50, 500)):
        angles, cpu_s = drake_model.simulate(
            PLANT, hand, motor, brake, period_s=1e-3, choice=choice
        )
        errors[choice] = relative_error(angles, truth)
        assert cpu_s > 0.0
    for contact in ("Tamsi", "Lagged"):
        assert errors[contact, 50, None] < 0.15 * errors[contact, 500, None] < 0.1
    assert errors["cenic", 20, 1e-7] < 0.3 * errors["cenic", 1000, 1e-3] < 0.1


def test_study_fidelity_sets_every_method_beside_the_truth(tmp_path: Path) -> None:
    results = execute("fidelity", json_file=tmp_path / "fidelity.json", out=tmp_path, quick=True)
    assert results == common.load(tmp_path / "fidelity.json", "fidelity")
    assert (tmp_path / "fidelity_pareto.png").stat().st_size > 20_000
    rows = results["rows"]
    methods = {*METHODS, "mujoco", "mujoco_default", "scipy"}
    for number in (2, 3):
        own = [row for row in rows if row["scenario"] == number]
        assert {row["method"] for row in own} - {"drake"} == methods
        for row in own:
            assert row["realtime_factor"] > 0
            if row["method"] == "exact":
                assert row["error"] < 1e-12
            if row["method"] == "exact_single":
                assert 1e-8 < row["error"] < 1e-3
            if row["method"] == "scipy":  # a closer tolerance errs less
                assert row["error"] < 100.0 * float(row["settings"].split()[1])
            if row["method"] in ("regularised", "mujoco_default"):
                assert row["error"] > 1e-3
    loops = {
        (row["parts"], row["control_rate_hz"]): row
        for row in results["closed_loop"]
        if row["precision"] == "double"
    }
    assert loops["all", 20_000]["error"] == 0.0  # the others' reference
    assert loops["all", 1_000]["error_rms"] > loops["all", 10_000]["error_rms"] > 0.0
    for parts in ("without hardening", "without hysteresis", "without belt", "without cogging"):
        assert loops[parts, 20_000]["error"] > 1e-3, parts
    assert loops["none", 20_000]["error"] > 1e-2
    # A count that flips a tick earlier or later shifts all that follows; rounding alone shifts
    # less.
    for row in results["closed_loop"]:
        if row["precision"] == "single" and row["control_rate_hz"] == 1_000:
            assert row["error_rms"] == pytest.approx(loops["all", 1_000]["error_rms"], rel=0.1)
    assert 2.0**-26 < results["law"]["error"] < 2.0**-16
    first, *others = results["played"]
    assert first["method"] == "torsio.batch"
    assert first["error"] < 1e-8
    assert [row["method"] for row in others] == ["mujoco.rollout"] * len(others)
    assert [row["error"] for row in others] == sorted((r["error"] for r in others), reverse=True)
    assert others[-1]["error"] < 0.05
    assert all(row["knobs_in_real_time"] > 0 for row in (*loops.values(), *results["played"]))
    for summary in results["summary"]:
        assert summary["target_error"] == 1e-3
        assert summary["exact"]["error"] <= 1e-3
        # Only orders of time that no load of the machine turns round.
        if summary["ratio"] is not None:
            assert summary["ratio"] > 10
            assert summary["mujoco"]["error"] <= 1e-3
