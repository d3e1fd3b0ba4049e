"""The closed loop without the protocol: against a second implementation, and its own promises."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import torsio
from tests.python import reference
from torsio import protocol
from torsio.emulator import (
    LOOP_DTYPE,
    ClosedLoop,
    InitialState,
    LoopOptions,
    SpinUp,
    replay,
    reports,
    simulate,
    simulate_many,
)

COUNT_RAD = 2 * math.pi / 8192
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


def test_record_every_thins_the_rows() -> None:
    every = simulate(push(), duration_s=0.2, record_every=7)
    np.testing.assert_array_equal(every, simulate(push(), duration_s=0.2)[::7])
    assert every.dtype == LOOP_DTYPE


def _with(**parts: Any) -> LoopOptions:
    return LoopOptions(plant=torsio.PlantParams(**parts))


@pytest.mark.parametrize(
    ("options", "name"),
    [
        (LoopOptions(control_period_ns=10), "control_period_ns"),
        (LoopOptions(control=torsio.ControlConfig(beta=2.0)), "beta"),
        (LoopOptions(scene=torsio.Damper(damping_nm_s_per_rad=-1.0)), "damping"),
        (LoopOptions(actuator=torsio.ActuatorConfig(counter_bits=4)), "counter_bits"),
        (LoopOptions(step_ns=0), "step_ns"),
        (LoopOptions(plant=torsio.PlantParams(encoder_noise_counts=-1.0)), "noise_counts"),
        (_with(brake_hysteresis=torsio.BrakeHysteresis(half_width_nm=-1e-3)), "half_width_nm"),
        (_with(belt=torsio.Belt(pulley_inertia_kg_m2=1.0)), "pulley_inertia_kg_m2"),
        (_with(cogging=torsio.Cogging(periods_per_rev=0, torque_nm=(0, 0))), "periods_per_rev"),
        (_with(cogging=torsio.Cogging(periods_per_rev=7, torque_nm=())), "cogging.torque_nm"),
        (_with(shaft_hardening=torsio.ShaftHardening(knee_rad=0.0)), "knee_rad"),
        (_with(belt=torsio.Belt(), spring_and_brake=False), "need spring_and_brake"),
        (LoopOptions(initial=InitialState(brake_magnetic_nm=-1.0)), "brake_magnetic_nm"),
        (LoopOptions(spin_up=SpinUp(motor_command_nm=0.0, speed_rad_s=1.0)), "motor_command_nm"),
        (LoopOptions(spin_up=SpinUp(motor_command_nm=0.1, speed_rad_s=-1.0)), "speed_rad_s"),
    ],
)
def test_options_out_of_range_are_refused_by_name(options: LoopOptions, name: str) -> None:
    with pytest.raises(ValueError, match=name):
        simulate(options, duration_s=0.01)


def test_a_spin_up_that_cannot_be_done_is_an_error() -> None:
    options = LoopOptions(spin_up=SpinUp(motor_command_nm=1e-3, speed_rad_s=18.0, longest_s=0.1))
    with pytest.raises(RuntimeError, match="18"):
        simulate(options, duration_s=0.01)


def test_held_commands_act_until_they_are_released() -> None:
    loop = ClosedLoop(LoopOptions(scene=torsio.Constant(torque_nm=0.02)))
    loop.hold_command(brake_command_nm=0.1)
    held = loop.run(duration_s=0.5)
    assert held["desired_torque_nm"].max() == 0.0
    assert held["brake_capacity_nm"][-1] == pytest.approx(0.102, rel=1e-3)
    loop.release_command()
    assert loop.run(duration_s=0.01)["desired_torque_nm"][0] == pytest.approx(0.02)


def test_replay_decides_what_the_loop_decided() -> None:
    rows = simulate(push(), duration_s=0.8)
    replayed = replay(push(), rows["position_counts"])
    np.testing.assert_array_equal(
        replayed["motor_command_nm"].astype(np.float32), rows["motor_command_nm"]
    )


def test_reports_are_what_a_device_is_sent() -> None:
    scene = [torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=1.5), torsio.Curve(torque_nm=(0, 1))]
    found = [protocol.decode(data) for data in reports(replace(push(), scene=scene))]
    assert [name for name, _ in found] == [
        *("actuator_config", "control_config", "shaft_config", "wall", "curve", "curve_points")
    ]
    assert found[3][1]["stiffness_nm_per_rad"] == 1.5
