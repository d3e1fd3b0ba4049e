"""The knob for a user: scenes, states, telemetry, configuration, waiting."""

from __future__ import annotations

import pickle
import threading
import time
from collections.abc import Iterator
from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest

import torsio
from torsio import ControlConfig, Knob, TorqueHand, Wall
from torsio.telemetry import TELEMETRY_DTYPE, TRUTH_DTYPE

WALL = Wall(angle_rad=0.02, stiffness_nm_per_rad=1.4)


@pytest.fixture
def knob() -> Iterator[Knob]:
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(seed=1, log_truth=True)) as opened:
        yield opened


def test_update_changes_fields_and_keeps_the_rest(knob: Knob) -> None:
    knob.update(motor_torque_cap_nm=0.04, speed_limit_rad_s=50.0)
    knob.update(law="compensated")
    expected = ControlConfig(law="compensated", motor_torque_cap_nm=0.04, speed_limit_rad_s=50.0)
    assert knob.control_config() == expected
    knob.update(counts_per_rev=4096)
    assert knob.actuator_config() == torsio.ActuatorConfig(counts_per_rev=4096)
    assert knob.info.counts_per_rev == 4096
    knob.update(supply_v=24)
    assert knob.board_config() == torsio.BoardConfig(supply_v=24.0)
    knob.update(gain=0.5)
    assert knob.game_config() == torsio.GameConfig(gain=0.5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({}, "needs a field"),
        (
            {"lav": "paper"},
            r"no configuration has a field 'lav'; there are .*law \(ControlConfig\)",
        ),
        ({"gear": 1}, "`torsio config get` shows all"),
        ({"law": "paper", "gain": 1.0}, "law of ControlConfig and gain of GameConfig"),
    ],
)
def test_update_of_what_is_no_field_of_one_configuration_is_refused(
    knob: Knob, changes: dict[str, object], message: str
) -> None:
    with pytest.raises(TypeError, match=message):
        knob.update(**changes)


def test_no_two_configurations_have_a_field_of_the_same_name() -> None:
    configs = (
        torsio.ActuatorConfig,
        torsio.BoardConfig,
        torsio.ControlConfig,
        torsio.GameConfig,
    )
    names = [field.name for config in configs for field in fields(config)]
    assert len(set(names)) == len(names)


# Threads


def test_waiting_lets_other_threads_run() -> None:
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(paced=True)) as knob:
        count = 0
        done = threading.Event()

        def work() -> None:
            nonlocal count
            while not done.is_set():
                count += 1
                time.sleep(0.001)

        thread = threading.Thread(target=work)
        thread.start()
        knob.record(duration_s=0.5)
        done.set()
        thread.join()
    # Had the call kept the interpreter's lock, the count would stand still for half a second.
    assert count > 50


# Values


def test_scene_classes_compare_show_and_hash_by_value() -> None:
    one, same = (torsio.Curve(torque_nm=np.array([0.0, 0.5])) for _ in range(2))
    assert one == same
    assert hash(one) == hash(same)
    assert repr(one).startswith("Curve(torque_nm=(0.0, 0.5)")
    assert repr(WALL) == (
        "Wall(stiffness_nm_per_rad=1.4, angle_rad=0.02, side='above', damping_nm_s_per_rad=0.0)"
    )
    assert replace(WALL, angle_rad=0.5) != WALL
    with pytest.raises(FrozenInstanceError):
        WALL.angle_rad = 1.0  # type: ignore[misc]
    with pytest.raises(TypeError):
        Wall(1.0)  # type: ignore[misc]


def test_profiles_may_be_arrays_and_numbers() -> None:
    from_array = TorqueHand(torque_nm=np.array([[0.0, 0.1], [1.0, 0.2]]))
    assert from_array == TorqueHand(torque_nm=[(0.0, 0.1), (1.0, 0.2)])
    assert TorqueHand(torque_nm=0.1).torque_nm == ((0.0, 0.1),)


def test_errors_keep_their_attributes_when_pickled_and_are_of_pythons_kinds() -> None:
    error = pickle.loads(pickle.dumps(torsio.Refused("no", "stale", "wall", "slot")))
    assert (str(error), error.status, error.report, error.field) == ("no", "stale", "wall", "slot")
    assert issubclass(torsio.Timeout, TimeoutError)
    assert issubclass(torsio.Disconnected, ConnectionError)


def test_documented_dtypes_are_those_of_the_extension() -> None:
    from torsio import _torsio

    assert _torsio.TELEMETRY_DTYPE == TELEMETRY_DTYPE
    assert _torsio.TRUTH_DTYPE == TRUTH_DTYPE


def test_knob_says_who_and_how_it_is(knob: Knob) -> None:
    assert repr(knob) == "<torsio.Knob 'emulated' disarmed>"
    assert knob.info.fingerprint == torsio.protocol.fingerprint()
    assert knob.info.transport == "emulated"
    knob.close()
    assert repr(knob) == "<torsio.Knob 'emulated' closed>"


def test_telemetry_iterator_gives_what_was_asked(knob: Knob) -> None:
    chunks = list(knob.telemetry(duration_s=0.5, max_samples=64))
    assert max(len(chunk) for chunk in chunks) <= 64
    assert np.all(np.diff(np.concatenate(chunks)["tick"]) == 1)
    assert sum(len(chunk) for chunk in chunks) == 500
