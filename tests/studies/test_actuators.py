"""The study of rival actuators: closed forms, bounds, and that it tells what it is said to tell."""

from __future__ import annotations

import dataclasses
import json
import math
from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import torsio
from torsio.closed_loop import LoopOptions
from torsio.closed_loop import simulate as simulate_loop
from torsio.demos import wall
from torsio.printed.config import ControlConfig
from torsio.telemetry import Record
from torsio_studies import _studies, exits
from torsio_studies.actuators import trials
from torsio_studies.actuators.trials import ACTUATORS, NM_PER_RAD
from torsio_studies.execution import execute

MOTOR_NM, BRAKE_NM, DRAG_NM = 85e-3, 110e-3, 2e-3
KEYS = [actuator.key for actuator in ACTUATORS]


@cache
def _visit(actuator: str, stiffness_mnm_per_deg: float) -> Record:
    return trials.visit_wall(actuator, stiffness_mnm_per_deg / NM_PER_RAD)


def _wall(actuator: str, stiffness_mnm_per_deg: float = 30.0) -> trials.WallMeasures:
    log = _visit(actuator, stiffness_mnm_per_deg)
    return trials.measure_wall(log, stiffness_mnm_per_deg / NM_PER_RAD)


# --- closed forms --------------------------------------------------------------------------------


@pytest.mark.parametrize("viscous", [1e-3, 4e-3])
def test_motor_only_becomes_unstable_at_the_sampled_data_limit(viscous: float) -> None:
    # A spring through a zero-order hold on an inertia with viscous friction: the poles of
    # z^2 - (1 + e) z + e + K (a1 z + a0) leave the unit circle when their product is 1. For small
    # b T / J this is K = 2 b / T.
    inertia, period = 6e-5, 1e-3
    e = math.exp(-viscous * period / inertia)
    a0 = inertia / viscous**2 * (1 - e - viscous * period / inertia * e)
    expected = (1 - e) / a0
    assert expected == pytest.approx(2 * viscous / period, rel=0.05)
    parts = {
        "knob_coulomb_nm": 0.0,
        "rotor_coulomb_nm": 0.0,
        "rotor_viscous_nm_s_per_rad": viscous,
        "motor_time_constant_s": 0.0,
        "motor_limit_nm": 100.0,
    }

    def decays(stiffness: float) -> bool:
        log = _studies.run_actuator(
            "motor_only",
            hand=torsio.NoHand(),
            duration_ns=1_000_000_000,
            parts=parts,
            stiffness_nm_per_rad=stiffness,
            both_ways=True,
            initial_speed_rad_s=18.0,
            counts_per_rev=1 << 30,
        )
        speed = np.abs(log["speed_rad_s"])
        return bool(speed[800:].max() < speed[100:300].max())

    limit = trials.stable_limit(decays, softest=0.5, stiffest=50.0, coarse_steps=10)
    assert limit == pytest.approx(expected, rel=0.02)


def test_free_motion_takes_the_friction_of_what_turns() -> None:
    viscous = {"motor": 2.6e-5 * trials.FREE_RAD_S, "brake": 2e-6 * trials.FREE_RAD_S}
    expected = {
        "motor_only": 6e-3 + viscous["motor"],
        "brake_only": 1e-3 + DRAG_NM + viscous["brake"],
        "parallel": 6e-3 + DRAG_NM + viscous["motor"] + viscous["brake"],
        "soft_sensor_paper": 6e-3 + DRAG_NM + viscous["motor"] + viscous["brake"],
        "soft_spring": 6e-3 + viscous["motor"],  # its motor cancels the spring
        # Its motor takes off the known friction.
        "soft_sensor_calibrated": 6e-3 + DRAG_NM - 5.8e-3 + viscous["motor"] + viscous["brake"],
    }
    for key, drag in expected.items():
        log = trials.turn_freely(key)
        assert log["hand_torque_nm"][500:].mean() == pytest.approx(drag, rel=0.02), key


