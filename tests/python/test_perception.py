"""Errors in just noticeable differences, against the figures that are published."""

from __future__ import annotations

import math

import numpy as np
import pytest

from torsio import perception
from torsio.calibration import report
from torsio.errors import InvalidArgument


@pytest.mark.parametrize(("counts", "stiffness"), [(8192, 10), (32_768, 40), (131_072, 159)])
def test_stiffest_wall_whose_counts_are_no_more_than_a_jnd(counts: int, stiffness: int) -> None:
    """12.7 % of 60 mN m, by k 2 pi / counts: 10, 40 and 159 N m/rad."""
    assert round(perception.smooth_stiffness_nm_per_rad(counts)) == stiffness
    assert perception.torque_jnds(stiffness * 2 * math.pi / counts) == pytest.approx(1.0, rel=0.01)


@pytest.mark.parametrize(("stiffness", "least"), [(10, 8192), (40, 32_768), (159, 131_072)])
def test_counts_for_a_wall_are_the_least_that_keep_a_step_below_a_jnd(
    stiffness: float, least: int
) -> None:
    counts = perception.counts_for(stiffness)
    assert counts == pytest.approx(least, rel=0.01)
    step, too_large = (stiffness * 360 / n * math.pi / 180 for n in (counts, counts - 1))
    assert step <= 0.127 * 0.060 < too_large
    assert perception.counts_for(stiffness, jnds=0.5) in (2 * counts - 1, 2 * counts)


def test_errors_of_torque_and_stiffness_are_counted_in_their_jnds() -> None:
    # 60 and 67.62 mN m are told apart, 2 and 2.46 N m/rad too.
    assert perception.torque_jnds(60e-3 - 67.62e-3) == pytest.approx(1.0)
    assert perception.stiffness_jnds(2.46 / 2.0 - 1.0) == pytest.approx(1.0)
    assert perception.jnds_of("coulomb_nm", 9e-3, 3.81e-3) == pytest.approx(0.5)
    assert perception.jnds_of("stiffness_nm_per_rad", 2.0, -0.46) == pytest.approx(1.0)
    assert perception.jnds_of("spring_stiffness_nm_per_rad", 2.0, 0.23) == pytest.approx(0.5)
    assert perception.jnds_of("brake_gain", 0.9, 0.127) == pytest.approx(1.0)


@pytest.mark.parametrize("name", ["inertia_kg_m2", "rise_s", "viscous_nm_s_per_rad", "knee_rad"])
def test_what_nobody_has_measured_has_no_jnd(name: str) -> None:
    assert perception.jnds_of(name, 1.0, 0.5) is None
    assert report.change(name, 1.0, 1.5) == f"{name}: 1 -> 1.5"
    assert perception.jnds_of("stiffness_nm_per_rad", 0.0, 0.1) is None


def test_visit_to_a_wall_in_jnds() -> None:
    found = perception.wall_jnds(
        peak_nm=75e-3, tracking_in=0.0254, tracking_out=0.1016, torque_gap_nm=15.24e-3
    )
    assert found == pytest.approx({"tracking_in": 0.25, "tracking_out": 1.0, "torque_gap": 2.0})


def test_change_of_a_calibrated_value_says_what_a_finger_makes_of_it() -> None:
    assert report.change("coulomb_nm", 6e-3, 13.62e-3) == "coulomb_nm: 0.006 -> 0.01362 (1 JND)"
    assert report.change("rise_s", 0.06, 0.0600018) == "rise_s: 0.06 -> 0.060002"
    assert report.change("law", "paper", "calibrated") == "law: paper -> calibrated"
    assert report.felt("offset_nm", 0.0, 1e-6) == "< 0.01 JND"


def test_value_far_from_the_configured_one_comes_with_what_to_look_for() -> None:
    assert "; look for a loose belt" in report.cause("spring_stiffness_nm_per_rad", 2.873, 2.15)
    assert report.cause("spring_stiffness_nm_per_rad", 2.873, 2.4) == ""
    assert (
        report.cause("brake_drag_nm", 2e-3, 8e-3)
        == "; look for a brake that stands askew, a tight belt"
    )
    assert report.cause("brake_hysteresis_nm", 0.0, 5e-3) == ""  # most begin without one
    assert report.cause("law", "paper", "calibrated") == ""


@pytest.mark.parametrize(("stiffness", "jnds"), [(-1.0, 1.0), (math.nan, 1.0), (10.0, 0.0)])
def test_walls_and_steps_that_cannot_be_are_refused(stiffness: float, jnds: float) -> None:
    with pytest.raises(InvalidArgument, match=r"stiffness_nm_per_rad|jnds"):
        perception.counts_for(stiffness, jnds=jnds)


def test_vibration_is_what_changes_faster_than_20_hertz() -> None:
    time_s = np.arange(1100) / 1000.0
    buzz = 3e-3 * np.sin(2.0 * np.pi * 100.0 * time_s)
    # Samples beyond whole 0.05 s are left out, and so is a push that grows slowly.
    assert perception.vibration_nm(buzz, 1000.0) == pytest.approx(3e-3 / math.sqrt(2.0))
    slow = 50e-3 * np.sin(2.0 * np.pi * 0.1 * time_s)
    assert perception.vibration_nm(slow, 1000.0) < 0.5e-3
    both = np.column_stack([buzz, np.full(len(time_s), 80e-3)])
    assert perception.vibration_nm(both, 1000.0) == pytest.approx([3e-3 / math.sqrt(2.0), 0.0])
