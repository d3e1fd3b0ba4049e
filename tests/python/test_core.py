"""Sensor, brake model, partition and motion against closed forms, properties and the equations."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.python import reference
from torsio import core, protocol

TORQUE = st.floats(-1.0, 1.0, width=32)
LAWS = ("paper", "compensated", "parallel", "motor_only")


def floats(*shape: int, seed: int = 1, scale: float = 1.0) -> npt.NDArray[np.float32]:
    return (scale * np.random.default_rng(seed).standard_normal(shape)).astype(np.float32)


# Soft sensor


def test_sensor_winds_up_against_the_motion_when_the_brake_holds() -> None:
    state = core.SoftSensorState()
    torque = core.sense_spring(state, 0.01, 1.0, stiffness_nm_per_rad=2.873)
    assert torque == pytest.approx(-0.02873, rel=1e-6)


def test_sensor_slips_at_the_capacity_when_the_knob_goes_on() -> None:
    state = core.SoftSensorState()
    for _ in range(100):
        torque = core.sense_spring(state, 0.01, 0.02)
    assert torque == pytest.approx(-0.02)


@given(st.lists(st.tuples(TORQUE, st.floats(0.0, 1.0, width=32)), min_size=1, max_size=50))
def test_sensor_never_exceeds_what_the_brake_holds(steps: list[tuple[float, float]]) -> None:
    state = core.SoftSensorState()
    for delta, capacity in steps:
        assert abs(core.sense_spring(state, delta, capacity)) <= capacity


@given(st.lists(TORQUE, min_size=1, max_size=50))
def test_sensor_is_odd_in_the_motion(deltas: list[float]) -> None:
    one, other = core.SoftSensorState(), core.SoftSensorState()
    for delta in deltas:
        assert core.sense_spring(one, delta, 0.5) == -core.sense_spring(other, -delta, 0.5)


# Brake model


@given(st.floats(1e-4, 1.0), st.floats(1e-5, 1e-2), st.integers(1, 200))
def test_brake_model_follows_the_exponential_of_its_lag(
    time_constant: float, period: float, ticks: int
) -> None:
    params = core.BrakeParams(time_constant_s=time_constant, period_s=period, floor_nm=0.0)
    state = core.BrakeState()
    for _ in range(ticks):
        torque = core.model_brake(state, params, 0.1)
    exact = 0.1 * -math.expm1(-ticks * period / time_constant)
    # The share left over from tick to tick is close to 1, where 32 bits resolve 6e-8 of it.
    resolution = 6e-8 * time_constant / period
    assert torque == pytest.approx(exact, rel=1e-5 + 2 * resolution, abs=1e-9)


def test_brake_model_never_goes_below_its_floor() -> None:
    params = core.BrakeParams(floor_nm=3.3e-3)
    assert core.model_brake(core.BrakeState(), params, 0.0) == pytest.approx(3.3e-3)


# Partition


@given(TORQUE, TORQUE, st.floats(0.0, 1.0), st.sampled_from(LAWS))
def test_partition_stays_within_the_actuators(
    desired: float, spring: float, beta: float, law: str
) -> None:
    params = core.PartitionParams(
        law=law,
        beta=beta,
        motor_torque_max_nm=0.085,
        brake_torque_max_nm=0.11,
    )
    shares = core.partition(params, desired, spring)
    assert abs(shares.motor_command_nm) <= np.float32(0.085)
    assert 0.0 <= shares.brake_command_nm <= np.float32(0.11)


@given(TORQUE, TORQUE, st.sampled_from(LAWS))
def test_partition_is_the_same_law_in_both_directions(
    desired: float, spring: float, law: str
) -> None:
    params = core.PartitionParams(law=law)
    one, other = core.partition(params, desired, spring), core.partition(params, -desired, -spring)
    assert one.motor_command_nm == -other.motor_command_nm
    assert one.brake_command_nm == other.brake_command_nm


@given(TORQUE, st.sampled_from(LAWS))
def test_partition_is_silent_in_free_space(spring: float, law: str) -> None:
    shares = core.partition(core.PartitionParams(law=law), 0.0, spring)
    assert (shares.motor_command_nm, shares.brake_command_nm) == (0.0, 0.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_partition_releases_brake_when_user_pushes_with_the_wall(sign: float) -> None:
    shares = core.partition(core.PartitionParams(), -0.04 * sign, 0.01 * sign)
    assert shares.brake_command_nm == 0.0
    assert shares.motor_command_nm == pytest.approx(-0.04 * sign)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_partition_shares_the_torque_when_the_spring_helps(sign: float) -> None:
    shares = core.partition(core.PartitionParams(beta=0.5), -0.06 * sign, -0.02 * sign)
    assert shares.motor_command_nm == pytest.approx(-0.04 * sign)
    assert shares.brake_command_nm == pytest.approx(0.03)


def test_partition_and_sensor_follow_the_papers_equations_over_a_record() -> None:
    """The law of the paper, tick by tick, against the second implementation."""
    actuator = reference.Actuator()
    law = reference.PaperLaw(actuator, beta=0.5, period=1e-3)
    sensor, brake = core.SoftSensorState(), core.BrakeState()
    brake_params, params = core.BrakeParams(), core.PartitionParams()
    command = 0.0
    deltas = floats(2000, seed=3, scale=4e-3)
    desired = np.cumsum(floats(2000, seed=4, scale=8e-3))
    for delta, wanted in zip(deltas.tolist(), desired.tolist(), strict=True):
        capacity = core.model_brake(brake, brake_params, command)
        spring = core.sense_spring(sensor, delta, capacity)
        shares = core.partition(params, wanted, spring)
        command = shares.brake_command_nm
        motor, brake_command = law.step(delta, wanted)
        assert spring == pytest.approx(law.spring, abs=2e-6)
        # At the very switch rounding may decide; nothing but the sign of a vanishing torque.
        if abs(law.spring) > 1e-5:
            assert shares.motor_command_nm == pytest.approx(motor, abs=2e-6)
            assert command == pytest.approx(brake_command, abs=2e-6)
        else:
            law.brake_command = command


def test_unknown_law_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="'wishful'"):
        core.PartitionParams(law="wishful")


# Motion


@given(
    st.lists(st.integers(-20000, 20000), min_size=1, max_size=60),
    st.sampled_from([16, 24, 32]),
    st.integers(0, 2**32 - 1),
)
def test_motion_counts_exactly_through_every_wrap(steps: list[int], bits: int, start: int) -> None:
    params = core.MotionParams(counter_bits=bits)
    state = core.MotionState()
    core.track_motion(state, params, start % 2**bits)
    position = 0
    for step in steps:
        position += step
        motion = core.track_motion(state, params, (start + position) % 2**bits)
        assert motion.delta_counts == step
    assert motion.position_counts == position


def test_motion_speed_settles_at_the_true_speed() -> None:
    counts = (np.arange(2000) * 16).astype(np.uint32)  # 16 counts a tick at 1 kHz
    rows = core.track_motion(core.MotionState(), core.MotionParams(), counts)
    assert rows["speed_rad_s"][-1] == pytest.approx(16e3 * 2 * math.pi / 8192, rel=1e-4)
    assert rows["acceleration_rad_s2"][-1] == pytest.approx(0.0, abs=1e-2)


# Records


def test_records_give_the_same_numbers_as_single_ticks() -> None:
    deltas, capacities = floats(500, scale=0.01), np.abs(floats(500, seed=2, scale=0.05))
    state = core.SoftSensorState()
    single = [
        core.sense_spring(state, d, c)
        for d, c in zip(deltas.tolist(), capacities.tolist(), strict=True)
    ]
    record = core.sense_spring(core.SoftSensorState(), deltas, capacities)
    assert record.dtype == np.float32
    assert record.tolist() == single

    brake = core.BrakeState()
    commands = capacities.tolist()
    assert core.model_brake(core.BrakeState(), core.BrakeParams(), capacities).tolist() == [
        core.model_brake(brake, core.BrakeParams(), c) for c in commands
    ]

    params = core.PartitionParams()
    rows = core.partition(params, deltas, record)
    shares = [core.partition(params, d, s) for d, s in zip(deltas.tolist(), single, strict=True)]
    assert rows["motor_command_nm"].tolist() == [s.motor_command_nm for s in shares]
    assert rows["brake_command_nm"].tolist() == [s.brake_command_nm for s in shares]

    counts = np.cumsum(np.arange(500) % 7).astype(np.uint32)
    motion = core.MotionState()
    rows = core.track_motion(core.MotionState(), core.MotionParams(), counts)
    for row, count in zip(rows, counts.tolist(), strict=True):
        one = core.track_motion(motion, core.MotionParams(), count)
        assert one.position_counts == row["position_counts"]
        assert one.speed_rad_s == row["speed_rad_s"]


def test_records_of_different_length_are_refused() -> None:
    with pytest.raises(ValueError, match="3 and 4 ticks"):
        core.sense_spring(core.SoftSensorState(), np.zeros(3), np.zeros(4))


# Scene


def scene_of(**effects: dict[str, Any]) -> core.Scene:
    return core.Scene(
        [
            protocol.encode(name, {"target": {"slot": slot}, **values})
            for slot, (name, values) in enumerate(effects.items())
        ]
    )


def test_scene_over_a_record_is_the_sum_of_its_effects_equations() -> None:
    quarter_turn = 2**30  # in 2^-32 turns
    scene = scene_of(
        wall={"angle_turns_q32": quarter_turn, "stiffness_nm_per_rad": 0.5},
        spring={"stiffness_nm_per_rad": 0.01},
        detents={"per_turn_q32": 8 << 32, "torque_nm": 0.02},
    )
    assert scene.active == 3
    counts = np.arange(0, 4096, 5)
    angle = counts * 2 * np.pi / 8192
    expected = -0.5 * np.maximum(angle - np.pi / 2, 0) - 0.01 * angle - 0.02 * np.sin(8 * angle)
    torque = core.evaluate_scene_record(
        scene, core.SceneState(), core.MotionParams(), core.MotionState(), counts
    )
    # The first count is where the motion begins: position 0.
    np.testing.assert_allclose(torque, expected, rtol=0, atol=1e-6)


def test_scene_tick_by_tick_gives_the_same_as_its_record() -> None:
    scene = scene_of(
        damper={"damping_nm_s_per_rad": 1e-3},
        friction={"torque_nm": 0.01, "stiffness_nm_per_rad": 2.0},
        periodic={"amplitude_nm": 0.01, "frequency_hz": 40.0},
    )
    counts = np.cumsum(np.arange(300) % 11)
    record = core.evaluate_scene_record(
        scene, core.SceneState(), core.MotionParams(), core.MotionState(), counts
    )
    params, motion, state = core.MotionParams(), core.MotionState(), core.SceneState()
    for tick, count in enumerate(counts.tolist()):
        moment = core.track_motion(motion, params, count)
        assert core.evaluate_scene(scene, state, moment, tick) == record[tick]


def test_scene_refuses_what_a_device_would_refuse() -> None:
    with pytest.raises(ValueError, match="wall"):
        scene_of(wall={"stiffness_nm_per_rad": math.nan})
    with pytest.raises(ValueError, match="not the report of an effect"):
        core.Scene([protocol.encode("commit", {})])
