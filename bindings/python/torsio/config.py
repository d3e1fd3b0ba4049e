"""Configuration of the device, and parameters of an emulated one. Defaults: reference actuator."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import pi, sin
from typing import Literal

from torsio import _torsio, checks

__all__ = [
    "ActuatorConfig",
    "Belt",
    "BoardConfig",
    "BrakeHysteresis",
    "Cogging",
    "ControlConfig",
    "GameConfig",
    "PlantParams",
    "ShaftHardening",
]


@dataclass(frozen=True)
class ActuatorConfig:
    """The actuator as built, as the device knows it.

    Attributes
    ----------
    brake_torque_min_nm
        Floor of the brake's torque in the sensor.
    brake_drag_nm
        What the brake holds with no current.
    spring_stiffness_nm_per_rad
        Of the shaft between knob and brake.
    counter_bits
        Width at which the encoder's counter wraps, 8 to 32.
    knob_inertia_kg_m2, knob_coulomb_nm, knob_viscous_nm_s_per_rad, motor_time_constant_s
        Of motor and knob; they bound what a game may ask for.
    """

    _: KW_ONLY
    motor_torque_max_nm: float = 85e-3
    brake_torque_max_nm: float = 110e-3
    brake_torque_min_nm: float = 3.3e-3
    brake_drag_nm: float = 2e-3
    brake_time_constant_s: float = 60e-3
    spring_stiffness_nm_per_rad: float = 2.873
    counts_per_rev: int = 8192
    counter_bits: int = 32
    encoder_reversed: bool = False
    knob_inertia_kg_m2: float = 6e-5
    knob_coulomb_nm: float = 6e-3
    knob_viscous_nm_s_per_rad: float = 2.6e-5
    motor_time_constant_s: float = 0.1e-3


@dataclass(frozen=True)
class BoardConfig:
    """What is wired to the board; docs/hardware.md. A pin is the number of its GPIO, 0 to 29.

    Attributes
    ----------
    supply_v
        Of both H-bridges.
    motor_torque_constant_nm_per_a, brake_torque_constant_nm_per_a
        At the knob, and on the pulley.
    motor_current_max_a
        Never asked for more; one and a half times as much measured is a fault.
    motor_resistance_ohm, motor_inductance_h, brake_resistance_ohm
        Of the windings.
    current_bandwidth_hz
        Of the motor's current loop.
    current_sense_v_per_a
        Of the current sensor.
    motor_reversed
        True: a current into the first motor pin turns the knob to smaller angles.
    encoder_pin, motor_pin, brake_pin
        The first of two pins each; motor's and brake's are even and not 16 apart.
    enable_pin, emergency_stop_pin, driver_fault_pin
        High while the power stages are on; low to run; low when a bridge reports an error.
    current_sense_pin
        26 to 28.
    light_pin
        Of the status light.
    """

    _: KW_ONLY
    supply_v: float = 12.0
    motor_torque_constant_nm_per_a: float = 0.05
    motor_current_max_a: float = 2.0
    motor_resistance_ohm: float = 2.5
    motor_inductance_h: float = 1.5e-3
    current_bandwidth_hz: float = 500.0
    current_sense_v_per_a: float = 0.2
    brake_torque_constant_nm_per_a: float = 0.44
    brake_current_max_a: float = 0.3
    brake_resistance_ohm: float = 40.0
    motor_reversed: bool = False
    encoder_pin: int = 2
    motor_pin: int = 6
    brake_pin: int = 8
    enable_pin: int = 10
    emergency_stop_pin: int = 11
    driver_fault_pin: int = 12
    current_sense_pin: int = 26
    light_pin: int = 25


@dataclass(frozen=True)
class ControlConfig:
    """How the device controls, and what it does when the host goes silent.

    Attributes
    ----------
    law
        How the desired torque is shared between motor and brake.
    beta
        The brake's share of the desired torque, 0 to 1.
    motor_torque_cap_nm, brake_torque_cap_nm
        The user's limits, below the actuator's.
    motor_slew_nm_per_s
        Largest rate of the motor's torque; 0 is no limit.
    speed_limit_rad_s
        Faster is a fault; 0 is no limit.
    watchdog_s
        Silence of the host that disarms, 0.01 to 60.
    passive_ramp_s, passive_brake_nm
        The motor's way to zero when the host is lost, and the brake's torque on that way.
    autonomous
        No watchdog: plays on without a host.
    """

    _: KW_ONLY
    law: Literal["paper", "compensated", "parallel", "motor_only"] = "paper"
    beta: float = 0.5
    speed_bandwidth_hz: float = 100.0
    motor_torque_cap_nm: float = 100.0
    brake_torque_cap_nm: float = 100.0
    motor_slew_nm_per_s: float = 0.0
    speed_limit_rad_s: float = 0.0
    watchdog_s: float = 0.25
    passive_ramp_s: float = 0.05
    passive_brake_nm: float = 0.0
    autonomous: bool = False


@dataclass(frozen=True)
class GameConfig:
    """What games may do over the game interface, and how their numbers become torques.

    Attributes
    ----------
    enabled
        False: games see the axis but move nothing.
    range_deg
        From one end of the game's axis to the other, round angle 0; 10 to 36,000.
    torque_max_nm
        Torque at full level, and the most that all effects together get.
    gain
        On top of the game's own gains, 0 to 1.
    spring_gain
        1: a full spring reaches full torque at the end of the axis.
    speed_full_rad_s, acceleration_full_rad_s2
        Where a full damper, and a full inertia, reaches full torque.
    blend_s
        In which a change of an effect, its beginning or its end takes full effect.
    silence_s
        Silence of the game that stops forces without end; 0 is never.
    """

    _: KW_ONLY
    enabled: bool = True
    range_deg: float = 900.0
    torque_max_nm: float = 100.0
    gain: float = 1.0
    spring_gain: float = 1.0
    speed_full_rad_s: float = 20.0
    acceleration_full_rad_s2: float = 3000.0
    blend_s: float = 2e-3
    silence_s: float = 10.0


@dataclass(frozen=True)
class ShaftHardening:
    """Part of a plant: beyond a knee of twist the shaft spring is stiffer by a factor, > 0."""

    _: KW_ONLY
    knee_rad: float = 0.015
    stiffness_factor: float = 2.0


@dataclass(frozen=True)
class BrakeHysteresis:
    """Part: magnetic hysteresis, a play of this half-width between command and brake torque."""

    _: KW_ONLY
    half_width_nm: float = 5.5e-3


@dataclass(frozen=True)
class Belt:
    """Part: a belt that stretches, between the spring's pulley and the brake.

    Attributes
    ----------
    pulley_inertia_kg_m2
        The share of the brake's inertia that lies before the belt.
    """

    _: KW_ONLY
    stiffness_nm_per_rad: float = 60.0
    damping_nm_s_per_rad: float = 1e-3
    pulley_inertia_kg_m2: float = 1e-5


@dataclass(frozen=True)
class Cogging:
    """Part: cogging of the motor, a torque on the knob that repeats along the turn.

    Attributes
    ----------
    torque_nm
        2 to 64 torques at equal distances over one period, from angle 0; straight lines between.
    """

    _: KW_ONLY
    periods_per_rev: int
    torque_nm: tuple[float, ...]

    @staticmethod
    def sine(*, periods_per_rev: int, amplitude_nm: float, points: int = 16) -> Cogging:
        """Make a sine wave of so many corners a period."""
        count = checks.whole("points", points, 2, 64)
        wave = [
            checks.number("amplitude_nm", amplitude_nm) * sin(2 * pi * i / count)
            for i in range(count)
        ]
        return Cogging(periods_per_rev=periods_per_rev, torque_nm=tuple(wave))


@dataclass(frozen=True)
class PlantParams:
    """Motor, knob, shaft spring, brake and encoder of an emulated knob. Torques are at the knob.

    Parts that are not named cost nothing; the lags of motor and brake are always carried.

    Attributes
    ----------
    shaft_stiffness_nm_per_rad
        0 cuts the shaft.
    encoder_rounding, encoder_phase_counts, encoder_noise_counts
        How the encoder counts, where in a count angle 0 lies, and its noise (standard deviation).
    spring_and_brake
        False takes knob and brake for one rigid body and the brake as never engaged, for what
        needs none, such as the law ``motor_only``. The parts below need it, but for `cogging`.
    """

    _: KW_ONLY
    knob_inertia_kg_m2: float = 6e-5
    knob_viscous_nm_s_per_rad: float = 2.6e-5
    knob_coulomb_nm: float = 6e-3
    brake_inertia_kg_m2: float = 4e-5
    brake_viscous_nm_s_per_rad: float = 2e-6
    brake_drag_nm: float = 2e-3
    shaft_stiffness_nm_per_rad: float = 2.873
    shaft_damping_nm_s_per_rad: float = 2e-4
    brake_time_constant_s: float = 60e-3
    motor_time_constant_s: float = 0.1e-3
    motor_limit_nm: float = 85e-3
    brake_limit_nm: float = 110e-3
    counts_per_rev: int = 8192
    encoder_rounding: Literal["floor", "nearest"] = "floor"
    encoder_phase_counts: float = 0.0
    encoder_noise_counts: float = 0.0
    spring_and_brake: bool = True
    shaft_hardening: ShaftHardening | None = None
    brake_hysteresis: BrakeHysteresis | None = None
    belt: Belt | None = None
    cogging: Cogging | None = None

    def matching_config(self) -> ActuatorConfig:
        """Give the configuration of a device that was calibrated perfectly to this plant."""
        return ActuatorConfig(**_torsio.matching_config(self))


def check_plant(name: str, plant: PlantParams) -> None:
    """Ask for a plant whose parts are what they are said to be."""
    checks.kind(name, plant, PlantParams, "PlantParams")
    for part, wanted in (
        ("shaft_hardening", ShaftHardening),
        ("brake_hysteresis", BrakeHysteresis),
        ("belt", Belt),
        ("cogging", Cogging),
    ):
        value = getattr(plant, part)
        if value is not None:
            checks.kind(part, value, wanted, f"{wanted.__name__} or None")
