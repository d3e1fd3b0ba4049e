"""The whole emulated knob against the second implementation of law and plant, in closed loop.

The second implementation has 64-bit floats, SciPy's integrator and located friction events. Closed
loops with friction and counts are sensitive: a count that flips one tick earlier shifts what
follows. The bounds say how far apart two right answers may be.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import torsio
from tests.python import reference
from torsio import closed_loop

WALL_RAD = 0.05
COUNT_RAD = 2 * math.pi / 8192


def device_record(
    hand: torsio.Hand,
    *,
    stiffness: float,
    beta: float,
    duration: float,
    plant: torsio.PlantParams | None = None,
) -> tuple[dict[str, np.ndarray[Any, Any]], np.ndarray[Any, Any]]:
    """Give telemetry as the reference names it, and the truth, both from the hand's beginning."""
    with torsio.open(
        "emulated",
        emulator=torsio.EmulatorOptions(
            control=torsio.ControlConfig(law="paper", beta=beta),
            plant=plant or torsio.PlantParams(),
            log_truth=True,
        ),
    ) as knob:
        knob.play(torsio.Wall(angle_rad=WALL_RAD, stiffness_nm_per_rad=stiffness))
        knob.arm()
        knob.sleep(0.1)
        knob.start_telemetry()
        knob.emulator.truth()
        knob.emulator.set_hand(hand)
        log = knob.record(duration_s=duration)
        truth = knob.emulator.truth()
    # Where the hand took over is where the truth begins.
    first = round(truth["time_s"][0] * 1e3)
    log = log[log["tick"] >= first]
    rows = truth[: len(log)]
    assert round(rows["time_s"][-1] * 1e3) == log["tick"][-1]
    return {
        "count": log["position_counts"],
        "desired": log["desired_torque_nm"],
        "motor": log["motor_command_nm"],
        "sensed": log["spring_torque_nm"],
        "angle": rows["angle_rad"],
        "spring": rows["spring_torque_nm"],
    }, truth


@pytest.mark.filterwarnings("ignore::torsio.StiffnessWarning")
@pytest.mark.parametrize("wall_mnm_per_deg", [10.0, 25.0, 50.0])
@pytest.mark.parametrize("beta", [0.3, 0.5])
def test_visit_to_a_wall_matches_the_second_implementation(
    wall_mnm_per_deg: float, beta: float
) -> None:
    stiffness = math.degrees(1e-3 * wall_mnm_per_deg)
    deepest = WALL_RAD + 0.05 / stiffness + 0.06
    path = [(0.0, 0.0), (0.5, deepest), (0.6, deepest), (1.1, 0.0)]
    got, _ = device_record(
        torsio.ImpedanceHand(
            intended_angle_rad=path,
            stiffness_nm_per_rad=1.0,
            damping_nm_s_per_rad=0.01,
            inertia_kg_m2=1e-4,
        ),
        stiffness=stiffness,
        beta=beta,
        duration=1.2,
    )
    expected = reference.run_wall(
        reference.Actuator(),
        reference.Hand(inertia=1e-4, stiffness=1.0, damping=0.01, path=reference.piecewise(path)),
        surface=WALL_RAD,
        stiffness=stiffness,
        beta=beta,
        duration=1.2,
    )
    size = min(len(got["count"]), len(expected["count"]))
    assert size > 1150

    def error(name: str) -> np.ndarray[Any, Any]:
        return np.abs(got[name][:size] - expected[name][:size])

    assert error("count").max() <= 2
    assert error("angle").max() <= 1.5 * COUNT_RAD
    for name in ("desired", "motor", "sensed", "spring"):
        # One count of the spring is 2.2 mN m, and it may be counted a tick earlier or later.
        assert error(name).max() <= 7e-3, name
        assert np.sqrt(np.mean(error(name) ** 2)) <= 0.5e-3, name


def test_string_cut_frees_the_knob_as_in_the_second_implementation() -> None:
    """A weight of 50 mN m on a string presses the knob into the wall; the string is cut."""
    stiffness = math.degrees(25e-3)
    jump = [(0.0, 0.0), (0.5, 0.05), (0.8, 0.05), (0.8, 0.0)]
    got, _ = device_record(
        torsio.TorqueHand(torque_nm=jump), stiffness=stiffness, beta=0.5, duration=1.5
    )
    expected = reference.run_wall(
        reference.Actuator(),
        reference.Hand(torque=lambda t: 0.1 * t if t < 0.5 else 0.05 if t < 0.8 - 1e-9 else 0.0),
        surface=WALL_RAD,
        stiffness=stiffness,
        beta=0.5,
        duration=1.5,
    )
    # Where it rests at the end: out of the wall, or where friction holds it.
    friction = 6e-3 + 2e-3
    for angle in (got["angle"][-1], expected["angle"][-1]):
        assert stiffness * (angle - WALL_RAD) <= friction + stiffness * COUNT_RAD
    before = 790
    assert got["angle"][before] == pytest.approx(expected["angle"][before], abs=2 * COUNT_RAD)


