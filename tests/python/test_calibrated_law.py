"""The law `calibrated` uses the brake's inertia, hysteresis and lags.

Held against a second implementation that follows the brake's side in short steps, and against the
truth of the emulated plant, which the law does not see.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from tests.python import reference
from torsio import (
    ActuatorConfig,
    ControlConfig,
    Damper,
    EmulatorOptions,
    ImpedanceHand,
    NoHand,
    PlantParams,
    Wall,
)
from torsio import open as open_knob
from torsio.closed_loop import ClosedLoop, LoopOptions, replay, simulate
from torsio.printed.hands import Hand, PrescribedMotion, TorqueHand
from torsio.printed.plant import BrakeHysteresis
from torsio.telemetry import Record

COUNTS = 32_768
PERIOD_NS = 50_000
WALL_RAD = 0.05


def actuator_of(plant: PlantParams) -> ActuatorConfig:
    """A plant's true values; the floor is no higher than its drag."""
    return replace(plant.matching_config(), brake_torque_min_nm=plant.brake_drag_nm)


def options_of(
    *,
    stiffness: float,
    plant: PlantParams | None = None,
    actuator: ActuatorConfig | None = None,
    hand: Hand | None = None,
) -> LoopOptions:
    plant = plant or PlantParams(counts_per_rev=COUNTS)
    return LoopOptions(
        scene=Wall(angle_rad=WALL_RAD, stiffness_nm_per_rad=stiffness),
        plant=plant,
        actuator=actuator or actuator_of(plant),
        control=ControlConfig(law="calibrated"),
        control_period_ns=PERIOD_NS,
        hand=hand or NoHand(),
    )


def visitor(stiffness: float, *, way_s: float = 0.4) -> ImpedanceHand:
    """A hand that goes into the wall up to 75 mN m, and out again."""
    deepest = WALL_RAD + 75e-3 / stiffness + 0.01
    return ImpedanceHand(
        intended_angle_rad=[(0, 0), (way_s, deepest), (1.5 * way_s, deepest), (2.5 * way_s, 0)],
        stiffness_nm_per_rad=10.0,
        damping_nm_s_per_rad=0.01,
        inertia_kg_m2=1e-4,
    )


def sensor_error_nm(rows: Record) -> float:
    error = rows["sensed_spring_torque_nm"] - rows["spring_torque_nm"]
    return float(np.sqrt(np.mean(np.square(error))))


def counts_of(rows: Record) -> npt.NDArray[np.uint32]:
    return rows["position_counts"].astype(np.int64).astype(np.uint32)


@pytest.mark.parametrize(
    ("hysteresis", "release"), [(0.0, None), (11e-3, None), (5e-3, 20e-3)], ids=str
)
def test_law_agrees_with_the_second_implementation(
    hysteresis: float, release: float | None
) -> None:
    # The speed at a tick's end damps the brake's side by half a tick's worth, which at 20 kHz is a
    # third of a swing that takes 0.2 s; the second implementation damps nothing.
    period_ns, most_nm = 25_000, 0.4e-3
    stiffness = math.degrees(10e-3)
    plant = PlantParams(counts_per_rev=COUNTS)
    if hysteresis:
        plant = replace(plant, brake_hysteresis=BrakeHysteresis(half_width_nm=hysteresis))
    actuator = replace(actuator_of(plant), brake_release_time_constant_s=release or 0.0)
    options = options_of(
        stiffness=stiffness, plant=plant, actuator=actuator, hand=visitor(stiffness, way_s=0.5)
    )
    options = replace(options, control_period_ns=period_ns)
    counts = counts_of(simulate(options, duration_s=1.3))
    got = replay(options, counts)

    known = reference.Actuator(counts_per_rev=COUNTS, brake_floor=2e-3)
    law = reference.CalibratedLaw(
        known, beta=0.5, period=1e-9 * period_ns, hysteresis=hysteresis, release_lag=release
    )
    per_count = 2.0 * math.pi / COUNTS
    position = np.cumsum(np.diff(counts.astype(np.int32), prepend=counts[0].astype(np.int32)))
    spring, motor, brake = [], [], []
    for n, at in enumerate(position.tolist()):
        moved = at - position[n - 1] if n else 0
        desired = reference.wall_torque(at * per_count, surface=WALL_RAD, stiffness=stiffness)
        given = law.step(moved * per_count, desired)
        spring.append(law.spring)
        motor.append(given[0])
        brake.append(law.coil)
    assert np.max(np.abs(got["spring_torque_nm"])) > 20e-3
    difference = np.abs(got["spring_torque_nm"] - np.array(spring))
    assert np.sqrt(np.mean(np.square(difference))) < most_nm
    # The motor does not jump where the spring's sign changes, nor where a wall ends.
    given = np.abs(got["motor_command_nm"] - np.array(motor))
    assert np.sqrt(np.mean(np.square(given))) < 2.0 * most_nm


