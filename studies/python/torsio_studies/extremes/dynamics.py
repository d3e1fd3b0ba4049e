"""Extremes of the machine: stiffness, shares, lags, inertias, friction, delay."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

from torsio import core, emulator
from torsio.closed_loop import InitialState, LoopOptions, simulate
from torsio.printed import hands, scenes
from torsio.printed.config import ControlConfig, Law
from torsio.printed.plant import PlantParams
from torsio_studies.paper import critical, runs
from torsio_studies.steppers import Method, make_plant, stepped_by

Array = npt.NDArray[np.float64]
STIFFNESSES = (0.0, 1e-3, 1.0, 30.0, 1e3, 1e6)
SHAFT_STIFFNESSES = (1e-3, 1.0, 30.0, 1e3, 1e6)
TIME_CONSTANTS_S = (0.0, 1e-4, 60e-3, 1.0, 10.0)
INERTIA_RATIOS = (1e-4, 1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3, 1e4)


def stiff_wall_torque_nm(stiffness: float, motor_limit_nm: float = runs.MOTOR_NM) -> float:
    """Peak torque that a device with this limit commands in such a wall, its string cut."""
    hand = hands.TorqueHand(torque_nm=[(0, 0), (0.5, 60e-3), (1.0, 60e-3), (1.0, 0)])
    options = LoopOptions(
        scene=scenes.Wall(angle_rad=0.05, stiffness_nm_per_rad=stiffness),
        hand=hand,
        plant=PlantParams(motor_limit_nm=motor_limit_nm),
    )
    rows = simulate(options, duration_s=1.5)
    if not all(np.isfinite(rows[name]).all() for name in ("angle_rad", "motor_command_nm")):
        return math.inf
    return float(np.abs(rows["motor_command_nm"]).max())


def critical_errors(cases: tuple[tuple[float, float], ...]) -> list[tuple[float, float]]:
    """Relative errors at (stiffness ratio, beta) of the printed and of the guarded formula."""
    pairs = [(ratio * runs.SHAFT_NM_PER_RAD, beta) for ratio, beta in cases]
    found = critical.measured_critical_torque(pairs, halvings=10)
    return [
        (
            abs(critical.printed_critical_torque(ratio, beta) / torque - 1.0),
            abs(critical.critical_torque(ratio * runs.SHAFT_NM_PER_RAD, beta) / torque - 1.0),
        )
        for (ratio, beta), torque in zip(cases, found, strict=True)
    ]


def brake_step(period_over_lag: float, ticks: int = 40) -> tuple[Array, Array, Array]:
    """Step the brake's command: explicit Euler, the device's model, the exact answer."""
    command = 50e-3
    euler = np.zeros(ticks)
    with np.errstate(over="ignore"):
        for i in range(1, ticks):
            euler[i] = euler[i - 1] + period_over_lag * (command - euler[i - 1])
    params = core.BrakeParams(time_constant_s=1e-3 / period_over_lag, floor_nm=0.0)
    record = core.model_brake(core.BrakeState(), params, np.full(ticks - 1, command))
    model = np.concatenate([[0.0], record])
    exact = command * -np.expm1(-period_over_lag * np.arange(ticks))
    return euler, model.astype(np.float64), np.asarray(exact, dtype=np.float64)


def lag_tracking(time_constant_s: float, *, modelled_s: float) -> float:
    """Tracking error on the way into a wall (share of the peak), for such a brake.

    Parameters
    ----------
    modelled_s
        Time constant that the controller reckons with.
    """
    plant = PlantParams(brake_time_constant_s=time_constant_s)
    options = replace(
        runs.push_options(runs.per_degree(30), plant=plant),
        actuator=replace(plant.matching_config(), brake_time_constant_s=modelled_s),
    )
    return runs.run_push(options)[1].tracking_rms_in


_LOSSLESS = PlantParams(
    knob_coulomb_nm=0.0,
    knob_viscous_nm_s_per_rad=0.0,
    brake_drag_nm=0.0,
    brake_viscous_nm_s_per_rad=0.0,
    shaft_damping_nm_s_per_rad=0.0,
)


Measure = TypeVar("Measure", bound=Callable[..., float])


def _infinite_if_lost(measure: Measure) -> Measure:
    """Let an error be infinite where the simulation gives up because nothing bounds the motion."""

    @functools.wraps(measure)
    def measured(*args: object) -> float:
        try:
            return measure(*args)
        except RuntimeError:
            return math.inf

    return cast("Measure", measured)


@_infinite_if_lost
def shaft_swing_error(stiffness: float, method: Method) -> float:
    """Error of a free, lossless swing on a shaft of this stiffness, as a share of its amplitude.

    Against the closed form, the twist's cosine, for a tenth of a second in steps of 1 ms.
    """
    plant = replace(_LOSSLESS, shaft_stiffness_nm_per_rad=stiffness)
    amplitude = 1e-3
    options = stepped_by(
        method, LoopOptions(plant=plant, initial=InitialState(twist_rad=amplitude))
    )
    with np.errstate(over="ignore", invalid="ignore"):
        rows = simulate(options, duration_s=0.1)
        twist = rows["angle_rad"] - rows["brake_angle_rad"]
        inverse = 1.0 / plant.knob_inertia_kg_m2 + 1.0 / plant.brake_inertia_kg_m2
        swing = amplitude * np.cos(math.sqrt(stiffness * inverse) * rows["time_s"])
        error = float(np.abs(twist - swing).max()) / amplitude
    return error if math.isfinite(error) else math.inf


@_infinite_if_lost
def shaft_step_error(stiffness: float, method: Method) -> float:
    """Give by how much the motion depends on the step, for a shaft of this stiffness.

    Motor and brake work against friction for 0.1 s; knob and brake catch and let go. Compared are
    steps of 1 ms and of 0.125 ms: the knob's angle as a share of its range, or the shaft's torque
    as a share of its peak, whichever is worse.
    """
    ticks = np.arange(100)
    motor = np.where(ticks // 25 % 2 == 0, 60e-3, -60e-3)
    brake = 10e-3 * (1 + ticks // 10 % 4)
    runs_rows = []
    with np.errstate(over="ignore", invalid="ignore"):
        for step_ns in (1_000_000, 125_000):
            plant = make_plant(
                method, PlantParams(shaft_stiffness_nm_per_rad=stiffness), step_ns=step_ns
            )
            runs_rows.append(plant.record(motor, brake))
        coarse, fine = runs_rows
        errors = [
            np.abs(coarse[name] - fine[name]).max() / size
            for name, size in (
                ("angle_rad", np.ptp(fine["angle_rad"])),
                ("spring_torque_nm", np.abs(fine["spring_torque_nm"]).max()),
            )
        ]
    return float(max(errors)) if np.isfinite(errors).all() else math.inf


@_infinite_if_lost
def energy_error(ratio: float, method: Method) -> float:
    """Relative change of the energy of a free, lossless knob and brake in a tenth of a second.

    Parameters
    ----------
    ratio
        Inertia of the brake over the knob's.
    method
        "exact", or "regularised": Runge-Kutta 4 at the control period.
    """
    knob = PlantParams().knob_inertia_kg_m2
    plant = replace(_LOSSLESS, brake_inertia_kg_m2=ratio * knob)
    initial = InitialState(speed_rad_s=5.0, twist_rad=0.01)
    options = stepped_by(method, LoopOptions(plant=plant, initial=initial))
    with np.errstate(over="ignore", invalid="ignore"):
        rows = simulate(options, duration_s=0.1)
        twist = rows["angle_rad"] - rows["brake_angle_rad"]
        energy = (
            0.5 * knob * rows["speed_rad_s"] ** 2
            + 0.5 * ratio * knob * rows["brake_speed_rad_s"] ** 2
            + 0.5 * runs.SHAFT_NM_PER_RAD * twist**2
        )
        error = float(np.abs(energy / energy[0] - 1.0).max())
    return error if math.isfinite(error) else math.inf


def creep_rad_s(method: Method) -> float:
    """Speed of a knob under a torque that its friction holds."""
    options = stepped_by(
        method,
        LoopOptions(hand=hands.TorqueHand(torque_nm=5e-3)),
        step_ns=1_000_000 if method == "exact" else 10_000,
    )
    rows = simulate(options, duration_s=0.5)
    return float(np.abs(rows["speed_rad_s"][-100:]).max())


def weak_motor_motion_rad(method: Method) -> float:
    """Motion that is left one second after a cut string, with a motor weaker than friction."""
    options = runs.cut_options(runs.per_degree(25), plant=PlantParams(motor_limit_nm=4e-3))
    if method != "exact":
        options = stepped_by(method, options, step_ns=10_000)
    rows, _ = runs.run_cut(options)
    return float(np.ptp(rows["angle_rad"][-200:]))


HIGH_FLOOR_NM = 12e-3
"""A floor of the sensor above friction and drag together, 8 mN m."""


def free_air(guarded: bool, duration_s: float = 1.0) -> tuple[Array, Array]:
    """Time and angle of a knob that is flicked in free air.

    The naive law has no rule for a desired torque of 0: then the motor answers to the sensor.
    """
    ticks = round(1000 * duration_s)
    time, angle = np.linspace(0.0, 1e-3 * (ticks - 1), ticks), np.empty(ticks)
    hand = hands.TorqueHand(torque_nm=[(0, 60e-3), (0.02, 60e-3), (0.02, 0)])
    plant = emulator.Plant(hand=hand)
    encoder = emulator.Encoder()
    motion, motion_params = core.MotionState(), core.MotionParams()
    sensor = core.SoftSensorState()
    law = core.PartitionParams(law="paper")
    for i in range(ticks):
        angle[i] = plant.state["angle_rad"]
        moved = core.track_motion(motion, motion_params, encoder.sample(angle[i]))
        spring = core.sense_spring(sensor, moved.delta_rad, HIGH_FLOOR_NM)
        torque = core.partition(law, 0.0, spring).motor_command_nm if guarded else -spring
        plant.set_command(motor_command_nm=torque)
        plant.advance(1_000_000)
    return time, angle


def bounce_vibration_nm(stiffness: float, law: Law, **loop: Any) -> float:
    """Torque above 20 Hz after a bounce in such a spring; `loop` as in `runs.bounce_options`."""
    rows = simulate(runs.bounce_options(stiffness, law, **loop), duration_s=1.0)
    return runs.count_bounces(rows).vibration_nm


def share_error(beta: float, law: Law) -> float:
    """Tracking error on the way out of a wall for such a share of the brake."""
    options = runs.push_options(runs.per_degree(30), law, beta=beta)
    _, push = runs.run_push(options)
    return push.tracking_rms_out


STRING_WALL = runs.per_degree(25)
HELD_BY_FRICTION_NM = (
    PlantParams().knob_coulomb_nm + PlantParams().brake_drag_nm + STRING_WALL * runs.COUNT_RAD
)
"""The twist that dry friction holds without a brake, and one count that the encoder misses."""


def stuck_torque_nm(law: Law, beta: float) -> float:
    """Torque that a wall of 25 mN m/deg still asks for, a second after the string was cut."""
    _, cut = runs.run_cut(runs.cut_options(STRING_WALL, law, beta=beta))
    return cut.stuck_torque_nm


def brake_model_errors_nm(period_ns: int, time_constant_s: float) -> tuple[float, float]:
    """Worst error of the modelled brake torque (N m) in a closed loop.

    Returns
    -------
    tuple
        Of explicit Euler on the commands that the loop gave, and of the device's own model.
    """
    plant = PlantParams(brake_time_constant_s=time_constant_s)
    options = replace(
        runs.push_options(0.3, plant=plant),
        control=ControlConfig(),
        control_period_ns=period_ns,
    )
    rows = simulate(options, duration_s=runs.PUSH_DURATION_S)
    true = rows["brake_capacity_nm"] - plant.brake_drag_nm
    guarded = float(np.abs(rows["sensed_brake_capacity_nm"] - true).max())
    if time_constant_s == 0.0:
        return math.inf, guarded  # it would divide by it
    ratio = 1e-9 * period_ns / time_constant_s
    euler = np.zeros(len(rows))
    with np.errstate(over="ignore", invalid="ignore"):
        for i in range(1, len(rows)):
            command = float(rows["brake_command_nm"][i - 1])
            euler[i] = euler[i - 1] + ratio * (command - euler[i - 1])
        naive = float(np.abs(euler - true).max())
    return naive if math.isfinite(naive) else math.inf, guarded