def test_knob_that_a_hand_moves_does_not_stick() -> None:
    hand = torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (0.1, 1.0)])
    rows = closed_loop.simulate(closed_loop.LoopOptions(hand=hand), duration_s=0.1)
    assert not rows["knob_sticks"].any()


def test_brake_begins_with_the_torque_that_it_is_given() -> None:
    plant = torsio.PlantParams(brake_hysteresis=torsio.BrakeHysteresis(half_width_nm=4e-3))
    initial = closed_loop.InitialState(brake_magnetic_nm=10e-3)
    rows = closed_loop.simulate(
        closed_loop.LoopOptions(plant=plant, initial=initial), duration_s=1e-3
    )
    assert rows["brake_capacity_nm"][0] == pytest.approx(10e-3 + plant.brake_drag_nm)


def test_stepper_of_another_kind_is_refused() -> None:
    with pytest.raises(TypeError, match="stepper must be a capsule"):
        closed_loop.simulate(closed_loop.LoopOptions(stepper=3), duration_s=1e-3)


def test_run_begins_in_the_turn_that_it_is_given() -> None:
    initial = closed_loop.InitialState(revolutions=3, angle_rad=0.5)
    rows = closed_loop.simulate(closed_loop.LoopOptions(initial=initial), duration_s=1e-3)
    assert rows["angle_rad"][0] == pytest.approx(6.0 * math.pi + 0.5)


def apart_rad(
    options: closed_loop.LoopOptions, change: Callable[[torsio.Knob | closed_loop.ClosedLoop], None]
) -> list[float]:
    """Change a loop and the emulated device in mid-run; give how far apart they come.

    A report waits for its frame, so the loop is changed in each of eight.
    """
    assert options.scene is not None
    emulator = torsio.EmulatorOptions(control=options.control, hand=options.hand, log_truth=True)
    with torsio.open("emulated", emulator=emulator) as knob:
        knob.play(options.scene)
        knob.arm()
        knob.sleep(0.5)
        told_s = knob.emulator.truth()["time_s"][-1]
        change(knob)
        knob.sleep(0.2)
        moved = knob.emulator.truth()
    apart = []
    for late_s in np.arange(8) * 1e-3:
        loop = closed_loop.ClosedLoop(options)
        loop.run(duration_s=told_s + late_s)
        change(loop)
        rows = loop.run(duration_s=0.15)
        same = np.searchsorted(moved["time_s"], rows["time_s"] - 1e-9)
        apart.append(float(np.abs(rows["angle_rad"] - moved["angle_rad"][same]).max()))
    return apart


@pytest.mark.parametrize("law", ["paper", "calibrated"])
def test_scene_changes_as_on_the_emulated_device(law: Any) -> None:
    """Its unchanged friction goes on: one that began anew would let go of what it holds."""
    friction = torsio.Friction(torque_nm=10e-3, stiffness_nm_per_rad=0.2)
    scene, other = (
        [torsio.Wall(angle_rad=at, stiffness_nm_per_rad=2.0), friction] for at in (0.05, 0.04)
    )
    refused = torsio.Spring(stiffness_nm_per_rad=-1.0)

    def change(one: torsio.Knob | closed_loop.ClosedLoop) -> None:
        play = one.play if isinstance(one, torsio.Knob) else one.set_scene
        with pytest.raises(torsio.InvalidArgument, match="stiffness_nm_per_rad"):
            play(refused)
        play(other)

    apart = apart_rad(
        closed_loop.LoopOptions(
            scene=scene,
            hand=torsio.TorqueHand(torque_nm=[(0.2, 0.0), (0.3, 40e-3)]),
            control=torsio.ControlConfig(law=law),
        ),
        change,
    )
    assert min(apart) == 0.0
    assert max(apart) > 1e-3


@pytest.mark.parametrize("law", ["paper", "calibrated"])
def test_stream_acts_as_on_the_emulated_device(law: Any) -> None:
    """It keeps its spring to a place while the scene plays."""

    def change(one: torsio.Knob | closed_loop.ClosedLoop) -> None:
        with pytest.raises(torsio.InvalidArgument, match="stiffness_nm_per_rad"):
            one.stream_local_model(stiffness_nm_per_rad=-1.0)
        kept = {"deadline_s": 1.0} if isinstance(one, torsio.Knob) else {}
        one.stream_local_model(
            angle_rad=0.1, stiffness_nm_per_rad=0.5, damping_nm_s_per_rad=1e-3, **kept
        )

    wall = torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=2.0)
    control = torsio.ControlConfig(law=law)
    apart = apart_rad(closed_loop.LoopOptions(scene=wall, control=control), change)
    assert min(apart) == 0.0
    assert max(apart) > 1e-3
