"""Sensor, brake model, partition and motion against closed forms, properties and the equations."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from tests.python import reference
from torsio import core, protocol


def floats(*shape: int, seed: int = 1, scale: float = 1.0) -> npt.NDArray[np.float32]:
    return (scale * np.random.default_rng(seed).standard_normal(shape)).astype(np.float32)


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