def test_brake_behind_a_spring_cannot_be_stiffer_than_the_spring() -> None:
    log = _visit("series_elastic_brake", 100.0)
    way_in = (log["time_s"] < 1.0) & (log["angle_rad"] > wall.WALL_ANGLE_RAD + 0.02)
    slope = np.polyfit(log["angle_rad"][way_in], -log["rendered_torque_nm"][way_in], 1)[0]
    assert slope == pytest.approx(1.0, rel=0.02)  # the soft spring's stiffness


@pytest.mark.parametrize(
    ("actuator", "most"),
    [
        ("motor_only", MOTOR_NM),
        ("brake_only", BRAKE_NM + DRAG_NM),
        ("series_elastic_brake", BRAKE_NM + DRAG_NM),
        ("differential_clutch", BRAKE_NM + DRAG_NM),
        ("soft_sensor_paper", MOTOR_NM + BRAKE_NM + DRAG_NM),
        ("soft_spring", MOTOR_NM + BRAKE_NM + DRAG_NM),
    ],
)
def test_peak_torque_is_what_motor_and_brake_give_together(actuator: str, most: float) -> None:
    peak = trials.measure_peak(trials.press_hard(actuator))
    assert 0.95 * most <= peak <= most * (1 + 1e-3)


# --- what each arrangement is known for ----------------------------------------------------------


@pytest.mark.parametrize("actuator", ["brake_only", "parallel"])
def test_brake_without_sensor_keeps_the_knob_in_the_wall(actuator: str) -> None:
    left = trials.measure_exit(actuator)
    assert left.outcome == "stays"
    assert left.exit_s is None
    assert left.stuck_torque_nm > 40e-3


@pytest.mark.parametrize(
    "actuator",
    [
        "motor_only",
        "soft_spring",
        "soft_sensor_paper",
        "soft_sensor_compensated",
        "soft_sensor_calibrated",
        "one_way_brakes",
        "transfer_function",
    ],
)
def test_actuators_against_stiction_leave_the_wall(actuator: str) -> None:
    log = trials.cut_string(actuator)
    left = trials.measure_exit(actuator, log)
    assert left.outcome == "leaves"
    assert left.exit_s is not None
    assert 0.0 < left.exit_s < 0.1
    # Nowhere inside from then on, but just before.
    first = round(1e3 * (trials.CUT_S + left.exit_s))
    assert (log["angle_rad"][first:] <= 0.0).all()
    assert log["angle_rad"][first - 1] > 0.0


def test_torque_sensor_lets_go_until_friction_holds_the_knob() -> None:
    # Bearings of 6 mN m and a drag of 2 mN m; it rests 3.7 mrad inside.
    log = trials.cut_string("parallel_torque_sensor")
    left = trials.measure_exit("parallel_torque_sensor", log)
    assert left.outcome == "held by friction"
    assert left.exit_s is None
    wall = math.degrees(trials.CUT_WALL_MNM_PER_DEG / 1e3)
    assert left.stuck_torque_nm == pytest.approx(wall * log["angle_rad"][-1])
    assert 1e-3 < left.stuck_torque_nm <= 6e-3 + DRAG_NM
    assert np.abs(log["speed_rad_s"][-100:]).max() == 0.0


def test_passive_actuators_come_to_rest_in_any_spring() -> None:
    for key in ("brake_only", "series_elastic_brake"):
        for stiffness in (1.0, 20.0, 200.0):
            assert trials.comes_to_rest(trials.spin_into_spring(key, stiffness))


def test_soft_sensor_stays_stable_far_beyond_the_motor_alone() -> None:
    for key in ("soft_sensor_paper", "soft_sensor_compensated"):
        assert trials.comes_to_rest(trials.spin_into_spring(key, 8.0))
        assert not trials.comes_to_rest(trials.spin_into_spring(key, 15.0))
    assert not trials.comes_to_rest(trials.spin_into_spring("motor_only", 2.0))