@pytest.mark.parametrize("wall_mnm_per_deg", [10.0, 30.0])
def test_sensor_that_knows_the_inertia_sees_the_spring_as_it_is(wall_mnm_per_deg: float) -> None:
    stiffness = math.degrees(1e-3 * wall_mnm_per_deg)
    hand = visitor(stiffness)
    knows = options_of(stiffness=stiffness, hand=hand)
    assert knows.actuator is not None
    actuator = replace(knows.actuator, brake_inertia_kg_m2=0.0)
    told, untold = (
        sensor_error_nm(simulate(options, duration_s=1.1))
        for options in (knows, replace(knows, actuator=actuator))
    )
    assert told < 0.4e-3
    assert untold > 6.0 * told


@pytest.mark.parametrize("wrong", [0.95, 1.03])
def test_inertia_that_is_a_little_wrong_is_better_than_none(wrong: float) -> None:
    stiffness = math.degrees(10e-3)
    right = options_of(stiffness=stiffness, hand=visitor(stiffness))
    assert right.actuator is not None
    inertia = right.actuator.brake_inertia_kg_m2
    nearly, without = (
        sensor_error_nm(
            simulate(
                replace(right, actuator=replace(right.actuator, brake_inertia_kg_m2=told)),
                duration_s=1.1,
            )
        )
        for told in (wrong * inertia, 0.0)
    )
    assert nearly < 0.8 * without


def test_sensor_knows_what_hysteresis_leaves() -> None:
    stiffness = math.degrees(30e-3)
    plant = PlantParams(
        counts_per_rev=COUNTS, brake_hysteresis=BrakeHysteresis(half_width_nm=11e-3)
    )
    knows = options_of(stiffness=stiffness, plant=plant, hand=visitor(stiffness))
    assert knows.actuator is not None
    actuator = replace(knows.actuator, brake_hysteresis_nm=0.0)
    told, untold = (
        sensor_error_nm(simulate(options, duration_s=1.1))
        for options in (knows, replace(knows, actuator=actuator))
    )
    assert untold > 5e-3
    assert told < 0.25 * untold


@pytest.mark.parametrize("wall_mnm_per_deg", [10.0, 25.0, 50.0, 100.0])
def test_knob_leaves_a_wall_and_is_not_drawn_back(wall_mnm_per_deg: float) -> None:
    stiffness = math.degrees(1e-3 * wall_mnm_per_deg)
    weight = TorqueHand(torque_nm=[(0, 0), (0.4, 50e-3), (0.8, 50e-3), (0.8, 0)])
    rows = simulate(options_of(stiffness=stiffness, hand=weight), duration_s=1.6)
    depth = rows["angle_rad"] - WALL_RAD
    after = depth[rows["time_s"] >= 0.8]
    assert after[0] > 0.2 * 50e-3 / stiffness
    left = int(np.argmax(after < 0.0))
    assert 0 < left * 1e-9 * PERIOD_NS < 0.03
    assert np.all(after[left:] < 0.0)


FRICTION_NM = PlantParams().knob_coulomb_nm + PlantParams().brake_drag_nm


