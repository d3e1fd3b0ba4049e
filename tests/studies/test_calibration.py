"""A short form of `torsio study calibration`: a few hidden knobs, and some that are broken."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import torsio
from tests.once import once
from torsio import ShaftConfig
from torsio.calibration import Refusal, calibrate, doubts
from torsio.calibration.free import FREE_LIMIT_RAD_S
from torsio.calibration.quantity import Quantity
from torsio.printed.plant import BrakeHysteresis, Cogging, PlantParams, ShaftHardening
from torsio_studies.calibration import study as calibration_study
from torsio_studies.calibration.driven import ALL
from torsio_studies.calibration.knobs import (
    QUANTITIES,
    RATE_HZ,
    WALL_NM_PER_RAD,
    emulated,
    hidden_knob,
    measure,
    truth_of,
    wall_error,
)
from torsio_studies.calibration.sabotages import SABOTAGES, try_out
from torsio_studies.execution import execute
from torsio_studies.paper.runs import push_options, run_push

KNOBS = 4


@pytest.fixture(scope="module")
def rows() -> list[dict[str, float]]:
    kept = Path(__file__).parents[2] / "build/tests/hidden-knobs.json"
    found: list[dict[str, float]] = once(
        kept, lambda: [measure(hidden_knob(1000 + number)) for number in range(KNOBS)]
    )
    return found


def test_hidden_knobs_are_found_to_the_end_within_the_time(rows: list[dict[str, float]]) -> None:
    assert all(row["complete"] == 1.0 and row["refused_rightly"] == 1.0 for row in rows)
    assert max(row["knob_seconds"] for row in rows) < 90.0


def test_wall_is_as_good_with_what_was_found_as_with_the_true_values(
    rows: list[dict[str, float]],
) -> None:
    for row in rows:
        assert 0.0 < row["wall_found"] <= 1.2 * row["wall_true"]
    # The device's configuration is far from the truth.
    plant = hidden_knob(1000).plant
    with emulated(plant) as knob:
        believed = knob.actuator_config()
    options = push_options(WALL_NM_PER_RAD, "calibrated", rate_hz=RATE_HZ, plant=plant)
    unknown = run_push(replace(options, actuator=believed, shaft=ShaftConfig()))[1]
    assert unknown.tracking_rms_out > 2.0 * rows[0]["wall_found"]


def test_error_in_a_wall_is_the_same_wherever_the_knob_lies_in_a_count() -> None:
    plant = hidden_knob(1005).plant
    one, other = (wall_error(replace(plant, encoder_phase_counts=phase)) for phase in (0.0, 0.37))
    assert one == other
    # A single place would be luck.
    options = push_options(WALL_NM_PER_RAD, "calibrated", rate_hz=RATE_HZ, plant=plant)
    there = [
        run_push(replace(options, plant=replace(plant, encoder_phase_counts=phase)))[1]
        for phase in (0.0, 0.25, 0.5, 0.75)
    ]
    errors = [push.tracking_rms_out for push in there]
    assert max(errors) > 1.1 * min(errors)
    assert min(errors) < one < max(errors)


def test_nearly_all_intervals_hold_the_truth(rows: list[dict[str, float]]) -> None:
    scores = [
        (row[f"{name}_value"] - row[f"{name}_truth"]) / row[f"{name}_sigma"]
        for row in rows
        for name in QUANTITIES
        if np.isfinite(row[f"{name}_value"]) and np.isfinite(row[f"{name}_truth"])
    ]
    assert len(scores) > 12 * KNOBS
    # Of 60 or more at 95 %; the study itself counts each quantity over 200 knobs.
    assert np.mean(np.abs(scores) <= 1.96) >= 0.8, scores
    assert np.max(np.abs(scores)) < 8.0, scores


def test_less_than_three_quarters_of_the_true_friction_is_proposed_to_be_taken_off(
    rows: list[dict[str, float]],
) -> None:
    for row in rows:
        table = {name: np.array([value]) for name, value in row.items()}
        assert 0.65 < calibration_study.assisted(table) < 0.73


@pytest.mark.parametrize("number", [1002, 1003])
def test_quick_calibration_at_a_board_s_rate_says_nothing_of_swings_it_did_not_make(
    number: int,
) -> None:
    hidden = hidden_knob(number)
    with emulated(hidden.plant, seed=number) as knob:
        found = calibrate(knob, drift=True).quantities
    assert not {"knob_inertia_kg_m2", "shaft_damping_nm_s_per_rad", "rise_s"} & set(found)
    truth = truth_of(hidden.plant)
    for name in ("inertia_kg_m2", "coulomb_nm", "stiffness_nm_per_rad"):
        assert found[name].value == pytest.approx(truth[name], rel=0.01)


@pytest.mark.parametrize("number", [401, 404, 406])
def test_intervals_hold_the_truth_at_a_slow_control_rate(number: int) -> None:
    hidden = hidden_knob(number)
    with emulated(hidden.plant, rate_hz=1_000.0, seed=number) as knob:
        found = calibrate(knob).quantities
    truth = truth_of(hidden.plant)
    missed = [
        name
        for name, of in found.items()
        if abs(of.value - truth[name]) > 1.96 * of.standard_uncertainty
    ]
    assert missed == []


REFERENCE = PlantParams()
FAR = {
    "loop of 14.5 mN m": replace(
        REFERENCE, brake_hysteresis=BrakeHysteresis(half_width_nm=14.5e-3)
    ),
    "brake lags by 2 ms": replace(REFERENCE, brake_time_constant_s=2e-3),
    "brake lags by 10 ms": replace(REFERENCE, brake_time_constant_s=10e-3),
    "cogs 48 times": replace(
        REFERENCE, cogging=Cogging.sine(periods_per_rev=48, amplitude_nm=1.5e-3, points=16)
    ),
    "shaft softens at 5 mrad": replace(
        REFERENCE, shaft_hardening=ShaftHardening(knee_rad=5e-3, stiffness_factor=0.5)
    ),
    "the same with a fine encoder": replace(
        REFERENCE,
        counts_per_rev=32_768,
        shaft_hardening=ShaftHardening(knee_rad=5e-3, stiffness_factor=0.5),
    ),
}


@pytest.mark.parametrize("name", FAR)
def test_knob_far_from_the_reference_lies_within_its_intervals(name: str) -> None:
    with emulated(FAR[name], seed=5000) as knob:
        found = calibrate(knob).quantities
    truth = truth_of(FAR[name])
    scores = {
        of.name: (of.value - truth[of.name]) / of.standard_uncertainty
        for of in found.values()
        if np.isfinite(truth[of.name])
    }
    missed = {of: score for of, score in scores.items() if abs(score) > 1.96}
    # Of 17 and more at 95 %.
    assert len(missed) <= 2, missed
    assert max(map(abs, scores.values())) < 3.0, missed


@pytest.mark.parametrize(
    ("plant", "step", "reason", "words"),
    [
        (
            replace(REFERENCE, brake_hysteresis=BrakeHysteresis(half_width_nm=19e-3)),
            "brake",
            "wide_loop",
            "loop",
        ),
        (
            replace(
                REFERENCE, cogging=Cogging.sine(periods_per_rev=90, amplitude_nm=1.5e-3, points=16)
            ),
            "shaft",
            "unexplained",
            "cogs often",
        ),
    ],
    ids=["loop of 19 mN m", "cogs 90 times"],
)
def test_knob_that_the_model_does_not_fit_is_refused(
    plant: PlantParams, step: str, reason: str, words: str
) -> None:
    with emulated(plant, seed=5000) as knob, pytest.raises(Refusal, match=words) as refused:
        calibrate(knob)
    assert (refused.value.step, refused.value.reason) == (step, reason)


def test_longer_ticks_leave_out_more_and_a_board_s_nothing() -> None:
    damping = Quantity("shaft_damping_nm_s_per_rad", 2e-4, 3e-5)
    added = [*(doubts.of_ticks({"": damping}, tick_s)[""] for tick_s in (50e-6, 100e-6, 1e-3))]
    assert added[:2] == [0.0, 0.0]
    # A fiftieth of a tick beside, on a shaft of 2.87 N m/rad, is another damping of so much.
    assert added[2] == pytest.approx(2.87 * 1e-3 / 50, rel=0.05)


def test_truth_of_a_belt_is_two_springs_in_a_row() -> None:
    plant = next(hidden_knob(n).plant for n in range(50) if hidden_knob(n).plant.belt is not None)
    assert plant.belt is not None
    shaft, belt = plant.shaft_stiffness_nm_per_rad, plant.belt.stiffness_nm_per_rad
    assert truth_of(plant)["stiffness_nm_per_rad"] == pytest.approx(shaft * belt / (shaft + belt))


@pytest.mark.parametrize("sabotage", SABOTAGES, ids=lambda of: of.name)
def test_broken_knob_is_refused_for_the_right_reason(sabotage) -> None:  # type: ignore[no-untyped-def]
    outcome = try_out(sabotage)
    assert outcome.reason == sabotage.reason
    # By the truth, which a dead encoder does not tell. Other motions need no motor.
    assert outcome.fastest_rad_s < FREE_LIMIT_RAD_S or sabotage.reason == "moved"


@pytest.mark.parametrize("rate_hz", [1_000.0, RATE_HZ])
@pytest.mark.parametrize("spring_and_brake", [True, False])
@pytest.mark.parametrize(("dies_at_pulse", "reason"), [(0, "still"), (1, "one_way")])
def test_knob_that_nobody_sees_turn_is_pushed_to_no_more_than_a_sane_speed(
    rate_hz: float, spring_and_brake: bool, dies_at_pulse: int, reason: str
) -> None:
    """Half the inertia that is configured, hardly any friction, and no current that is measured."""
    light = PlantParams(
        knob_inertia_kg_m2=3e-5, brake_inertia_kg_m2=1e-9, knob_coulomb_nm=1e-3, brake_drag_nm=0.0,
        knob_viscous_nm_s_per_rad=0.0, spring_and_brake=spring_and_brake,
    )  # fmt: skip
    options = torsio.EmulatorOptions(
        control_rate_hz=rate_hz, log_truth=True, plant=light, actuator=torsio.ActuatorConfig()
    )
    with torsio.open("emulated", emulator=options) as knob:
        assert knob.actuator_config().knob_inertia_kg_m2 == pytest.approx(6e-5)
        excite, pulses = knob.excite, []

        def die_at(excitation: torsio.Excitation) -> None:
            if excitation.motor_command_nm != 0.0:
                pulses.append(excitation.motor_command_nm)
            knob.emulator.freeze_encoder(frozen=len(pulses) > dies_at_pulse)
            excite(excitation)

        knob.excite = die_at  # type: ignore[method-assign]
        with pytest.raises(Refusal) as refused:
            calibrate(knob)
        assert (refused.value.step, refused.value.reason) == ("signs", reason)
        assert np.abs(knob.emulator.truth()["speed_rad_s"]).max() < 60.0
        # To and fro, never less than before.
        assert np.all(np.diff(np.sign(pulses)) != 0.0)
        assert np.all(np.diff(np.abs(pulses)) >= 0.0)


@pytest.mark.parametrize("step", ["friction and inertia", "brake"])
def test_encoder_that_dies_is_named_and_the_knob_does_not_run_away(step: str) -> None:
    options = torsio.EmulatorOptions(control_rate_hz=RATE_HZ, log_truth=True)
    with torsio.open("emulated", emulator=options) as knob:

        def die(begun: str) -> None:
            if begun == step:
                knob.emulator.freeze_encoder(frozen=True)
                knob.emulator.truth()

        with pytest.raises(Refusal, match="encoder stopped counting") as refused:
            calibrate(knob, progress=die)
        assert refused.value.reason == "runs_away"
        # No faster than the turns may be of a knob that is seen.
        assert np.abs(knob.emulator.truth()["speed_rad_s"]).max() < FREE_LIMIT_RAD_S


@pytest.mark.slow  # a study that trades does the same in every run
def test_study_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def instead(batch):  # type: ignore[no-untyped-def]
        asked.extend(batch.designs)
        row = {"number": 0.0, "refused_rightly": 1.0, "complete": 1.0, "knob_seconds": 30.0}
        row |= {"wall_found": 0.011, "wall_true": 0.01}
        for name in QUANTITIES:
            row |= {f"{name}_truth": 1.0, f"{name}_value": 1.01, f"{name}_sigma": 0.01}
        row |= {f"driven_{name}": row[name] for name in ("refused_rightly", "complete")}
        row |= {"driven_knob_seconds": 40.0}
        for name in ALL:
            row |= {f"driven_{name}_{part}": 1.0 for part in ("truth", "value", "sigma")}
        return [row | {"number": float(number)} for number in batch.designs]

    monkeypatch.setattr(calibration_study, "evaluate_batch", instead)
    monkeypatch.setattr(calibration_study, "SABOTAGES", ())
    settings = {"workers": 1, "knobs": 8}
    first = execute(
        "calibration", out=tmp_path, json_file=tmp_path / "calibration.json", settings=settings
    )
    assert sorted(asked) == [*range(1000, 1008), 2040, 2041]
    next(iter((tmp_path / "calibration").glob("*.parquet"))).unlink()
    asked.clear()
    again = execute("calibration", out=tmp_path, settings=settings)
    assert len(asked) == 4
    assert again["rows"] == first["rows"]
    kept = json.loads((tmp_path / "calibration.json").read_text())
    assert kept["rows"][0]["coverage"] == 1.0
    by_chance = 1.0 / (1.0 + 1.96**2 / 8)  # of eight of eight; Wilson's
    assert kept["rows"][0]["coverage_interval"] == pytest.approx([by_chance, 1.0], abs=1e-4)
    assert [row["quantity"] for row in kept["driven"]["rows"]] == list(ALL)
    assert (kept["driven"]["complete"], kept["driven"]["knob_seconds"]) == (8, 40.0)
    assert (kept["far"]["knobs"], kept["far"]["driven"]["complete"]) == (2, 2)
    assert kept["wall"] == pytest.approx({"found": 0.011, "true": 0.01, "near": 1.0, "worst": 1.1})
    # 0.73 of 1.01 and of the lower end of 1.01 +- 1.96 · 0.01, of 2.
    assert kept["assisted"]["told"] == pytest.approx(0.73 * (1.01 + 0.9904 - 1.0296) / 2.0)
    assert (tmp_path / "calibration_coverage_driven.png").stat().st_size > 10_000
    assert (tmp_path / "calibration_coverage.png").stat().st_size > 10_000
    assert (tmp_path / "calibration_fits.png").stat().st_size > 10_000