def test_law_calibrated_never_buzzes_and_tracks_as_the_one_with_two_encoders() -> None:
    for stiffness in (1.0, 20.0, 200.0):
        for speed in trials.SPINS_RAD_S:
            log = trials.spin_into_spring("soft_sensor_calibrated", stiffness, speed)
            assert trials.comes_to_rest(log)
    # With finer counts at a higher rate, where the rival with two encoders still buzzes.
    stiffness = 30.0 / NM_PER_RAD
    log = trials.visit_wall("soft_sensor_calibrated", stiffness, **trials.FINE)
    fine, rival = trials.measure_wall(log, stiffness), _wall("soft_spring")
    assert fine.tracking_in < rival.tracking_in
    assert fine.tracking_out < rival.tracking_out
    assert fine.torque_gap_nm < rival.torque_gap_nm
    assert not trials.comes_to_rest(trials.spin_into_spring("soft_spring", 200.0, **trials.FINE))
    log = trials.spin_into_spring("soft_sensor_calibrated", 200.0, **trials.FINE)
    assert trials.comes_to_rest(log)


def test_what_two_encoders_are_ahead_by_is_half_a_count() -> None:
    stiffness = 30.0 / NM_PER_RAD
    counts = trials.FINE["counts_per_rev"]

    def off_counts(actuator: str, **parts: float) -> float:
        """The mean gap on the way in, in counts of the wall."""
        log = trials.visit_wall(actuator, stiffness, parts=parts, **trials.FINE)
        way_in = (log["ideal_torque_nm"] < 0) & (log["time_s"] <= wall.PUSH_S)
        missing = (log["rendered_torque_nm"] - log["ideal_torque_nm"])[way_in]
        return float(missing.mean()) / (stiffness * 2 * math.pi / counts)

    # A count is the angle rounded down. The torque of a spring that never slips needs no encoder.
    soft = _studies.actuator_parts()["soft_spring_nm_per_rad"]
    assert off_counts("motor_only") == pytest.approx(0.5, abs=0.05)
    # Near the edge the motor cancels not all of the drag.
    assert off_counts("soft_sensor_calibrated") == pytest.approx(0.45, abs=0.05)
    assert off_counts("soft_spring") == pytest.approx(0.5 * (1 - soft / stiffness), abs=0.03)
    assert off_counts("soft_sensor_calibrated", stiff_spring_nm_per_rad=soft) == pytest.approx(
        0.4, abs=0.1
    )


def test_parallel_brake_is_far_off_on_the_way_out() -> None:
    assert _wall("parallel").tracking_in < 0.05
    assert _wall("parallel").tracking_out > 0.3


# --- the simulation ------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["paper", "compensated", "calibrated"])
@pytest.mark.parametrize("stiffness_mnm_per_deg", [10.0, 30.0, 100.0])
def test_soft_sensor_equals_the_device_in_closed_loop(
    law: str, stiffness_mnm_per_deg: float
) -> None:
    log = _visit(f"soft_sensor_{law}", stiffness_mnm_per_deg)
    stiffness = stiffness_mnm_per_deg / NM_PER_RAD
    deepest = wall.WALL_ANGLE_RAD + wall.PEAK_TORQUE_NM / stiffness + wall.PEAK_TORQUE_NM + 6e-3
    options = LoopOptions(
        scene=torsio.Wall(angle_rad=wall.WALL_ANGLE_RAD, stiffness_nm_per_rad=stiffness),
        hand=torsio.ImpedanceHand(
            intended_angle_rad=[(0.0, 0.0), (1.0, deepest), (1.2, deepest), (2.2, 0.0)],
            stiffness_nm_per_rad=1.0,
            damping_nm_s_per_rad=10e-3,
            inertia_kg_m2=1e-4,
        ),
        control=dataclasses.replace(ControlConfig(), law=law, free_assist_nm=5.8e-3),  # type: ignore[arg-type]
    )
    loop = simulate_loop(options, duration_s=2.4)
    felt = loop["spring_torque_nm"] + loop["motor_torque_nm"]
    assert np.abs(log["rendered_torque_nm"] - felt).max() < 1e-6
    assert np.abs(log["angle_rad"] - loop["angle_rad"]).max() < 1e-7


def test_halved_steps_change_tracking_by_less_than_a_thousandth_of_the_peak() -> None:
    assert trials.step_error() < 1e-3


