"""The closed loop without the protocol: against a second implementation, and its own promises."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import torsio
from tests.python import reference
from torsio import protocol
from torsio.closed_loop import (
    LoopOptions,
    reports,
    simulate,
    simulate_many,
)

STIFFNESS = math.degrees(25e-3)
PATH = [(0.0, 0.0), (0.3, 0.13), (0.4, 0.13), (0.7, 0.0)]


def push(law: str = "paper") -> LoopOptions:
    return LoopOptions(
        scene=torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=STIFFNESS),
        hand=torsio.ImpedanceHand(
            intended_angle_rad=PATH,
            stiffness_nm_per_rad=1.0,
            damping_nm_s_per_rad=0.01,
            inertia_kg_m2=1e-4,
        ),
        control=torsio.ControlConfig(law=law),  # type: ignore[arg-type]
    )


def test_simulate_matches_the_second_implementation() -> None:
    rows = simulate(push(), duration_s=0.8)
    expected = reference.run_wall(
        reference.Actuator(),
        reference.Hand(inertia=1e-4, stiffness=1.0, damping=0.01, path=reference.piecewise(PATH)),
        surface=0.05,
        stiffness=STIFFNESS,
        beta=0.5,
        duration=0.8,
    )
    assert np.abs(rows["position_counts"] - expected["count"]).max() <= 2
    for ours, theirs in (
        ("desired_torque_nm", "desired"),
        ("motor_command_nm", "motor"),
        ("sensed_spring_torque_nm", "sensed"),
        ("spring_torque_nm", "spring"),
    ):
        error = np.abs(rows[ours] - expected[theirs])
        # One count of the spring is 2.2 mN m, and it may be counted a tick earlier or later.
        assert error.max() <= 7e-3, ours
        assert np.sqrt(np.mean(error**2)) <= 0.5e-3, ours


def test_simulate_many_gives_what_simulate_gives_in_order() -> None:
    options = [
        replace(push(law), delay_ticks=delay)
        for law in ("paper", "compensated", "motor_only")
        for delay in (0, 2)
    ]
    seen: list[int] = []
    many = simulate_many(options, duration_s=0.3, threads=2, on_progress=seen.append)
    assert seen[-1] == len(options)
    for rows, one in zip(many, options, strict=True):
        np.testing.assert_array_equal(rows, simulate(one, duration_s=0.3))


def test_simulate_many_says_which_option_is_wrong() -> None:
    wrong = LoopOptions(plant=torsio.PlantParams(knob_inertia_kg_m2=-1.0))
    with pytest.raises(ValueError, match="knob_inertia_kg_m2"):
        simulate_many([push(), wrong, push()], duration_s=0.1)


def test_simulate_many_passes_on_what_progress_raises() -> None:
    def stop(_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate_many([push()] * 200, duration_s=0.8, on_progress=stop)


def test_reports_are_what_a_device_is_sent() -> None:
    scene = [torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=1.5), torsio.Curve(torque_nm=(0, 1))]
    found = [protocol.decode(data) for data in reports(replace(push(), scene=scene))]
    assert [name for name, _ in found] == [
        *("actuator_config", "control_config", "shaft_config", "wall", "curve", "curve_points")
    ]
    assert found[3][1]["stiffness_nm_per_rad"] == 1.5