def in_free_air(assist_nm: float, hand: Hand, *, counts: int = COUNTS) -> LoopOptions:
    plant = PlantParams(counts_per_rev=counts)
    options = options_of(stiffness=1.0, plant=plant, hand=hand)
    control = ControlConfig(law="calibrated", free_assist_nm=assist_nm)
    return replace(options, scene=None, control=control)


def let_go(torque_nm: float, seconds: float) -> Hand:
    if torque_nm == 0.0:
        return NoHand()
    return TorqueHand(torque_nm=[(0, torque_nm), (seconds, torque_nm), (seconds, 0)])


@pytest.mark.parametrize("push_nm", [0.02, 0.1])
def test_motor_gives_nothing_in_free_air_unless_it_is_told_to(push_nm: float) -> None:
    rows = simulate(in_free_air(0.0, let_go(push_nm, 0.05)), duration_s=1.0)
    assert np.ptp(rows["position_counts"]) > 10
    assert not np.any(rows["motor_command_nm"])
    assert not np.any(rows["brake_command_nm"])


@pytest.mark.parametrize("counts", [8192, COUNTS])
@pytest.mark.parametrize(
    ("push_nm", "seconds"),
    [(0.0, 0.0), (8.5e-3, 0.02), (9e-3, 0.05), (0.02, 0.1), (0.1, 0.1)],
    ids=["at rest", "nudged", "turned", "spun", "thrown"],
)
def test_assisted_knob_comes_to_rest_and_stays(push_nm: float, seconds: float, counts: int) -> None:
    """As much assistance as there can be: more is asked than there is friction."""
    options = in_free_air(1.0, let_go(push_nm, seconds), counts=counts)
    rows = simulate(options, duration_s=12.0)
    late = rows["time_s"] > 10.0
    assert np.ptp(rows["angle_rad"][late]) == 0.0
    assert np.max(np.abs(rows["motor_command_nm"][late])) < 1e-6
    # The friction of a turning knob, and the motor's assist.
    way_rad = np.diff(rows["angle_rad"])
    given_j = float(np.sum(rows["motor_torque_nm"][:-1] * way_rad))
    taken_j = FRICTION_NM * float(np.sum(np.abs(way_rad)))
    assert given_j <= 0.8 * taken_j
    if push_nm > 0.01:
        free = simulate(in_free_air(0.0, let_go(push_nm, seconds), counts=counts), duration_s=12.0)
        # No hand throws a knob, so help ends before its motion does.
        more = 1.05 if push_nm > 0.05 else 1.5
        assert np.ptp(rows["angle_rad"]) > more * np.ptp(free["angle_rad"])


@pytest.mark.parametrize(("counts", "bandwidth_hz"), [(8192, 400), (65536, 100), (65536, 400)])
@pytest.mark.parametrize(("coulomb_nm", "drag_nm"), [(2e-3, 4e-3), (2e-3, 10e-3), (1e-3, 6e-3)])
def test_assisted_knob_does_not_swing_where_most_friction_is_behind_the_shaft(
    coulomb_nm: float, drag_nm: float, counts: int, bandwidth_hz: float
) -> None:
    for push_nm in (0.02, 0.1):
        options = in_free_air(1.0, let_go(push_nm, 0.1), counts=counts)
        plant = replace(options.plant, knob_coulomb_nm=coulomb_nm, brake_drag_nm=drag_nm)
        options = replace(
            options,
            plant=plant,
            actuator=actuator_of(plant),
            control=replace(options.control, speed_bandwidth_hz=bandwidth_hz),
        )
        rows = simulate(options, duration_s=6.0)
        assert np.ptp(rows["angle_rad"][rows["time_s"] > 5.5]) == 0.0


