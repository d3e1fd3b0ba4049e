"""Extremes: what is not finite, offered in Python and to the core's inner functions."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from functools import partial
from typing import Any, Final

import torsio
from torsio import core
from torsio.closed_loop import ClosedLoop, InitialState, LoopOptions, SpinUp, simulate
from torsio.printed.config import ActuatorConfig
from torsio.printed.hands import FeedbackHand, ImpedanceHand, PrescribedMotion, TorqueHand
from torsio.printed.plant import Belt, BrakeHysteresis, Cogging, PlantParams, ShaftHardening
from torsio.printed.scenes import (
    Constant,
    Curve,
    Damper,
    Detents,
    Effect,
    EndStops,
    Excitation,
    Friction,
    Impact,
    Inertia,
    Periodic,
    Ramp,
    Spring,
    Texture,
    Timing,
    Wall,
)

NOT_FINITE: Final = (math.nan, math.inf, -math.inf)

# One good value of everything that has quantities; which they are is read from the classes, and a
# test sees to it that no class is missing.
SCENE: Final[tuple[Effect, ...]] = (
    Wall(stiffness_nm_per_rad=1.0),
    Spring(stiffness_nm_per_rad=1.0),
    Damper(damping_nm_s_per_rad=1e-3),
    Friction(torque_nm=1e-2),
    Inertia(inertia_kg_m2=1e-5),
    Constant(torque_nm=1e-2),
    Ramp(start_torque_nm=0.0, end_torque_nm=1e-2, timing=Timing(duration_s=1.0)),
    Periodic(amplitude_nm=1e-2, frequency_hz=5.0),
    Detents(torque_nm=1e-2, per_turn=24.0),
    Detents(torque_nm=1e-2, pitch_rad=0.2),
    EndStops(lower_rad=-1.0, upper_rad=1.0, stiffness_nm_per_rad=1.0),
    Texture(torque_nm=1e-2, grains_per_turn=100),
    Curve(torque_nm=(0.0, 0.1)),
    Impact(strength_nm_s_per_rad=1e-2, pulse_nm_s_per_rad=1e-2),
)
PLANT: Final = PlantParams(
    shaft_hardening=ShaftHardening(),
    brake_hysteresis=BrakeHysteresis(),
    belt=Belt(),
    cogging=Cogging(periods_per_rev=7, torque_nm=(1e-3, -1e-3)),
)
_PATH: Final = ((0.0, 0.0), (1.0, 0.1))
LOOPS: Final = (
    LoopOptions(scene=SCENE, actuator=ActuatorConfig()),
    LoopOptions(plant=PLANT, actuator=ActuatorConfig(), initial=InitialState()),
    LoopOptions(hand=TorqueHand(torque_nm=_PATH)),
    LoopOptions(
        hand=ImpedanceHand(
            intended_angle_rad=_PATH,
            stiffness_nm_per_rad=1.0,
            damping_nm_s_per_rad=1e-2,
            inertia_kg_m2=1e-4,
        )
    ),
    LoopOptions(hand=PrescribedMotion(angle_rad=_PATH)),
    LoopOptions(hand=FeedbackHand(torque_nm=lambda time_s, angle_rad, speed_rad_s: 0.0)),
    LoopOptions(spin_up=SpinUp(motor_command_nm=40e-3, speed_rad_s=1.0)),
)
CHAIN_INPUTS: Final = ("delta_rad", "held_command_nm", "desired_nm")
EXPERIMENT: Final = Excitation(
    duration_s=1.0, travel_rad=1.0, speed_limit_rad_s=10.0, torque_limit_nm=1e-2
)
CONFIGS: Final = tuple(kind() for kind in torsio.CONFIGS.values())


Make = Callable[[], Any]
"""Makes one such copy, or refuses to."""


def spoiled(value: Any) -> Iterator[Make]:
    """Give makers of copies with each float in it, however deep, not finite in turn."""
    if isinstance(value, float):
        for bad in NOT_FINITE:
            yield partial(float, bad)
    elif isinstance(value, tuple):
        for i, item in enumerate(value):
            for make in spoiled(item):
                yield partial(_with_item, value, i, make)
    elif is_dataclass(value) and not isinstance(value, type):
        for one in fields(value):
            for make in spoiled(getattr(value, one.name)):
                yield partial(_with_field, value, one.name, make)


def _with_item(values: tuple[Any, ...], index: int, make: Make) -> tuple[Any, ...]:
    return (*values[:index], make(), *values[index + 1 :])


def _with_field(value: Any, name: str, make: Make) -> Any:
    return replace(value, **{name: make()})


def _with_argument(method: Callable[..., Any], name: str, value: float) -> None:
    method(**{name: value})


def _used(use: Callable[[Any], Any], make: Make) -> None:
    use(make())


def accepted_in_python() -> tuple[int, int]:
    """Offer NaN and infinities in every quantity of the Python package.

    Returns
    -------
    tuple
        How many were offered, and how many were not refused.
    """
    offers: list[Make] = []

    def offer(use: Callable[[Any], Any], good: Any) -> None:
        use(good)  # a case that is refused anyway proves nothing
        offers.extend(partial(_used, use, make) for make in spoiled(good))

    for options in LOOPS:
        offer(lambda one: simulate(one, duration_s=1e-3), options)
    offer(lambda seconds: simulate(LoopOptions(), duration_s=seconds), 1e-3)
    with torsio.open("emulated") as knob:
        for config in CONFIGS:
            offer(knob.configure, config)
        knob.arm()
        loop = ClosedLoop(LoopOptions())
        for method in (knob.stream_local_model, loop.hold_command):
            quantities = {
                name: parameter.default
                for name, parameter in inspect.signature(method).parameters.items()
            }
            for name, good in quantities.items():
                offer(partial(_with_argument, method, name), float(good))
        offer(knob.excite, EXPERIMENT)
        refused = 0
        for one in offers:
            try:
                one()
            except ValueError:
                refused += 1
    return len(offers), len(offers) - refused


def spoiled_for_good() -> tuple[int, int]:
    """Give the core's inner functions, which check nothing, a value that is not finite once.

    They are chained as the device's controller chains them, round a wall that is turned into; the
    value takes the place of one of their inputs for one tick.

    Returns
    -------
    tuple
        How many values were tried, and after how many the motor's torque was wrong to the end.
    """
    good = _chained(None, 0.0)
    wrong = 0
    for name in CHAIN_INPUTS:
        for bad in NOT_FINITE:
            last = _chained(name, bad)
            wrong += not math.isclose(last, good, abs_tol=1e-6)
    return len(CHAIN_INPUTS) * len(NOT_FINITE), wrong


def _chained(spoiled_input: str | None, bad: float) -> float:
    """Motor's torque at the end of 60 counts into the wall."""
    brake, sensor = core.BrakeState(), core.SoftSensorState()
    brake_params, law = core.BrakeParams(), core.PartitionParams(law="paper")
    count_rad = 2.0 * math.pi / PlantParams().counts_per_rev
    command_nm, motor_nm = 0.0, 0.0
    for tick in range(60):
        inputs = {
            "delta_rad": count_rad,
            "held_command_nm": command_nm,
            "desired_nm": -1.4 * tick * count_rad,
        }
        if tick == 20 and spoiled_input is not None:
            inputs[spoiled_input] = bad
        capacity = core.model_brake(brake, brake_params, inputs["held_command_nm"])
        spring = core.sense_spring(sensor, inputs["delta_rad"], capacity)
        shares = core.partition(law, inputs["desired_nm"], spring)
        motor_nm, command_nm = shares.motor_command_nm, shares.brake_command_nm
    return motor_nm
