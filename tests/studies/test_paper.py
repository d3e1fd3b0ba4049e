"""The reference actuator gives the paper's results."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from torsio.closed_loop import simulate, simulate_many
from torsio.printed.config import Law
from torsio.printed.plant import BrakeHysteresis, PlantParams
from torsio_studies.execution import execute
from torsio_studies.paper import aims, critical, runs

WALLS = (10.0, 20.0, 30.0, 50.0, 70.0, 100.0)  # mN m per degree


def bounces(stiffness: float, law: Law = "paper", **options: Any) -> runs.Bounces:
    loop = runs.bounce_options(stiffness, law, **options)
    return runs.count_bounces(simulate(loop, duration_s=1.0))


def limit(law: Law = "paper", *, most: float = 14.0, **options: Any) -> float:
    stiffness = np.array(np.arange(3.0, most, 0.25 if most < 20 else 1.0), dtype=np.float64)
    loops = [runs.bounce_options(float(k), law, **options) for k in stiffness]
    outcomes = [runs.count_bounces(rows) for rows in simulate_many(loops, duration_s=1.0)]
    return runs.largest_stable(stiffness, outcomes)


# Scenario 1 ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("stiffness", [0.5, 1.0, 2.0, 2.873, 4.0, 6.0, 8.0])
def test_bounce_dies_away_after_a_few_up_to_8(stiffness: float) -> None:
    outcome = bounces(stiffness)
    assert outcome.at_rest
    assert outcome.crossings <= 8


@pytest.mark.parametrize("stiffness", [15.0, 20.0, 40.0])
def test_bounce_never_ends_from_15_on(stiffness: float) -> None:
    outcome = bounces(stiffness)
    assert not outcome.at_rest
    assert outcome.crossings > 50


def test_ten_times_the_rate_at_least_doubles_the_stable_stiffness() -> None:
    base = limit()
    assert 8.0 <= base <= 15.0
    assert limit(rate_hz=10_000.0, most=32.0) >= 2.0 * base


def test_one_sample_of_delay_takes_about_45_percent_off_the_stable_stiffness() -> None:
    # Where exactly it ends without delay depends a little on how the knob was spun up.
    assert limit(delay_ticks=1) / limit() == pytest.approx(0.55, abs=0.08)


# Scenario 2 ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("wall", WALLS)
def test_wall_is_followed_in_and_out_by_the_papers_law(wall: float) -> None:
    _, push = runs.run_push(runs.push_options(runs.per_degree(wall)))
    assert push.peak_torque_nm == pytest.approx(75e-3, rel=0.05)
    assert push.tracking_rms_in <= 0.07
    assert push.tracking_rms_out <= 0.09
    assert push.sensor_rms_nm <= 4.5e-3


def test_torque_gap_is_larger_for_softer_walls() -> None:
    gaps = [
        runs.run_push(runs.push_options(runs.per_degree(wall)))[1].torque_gap_nm for wall in WALLS
    ]
    assert gaps == sorted(gaps, reverse=True)
    assert gaps[0] > 2 * gaps[-1]


def test_torque_gap_is_larger_for_faster_hands() -> None:
    gaps = [
        runs.run_push(runs.push_options(runs.per_degree(30.0), pull_s=pull), extra_s=pull)[
            1
        ].torque_gap_nm
        for pull in (0.5, 1.0, 2.0, 4.0)
    ]
    assert gaps == sorted(gaps, reverse=True)


@pytest.mark.parametrize("ratio", [0.2, 0.4, 0.6, 0.8, 1.0, 1.5])
def test_sensor_crosses_zero_where_the_formula_says(ratio: float) -> None:
    stiffness = ratio * runs.SHAFT_NM_PER_RAD
    rows = simulate(critical.ideal_push(stiffness, 0.5, 50e-3), duration_s=critical.IDEAL_PUSH_S)
    depth = rows["angle_rad"] - 0.01
    turn = int(np.argmax(depth))
    crossing = turn + int(np.flatnonzero(rows["sensed_spring_torque_nm"][turn:] > 0)[0])
    assert depth[crossing] / depth[turn] == pytest.approx(1.0 - 0.5 * ratio, abs=0.01)


# Scenario 3 ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("wall", [5.0, 10.0, 25.0, 50.0, 100.0])
@pytest.mark.parametrize("law", ["paper", "compensated"])
def test_knob_leaves_the_wall_when_the_string_is_cut_or_friction_holds_it(
    wall: float, law: Law
) -> None:
    stiffness = runs.per_degree(wall)
    _, cut = runs.run_cut(runs.cut_options(stiffness, law))
    assert cut.outcome in ("leaves", "held by friction")
    assert cut.stuck_torque_nm == stiffness * max(0.0, cut.final_depth_rad)
    assert (cut.exit_s is None) == (cut.stuck_torque_nm > 0.0)
    assert cut.stuck_torque_nm <= 6e-3 + 2e-3 + stiffness * runs.COUNT_RAD


def test_brake_and_motor_in_parallel_without_a_sensor_stick() -> None:
    rigid = PlantParams(shaft_stiffness_nm_per_rad=50.0)
    _, cut = runs.run_cut(runs.cut_options(runs.per_degree(25.0), "parallel", plant=rigid))
    assert cut.exit_s is None
    assert cut.outcome == "stays"
    assert cut.stuck_torque_nm > 40e-3


# Formulas -----------------------------------------------------------------------------------------


def test_characterisation_finds_the_shaft_and_the_friction() -> None:
    found = runs.characterise()
    assert found.slope_nm_per_rad == pytest.approx(2.873, rel=0.01)
    assert found.offset_nm == pytest.approx(6e-3, rel=0.05)


def test_critical_torque_is_that_of_the_formula_on_an_ideal_plant() -> None:
    cases = [
        (ratio * runs.SHAFT_NM_PER_RAD, beta)
        for beta in (0.1, 0.5, 0.9, 1.0)
        for ratio in (0.1, 0.5, 1.0, 2.5, 4.0)
    ]
    found = critical.measured_critical_torque(cases, halvings=9)
    expected = [critical.critical_torque(stiffness, beta) for stiffness, beta in cases]
    np.testing.assert_allclose(found, expected, rtol=0.03)


@pytest.mark.parametrize(
    ("stiffness", "beta", "expected"),
    [
        (0.0, 0.5, 85e-3),
        (0.5 * 2.873, 0.5, 85e-3 / 0.75),
        (2.873, 0.5, 170e-3),
        (3 * 2.873, 0.5, 127.5e-3),
        (2.873, 1.0, 195e-3),  # a pole of the printed formula
        (0.5 * 2.873, 1.0, 140e-3),  # the brake's own limit
        (1e6, 0.5, 85e-3 * 1e6 / (1e6 - 2.873)),
    ],
)
def test_critical_torque_formula_at_known_points(
    stiffness: float, beta: float, expected: float
) -> None:
    assert critical.critical_torque(stiffness, beta) == pytest.approx(expected)


# Better than the paper ----------------------------------------------------------------------------


def test_compensated_law_closes_the_gap_and_halves_the_way_out() -> None:
    stiffness = runs.per_degree(30.0)
    _, paper = runs.run_push(runs.push_options(stiffness))
    _, better = runs.run_push(runs.push_options(stiffness, "compensated"))
    assert 10e-3 <= paper.torque_gap_nm <= 16e-3
    assert 0.05 <= paper.tracking_rms_out <= 0.075
    assert better.torque_gap_nm <= 3e-3
    assert better.tracking_rms_out <= 0.015
    assert better.sensor_rms_nm <= 0.75 * paper.sensor_rms_nm

    _, slow = runs.run_cut(runs.cut_options(runs.per_degree(25.0)))
    _, fast = runs.run_cut(runs.cut_options(runs.per_degree(25.0), "compensated"))
    assert slow.exit_s is not None
    assert fast.exit_s is not None
    assert fast.exit_s <= 0.6 * slow.exit_s


def test_higher_rate_and_finer_encoder_are_better_still() -> None:
    stiffness = runs.per_degree(30.0)
    fine: dict[str, Any] = {"rate_hz": 10_000.0, "counts_per_rev": 32_768}
    _, push = runs.run_push(runs.push_options(stiffness, "compensated", **fine))
    assert push.tracking_rms_out <= 0.011
    assert limit("compensated", most=32.0, **fine) >= 20.0


def test_it_is_the_brakes_lag_that_damps_the_compensated_law() -> None:
    with_lag = runs.bounce_options(2.0, "compensated")
    assert runs.count_bounces(simulate(with_lag, duration_s=1.0)).at_rest
    for drag in (0.0, 2e-3):
        plant = replace(with_lag.plant, brake_time_constant_s=0.0, brake_drag_nm=drag)
        without = simulate(replace(with_lag, plant=plant), duration_s=1.0)
        assert runs.count_bounces(without).oscillation_rad > 0.1


def test_hysteresis_of_5_percent_is_the_main_threat() -> None:
    stiffness = runs.per_degree(30.0)
    _, clean = runs.run_push(runs.push_options(stiffness))
    _, real = runs.run_push(
        runs.push_options(stiffness, plant=PlantParams(brake_hysteresis=BrakeHysteresis()))
    )
    assert real.tracking_rms_out - clean.tracking_rms_out >= 0.04


# The study ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("out")


@pytest.fixture(scope="module")
def results(folder: Path) -> dict[str, Any]:
    return execute("paper", out=folder, json_file=folder / "paper.json", quick=True)


def test_no_law_leaves_a_wall_sooner_than_its_inertia_lets_it(results: dict[str, Any]) -> None:
    """The time of a mass that a spring alone drives from rest against dry friction."""
    inertia, friction, held = 6e-5, 6e-3, 50e-3
    turned = math.acos(-friction / (held - friction))
    of = results["aims"]
    for row in of["rows"]:
        for left in row["exits"]:
            stiffness = math.degrees(1e-3 * left["wall_mnm_per_deg"])
            least = turned * math.sqrt(inertia / stiffness)
            assert left["exit_s"] is None or left["exit_s"] > least
    paper, unknown, calibrated, measured, light = of["rows"]
    # The price of the inertia with a coarse encoder: docs/explanation/theory.md.
    without, with_it, *_ = of["at_8192_counts"]
    assert without["sensor_rms_nm"] < with_it["sensor_rms_nm"] < 2.0 * without["sensor_rms_nm"]
    assert with_it["torque_gap_nm"] < 0.75 * without["torque_gap_nm"]
    assert with_it["tracking_out"] < without["tracking_out"]
    # Walls in which a mass needs more than the 10 ms that are aimed at.
    assert turned * math.sqrt(inertia / math.degrees(25e-3)) > of["aims"]["slowest_exit_s"]
    # The stated gain of each step.
    assert unknown["torque_gap_nm"] < 0.2 * paper["torque_gap_nm"]
    for name in ("tracking_out", "torque_gap_nm", "soft_torque_gap_nm", "sensor_rms_nm"):
        assert calibrated[name] < 0.7 * unknown[name]
        assert light[name] < 1.3 * calibrated[name]
        assert max(calibrated[name], measured[name]) < 1.15 * of["aims"][name]
    # 10 % hysteresis that no law knows is itself the error: 11 of 75 mN m.
    assert unknown["imperfect_tracking_out"] == pytest.approx(11.0 / 75.0, rel=0.1)
    for told in (calibrated, measured):
        assert told["imperfect_tracking_out"] < of["aims"]["imperfect_tracking_out"]
    # Dry friction of knob and brake, and the assist.
    assert unknown["drag_nm"] == pytest.approx(8e-3, abs=1e-3)
    assert calibrated["drag_nm"] == pytest.approx(unknown["drag_nm"] - 5.8e-3, abs=0.3e-3)
    # A calibration proposes 0.73 of the friction's 6 and the drag's 2 mN m.
    assert measured["drag_nm"] == pytest.approx(unknown["drag_nm"] - 0.73 * 8e-3, abs=0.4e-3)
    assert measured["drag_nm"] < of["aims"]["drag_nm"]


def test_exits_are_as_good_at_other_places_within_a_count(results: dict[str, Any]) -> None:
    worst = {row["exit_rad_s"]: row for row in results["aims"]["worst"]}
    for speed in (0.1, 0.25, 0.6):
        assert worst[speed]["tracking_out"] < 0.8e-2
        assert worst[speed]["torque_gap_nm"] < 1.25e-3
        assert worst[speed]["sensor_rms_nm"] < 1.3 * results["aims"]["aims"]["sensor_rms_nm"]
    # The brake has no time to let go.
    assert 0.6e-2 < worst[1.0]["tracking_out"] < 1.1e-2
    assert 1.2e-3 < worst[1.0]["torque_gap_nm"] < 2.5e-3
    places, row = results["aims"]["worst_places"], results["aims"]["rows"][2]
    assert row["soft_torque_gap_nm"] <= places["soft_torque_gap_nm"] < 1.5e-3
    assert row["imperfect_tracking_out"] <= places["imperfect_tracking_out"] < 2.5e-2
    assert row["slowest_exit_s"] <= places["slowest_exit_s"] < 1.05 * row["slowest_exit_s"]
    assert row["drag_nm"] <= places["drag_nm"] < results["aims"]["aims"]["drag_nm"]
    # Each of three counts switches no more than the knob's friction of 6 mN m, and the drag's part.
    assert 2 * 6e-3 < results["aims"]["held_leap_nm"] <= 3 * 1.25 * 6e-3


def test_slow_exits_are_good_wherever_knob_or_wall_begins_within_a_count() -> None:
    (known,) = (one for one in aims.VARIANTS if one.name == "calibrated")
    places = [place / aims.PLACES for place in range(aims.PLACES)]
    for begins in ([(place, 0.0) for place in places], [(0.0, place) for place in places]):
        found = aims.worst(known, 0.25, begins)
        assert found["tracking_out"] < 0.75e-2
        assert found["tracking_out_95"] < 0.5e-2
        assert found["torque_gap_nm"] < 1.18e-3
        assert found["torque_gap_95_nm"] < 1e-3


def test_wrong_belief_costs_what_a_law_without_torque_sensor_pays(results: dict[str, Any]) -> None:
    wrong = {row["belief"]: row for row in results["aims"]["wrong_beliefs"]}
    # A fifth of the half that the spring carries is a tenth of the peak; it grows along the way.
    assert 0.05 < wrong["spring_stiffness_nm_per_rad"]["tracking_out"] < 0.1
    assert all(row["torque_gap_nm"] < 15e-3 for row in wrong.values())
    for board in ("motor_torque_constant_nm_per_a", "current_sense_v_per_a"):
        assert 0.1 < wrong[board]["tracking_out"] < 0.16  # the motor carries half of the torque
    assert 0.03 < wrong["brake_hysteresis_nm"]["tracking_out"] < 0.05
    assert 0.06 < wrong["brake_torque_constant_nm_per_a"]["tracking_out"] < 0.1
    for belief in ("brake_time_constant_s", "brake_inertia_kg_m2", "brake_drag_nm"):
        assert 0.6e-2 < wrong[belief]["tracking_out"] < 3.2e-2
    for belief in ("knob_coulomb_nm", "knob_inertia_kg_m2", "motor_time_constant_s"):
        assert wrong[belief]["tracking_out"] < 0.75e-2


def test_study_sets_the_papers_statements_beside_what_came_out(
    results: dict[str, Any], folder: Path
) -> None:
    assert len(results["figures"]) == 8
    for figure in results["figures"]:
        assert (folder / figure).stat().st_size > 20_000
    verdicts = {row["verdict"] for row in results["statements"]}
    assert verdicts == {"holds", "partly", "wrong", "not found"}
    assert results["critical_torque"]["largest_error"] <= 0.03
    for row in results["zero_crossing"]["rows"]:
        assert math.isclose(row["found"], row["formula"], abs_tol=0.01)


def test_events_of_a_visit_come_in_the_order_of_the_papers_figure() -> None:
    rows, push = runs.run_push(runs.push_options(runs.per_degree(30.0)))
    events = runs.wall_events(rows, push, 0.5)
    assert len(events) == len(runs.WALL_EVENTS)
    assert list(events) == sorted(set(events))
    slips, meets, most, rests, turns, empty, released, leaves = events
    depth = rows["angle_rad"] - runs.WALL_RAD
    assert rows["brake_sticks"][:slips].all()
    assert abs(rows["spring_torque_nm"][slips]) == pytest.approx(2e-3, rel=0.2)  # the drag
    assert abs(depth[meets]) < 2 * runs.COUNT_RAD
    assert abs(depth[leaves]) < 2 * runs.COUNT_RAD
    # In between the motor gives more than half of the wanted torque.
    share = np.abs(rows["motor_torque_nm"]) / np.maximum(np.abs(rows["desired_torque_nm"]), 1e-9)
    assert share[most] > 0.5 + 0.05
    assert share[rests] < share[most]
    assert depth[rests] == pytest.approx(depth.max(), rel=0.01)
    assert rows["spring_torque_nm"][turns] < 0 <= rows["sensed_spring_torque_nm"][empty]
    assert rows["brake_capacity_nm"][released] < 5e-3 < rows["brake_capacity_nm"][empty]


def test_a_wall_stiffer_than_the_shaft_lacks_one_of_the_events() -> None:
    rows, push = runs.run_push(runs.push_options(runs.per_degree(30.0)))
    rows = rows.copy()
    rows["sensed_spring_torque_nm"] = -1e-3
    with pytest.raises(ValueError, match="all of its events"):
        runs.wall_events(rows, push, 0.5)