@pytest.mark.parametrize("speed_rad_s", [0.2, 1.0, 5.0])
def test_assistance_leaves_less_to_be_felt(speed_rad_s: float) -> None:
    hand = ImpedanceHand(
        intended_angle_rad=[(0, 0), (2, 2 * speed_rad_s)],
        stiffness_nm_per_rad=10.0,
        damping_nm_s_per_rad=0.01,
        inertia_kg_m2=1e-4,
    )
    viscous = PlantParams().knob_viscous_nm_s_per_rad + PlantParams().brake_viscous_nm_s_per_rad
    for assist_nm in (0.0, 5.5e-3):
        rows = simulate(in_free_air(assist_nm, hand), duration_s=2.0)
        felt = rows["hand_torque_nm"][rows["time_s"] > 1.0]
        expected = FRICTION_NM - assist_nm + viscous * speed_rad_s
        assert np.mean(felt) == pytest.approx(expected, abs=0.2e-3)


@pytest.mark.parametrize("step_nm", [-20e-3, 20e-3])
def test_torque_that_a_host_streams_comes_at_once_though_the_knob_moves(step_nm: float) -> None:
    """Half of it would come later if the law took it for the spring's."""
    moving = PrescribedMotion(angle_rad=[(0.0, 0.0), (1.0, math.copysign(1.0, -step_nm))])
    plant = PlantParams(counts_per_rev=131_072)
    loop = ClosedLoop(replace(options_of(stiffness=1.0, plant=plant, hand=moving), scene=None))
    spring = {"angle_rad": 0.0, "stiffness_nm_per_rad": 0.2}
    loop.stream_local_model(**spring)
    before_nm = loop.run(duration_s=0.2)["motor_command_nm"][-1]
    loop.stream_local_model(torque_nm=step_nm, **spring)
    after_nm = loop.run(duration_s=0.1)["motor_command_nm"][0]
    assert after_nm - before_nm == pytest.approx(step_nm, abs=1e-3)


def test_damper_that_a_host_streams_is_bounded_as_the_scenes() -> None:
    options = replace(
        options_of(stiffness=1.0, hand=TorqueHand(torque_nm=[(0.0, 0.0), (0.1, 60e-3)])),
        scene=Damper(damping_nm_s_per_rad=0.15),
    )
    in_scene = simulate(options, duration_s=2.0)
    loop = ClosedLoop(replace(options, scene=None))
    loop.stream_local_model(damping_nm_s_per_rad=0.15)
    streamed = loop.run(duration_s=2.0)
    np.testing.assert_array_equal(in_scene["angle_rad"], streamed["angle_rad"])


def test_host_that_shakes_the_knob_makes_no_unexpected_swings() -> None:
    options = EmulatorOptions(control=ControlConfig(law="calibrated"), control_rate_hz=10e3)
    with open_knob("emulated", emulator=options) as knob:
        knob.arm()
        for n in range(375):
            wave = math.sin(2.0 * math.pi * 16.0 * 4e-3 * n)
            knob.stream_local_model(stiffness_nm_per_rad=0.5, angle_rad=0.1 * wave)
            knob.sleep(4e-3)
        assert knob.health().unexpected_swings == 0


@pytest.mark.parametrize("amplitude_nm", [1e-6, 5e-3])
def test_torque_that_a_host_streams_passes_a_bounded_wall(amplitude_nm: float) -> None:
    """A stiff wall holds a weight, and gives less than it asks."""
    weight = TorqueHand(torque_nm=[(0.0, 0.0), (0.3, 60e-3)])
    options = options_of(stiffness=300.0, plant=PlantParams(counts_per_rev=8192), hand=weight)
    alone = simulate(options, duration_s=2.0)[-20_000:]
    loop, parts = ClosedLoop(options), []
    for n in range(2000):
        loop.stream_local_model(torque_nm=amplitude_nm * math.sin(2.0 * math.pi * 0.037 * n))
        parts.append(loop.run(duration_s=1e-3))
    streamed = np.concatenate(parts)[-20_000:]
    both_ways_nm = np.ptp(streamed["motor_command_nm"])
    assert both_ways_nm == pytest.approx(2.0 * amplitude_nm, rel=0.1, abs=1e-5)
    deeper_rad = float(np.mean(streamed["angle_rad"]) - np.mean(alone["angle_rad"]))
    assert deeper_rad < 2e-3
