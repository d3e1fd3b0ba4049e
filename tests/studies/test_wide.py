"""The controller in 64 bits decides as the device's does, up to rounding."""

from __future__ import annotations

import numpy as np
import pytest

import torsio
from torsio.closed_loop import LoopOptions, replay, simulate
from torsio_studies import _studies, wide

OPTIONS = LoopOptions(
    scene=[
        torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=1.432),
        torsio.Curve(torque_nm=(0.0, 3e-3, -2e-3)),
    ],
    hand=torsio.ImpedanceHand(
        intended_angle_rad=[(0.0, 0.0), (0.3, 0.13), (0.4, 0.13), (0.7, 0.0)],
        stiffness_nm_per_rad=1.0,
        damping_nm_s_per_rad=0.01,
        inertia_kg_m2=1e-4,
    ),
    control=torsio.ControlConfig(law="paper"),
)


def test_64_bits_differ_by_rounding_only() -> None:
    counts = simulate(OPTIONS, duration_s=0.8)["position_counts"]
    single, double = replay(OPTIONS, counts), wide.replay(OPTIONS, counts)
    np.testing.assert_array_equal(single["position_counts"], double["position_counts"])
    for name in ("motor_command_nm", "brake_command_nm", "spring_torque_nm", "desired_torque_nm"):
        difference = np.abs(single[name] - double[name])
        assert 0 < difference.max() < 1e-7, name


def test_report_that_is_no_part_of_a_loop_is_refused() -> None:
    with pytest.raises(ValueError, match="neither a configuration nor part of a scene"):
        _studies.replay_wide(
            [bytes(64)], control_period_ns=1_000_000, first_tick=0, counts=np.zeros(3, np.uint32)
        )
