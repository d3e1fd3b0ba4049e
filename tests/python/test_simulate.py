"""The closed loop without the protocol: against a second implementation, and its own promises."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import torsio
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