@settings(max_examples=25, derandomize=True)
@given(
    st.sampled_from(KEYS),
    st.floats(0.0, 50.0),
    st.floats(-30.0, 30.0),
    st.booleans(),
)
def test_every_actuator_stays_finite_and_within_its_torques(
    actuator: str, stiffness: float, speed: float, both_ways: bool
) -> None:
    log = trials.simulate(
        actuator,
        hand=torsio.NoHand(),
        duration_s=0.2,
        stiffness_nm_per_rad=stiffness,
        both_ways=both_ways,
        initial_speed_rad_s=speed,
    )
    for name in log.dtype.names or ():
        assert np.isfinite(log[name]).all(), name
    assert np.abs(log["motor_torque_nm"]).max() <= MOTOR_NM * (1 + 1e-9)
    assert np.abs(log["brake_torque_nm"]).max() <= (BRAKE_NM + DRAG_NM) * (1 + 1e-9)


@settings(max_examples=15, derandomize=True)
@given(st.floats(0.3, 20.0), st.floats(1.0, 30.0))
def test_brake_only_never_gives_energy(stiffness: float, speed: float) -> None:
    log = trials.simulate(
        "brake_only",
        hand=torsio.NoHand(),
        duration_s=0.2,
        stiffness_nm_per_rad=stiffness,
        both_ways=True,
        initial_speed_rad_s=speed,
    )
    assert (np.diff(np.abs(log["speed_rad_s"])) <= 1e-12).all()


# --- measures ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("asked", "exit_s", "stuck", "outcome"),
    [
        ([3, 3, 2, 1, 0, 0, 0], 0.3, 0.0, "leaves"),
        ([3, 3, 0, 1, 2, 0, 0], 0.4, 0.0, "leaves"),  # out, in again, and out for good
        ([0, 0, 0, 0, 0, 0, 0], 0.0, 0.0, "leaves"),  # it was never inside
        ([3, 3, 2, 1, 0, 0, 1], None, 1.0, "held by friction"),
        ([5, 5, 5, 3, 3, 3, 2.5], None, 2.5, "held by friction"),
        ([5, 5, 5, 3, 3, 3, 2.6], None, 2.6, "stays"),
        ([5, 5, 0, 0, 0, 0, 5], None, 5.0, "stays"),  # it swings
    ],
)
def test_exit_is_the_last_time_inside_and_stuck_what_the_wall_asks_at_the_end(
    asked: list[float], exit_s: float | None, stuck: float, outcome: exits.Outcome
) -> None:
    time = np.linspace(0.0, 0.6, 7)  # let go at 0.1
    options = {"let_go_s": 0.1, "friction_nm": 2.0, "count_nm": 0.5}
    found = exits.measure_exit(time, np.array(asked, dtype=np.float64), **options)
    assert found.exit_s == (None if exit_s is None else pytest.approx(exit_s))
    assert found.stuck_torque_nm == stuck
    assert found.outcome == outcome


def test_study_writes_the_documented_keys_and_readable_pictures(tmp_path: Path) -> None:
    execute("actuators", json_file=tmp_path / "a.json", out=tmp_path, quick=True)
    results = json.loads((tmp_path / "a.json").read_text())
    assert [row["actuator"] for row in results["rows"]] == KEYS
    fields = {field.name for field in dataclasses.fields(trials.Measures)}
    assert all(set(row) == fields | {"jnds"} for row in results["rows"])
    for row in results["rows"]:
        wall = row["walls"][1]
        gap = wall["torque_gap_nm"] / (0.127 * 60e-3)
        assert row["jnds"]["torque_gap"] == pytest.approx(gap)
        assert row["jnds"]["tracking_out"] == pytest.approx(
            wall["tracking_out"] * wall["peak_nm"] / (0.127 * 60e-3)
        )
    outcomes = {row["actuator"]: row["outcome"] for row in results["rows"]}
    assert outcomes["parallel_torque_sensor"] == "held by friction"
    assert Counter(outcomes.values()) == {"leaves": 9, "stays": 3, "held by friction": 1}
    page = (Path(__file__).parents[2] / "docs" / "results" / "actuators.md").read_text()
    assert [key for key in results["parts"] if f"`{key}`" not in page] == []
    assert len(results["figures"]) == 3
    for name in results["figures"]:
        assert 20_000 < (tmp_path / name).stat().st_size < 200_000
