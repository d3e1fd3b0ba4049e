"""The parts of an emulated knob. Defaults: the reference actuator."""

# Printed from the field lists in emulator/definition/ by `./dev generate`;
# change those instead.

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass
from typing import Literal

from torsio.common import checks
from torsio.printed.plant_methods import CoggingShapes, PlantMethods

__all__ = [
    "Belt",
    "BrakeHysteresis",
    "Cogging",
    "Electrics",
    "ElectricsState",
    "PlantParams",
    "ShaftHardening",
]


@dataclass(frozen=True, repr=False)
class ShaftHardening(checks.ByName):
    """Part of a plant.

    The shaft spring is stiffer, or softer, beyond a knee of twist on both sides.

    Attributes
    ----------
    knee_rad
        The spring is linear up to here; > 0.
    stiffness_factor
        Stiffness beyond the knee over stiffness before it; > 0.
    """

    _: KW_ONLY
    knee_rad: float = 0.015
    stiffness_factor: float = 2.0


@dataclass(frozen=True, repr=False)
class BrakeHysteresis(checks.ByName):
    """Part of a plant.

    Magnetic hysteresis of the brake, a play between its current, which has the lag, and its torque.

    Attributes
    ----------
    half_width_nm
        Of the play; the default is 5 % of the brake's limit; >= 0.
    """

    _: KW_ONLY
    half_width_nm: float = 0.0055


@dataclass(frozen=True, repr=False)
class Belt(checks.ByName):
    """Part of a plant: a belt that stretches, between the spring's pulley and the brake.

    Attributes
    ----------
    stiffness_nm_per_rad
        Of the belt; > 0.
    damping_nm_s_per_rad
        Of the belt; >= 0.
    pulley_inertia_kg_m2
        The share of brake_inertia_kg_m2 that lies before the belt; > 0.
    """

    _: KW_ONLY
    stiffness_nm_per_rad: float = 60.0
    damping_nm_s_per_rad: float = 0.001
    pulley_inertia_kg_m2: float = 1e-05


@dataclass(frozen=True, repr=False)
class Cogging(CoggingShapes):
    """Part of a plant: cogging of the motor, a torque on the knob that repeats along the turn.

    Attributes
    ----------
    periods_per_rev
        Of the torque; 1 to 65535.
    torque_nm
        2 to 64 torques at equal distances over one period, from angle 0; straight lines between.
    """

    _: KW_ONLY
    periods_per_rev: int
    torque_nm: Iterable[float]

    def __post_init__(self) -> None:
        """Ask for the right kinds, and keep sequences so that they compare by value."""
        object.__setattr__(self, "torque_nm", checks.numbers("torque_nm", self.torque_nm))


@dataclass(frozen=True, repr=False)
class Electrics(checks.ByName):
    """Part of a plant: windings, bridges, supply and current sensor.

    With it the emulated device runs the board's own power stage; without it motor and brake are the
    lags that are given.

    Attributes
    ----------
    winding_resistance_ohm
        Of the motor, at 25 degrees; > 0.
    winding_inductance_h
        Of the motor; > 0.
    torque_constant_nm_per_a
        Of the motor, at the knob; V s/rad of back EMF as well; > 0.
    motor_reversed
        A current into the first pin turns the knob to smaller angles.
    coil_resistance_ohm
        Of the brake; > 0.
    coil_inductance_h
        Of the brake; > 0.
    coil_torque_constant_nm_per_a
        Of the brake, on the pulley; > 0.
    supply_v
        Without load; > 0.
    supply_resistance_ohm
        Of the supply; it takes no current back; >= 0.
    supply_capacitance_f
        Behind that; > 0.
    supply_divider_ratio
        The supply's voltage over what a board with supply_sense_pin measures of it; > 0.
    ambient_c
        Of the air; everything begins there; -100 to 300.
    winding_heat_j_per_k
        Heat capacity of the motor's winding; > 0.
    winding_to_rotor_k_per_w
        From there to the rotor; > 0.
    rotor_heat_j_per_k
        Heat capacity of the rotor; > 0.
    rotor_to_air_k_per_w
        From there to the air; > 0.
    coil_heat_j_per_k
        Heat capacity of the brake's coil; > 0.
    coil_to_air_k_per_w
        From there to the air; > 0.
    pwm_steps
        Of a bridge's full share; 1 to 65535.
    current_period_s
        Of the current loop, rounded to a whole part of the control period, which 0 is; 0 to 0.001.
    output_delay_s
        From a measurement to the voltage that answers it; at most a period of the current loop;
        1e-6 to 0.001.
    predictive
        The current loop of the RP2350; False: the one of the RP2040.
    sample_offset_s
        From the beginning of a measurement until it takes the current; boards begin 1 us before the
        middle of the bridge's pulse; 0 to 1e-5.
    sensor_v_per_a
        Of the current sensor; > 0.
    sensor_zero_v
        Its output without current; -10 to 10.
    sensor_noise_v
        Standard deviation; >= 0.
    sensor_range_v
        Of its converter, from 0; > 0.
    sensor_bits
        Of its converter; 1 to 24.
    sensor_state
        Dead: 0 V; stuck: at its zero; saturated: at the end of its range.
    """

    _: KW_ONLY
    winding_resistance_ohm: float = 2.5
    winding_inductance_h: float = 0.0015
    torque_constant_nm_per_a: float = 0.05
    motor_reversed: bool = False
    coil_resistance_ohm: float = 40.0
    coil_inductance_h: float = 2.4
    coil_torque_constant_nm_per_a: float = 0.44
    supply_v: float = 12.0
    supply_resistance_ohm: float = 0.1
    supply_capacitance_f: float = 0.0022
    supply_divider_ratio: float = 11.0
    ambient_c: float = 25.0
    winding_heat_j_per_k: float = 12.0
    winding_to_rotor_k_per_w: float = 4.0
    rotor_heat_j_per_k: float = 60.0
    rotor_to_air_k_per_w: float = 8.0
    coil_heat_j_per_k: float = 40.0
    coil_to_air_k_per_w: float = 20.0
    pwm_steps: int = 1875
    current_period_s: float = 2.5e-05
    output_delay_s: float = 2.5e-05
    predictive: bool = True
    sample_offset_s: float = 1e-06
    sensor_v_per_a: float = 0.2
    sensor_zero_v: float = 1.65
    sensor_noise_v: float = 0.001
    sensor_range_v: float = 3.3
    sensor_bits: int = 12
    sensor_state: Literal["works", "dead", "stuck", "saturated"] = "works"


@dataclass(frozen=True, repr=False)
class PlantParams(PlantMethods):
    """Motor, knob, shaft spring, brake and encoder of an emulated knob. Torques are at the knob.

    The defaults are the reference actuator; docs/explanation/theory.md has the equations. Parts
    that are not named cost nothing; the lags of motor and brake are always carried.

    Attributes
    ----------
    knob_inertia_kg_m2
        Motor and knob; > 0.
    knob_viscous_nm_s_per_rad
        Viscous friction there; >= 0.
    knob_coulomb_nm
        Dry friction there; >= 0.
    brake_inertia_kg_m2
        Pulleys and brake; > 0.
    brake_viscous_nm_s_per_rad
        Viscous friction there; >= 0.
    brake_drag_nm
        Drag of the released brake; >= 0.
    shaft_stiffness_nm_per_rad
        0: the shaft is cut; >= 0.
    shaft_damping_nm_s_per_rad
        Of the shaft; >= 0.
    brake_time_constant_s
        From command to torque; 0: no lag; >= 0.
    motor_time_constant_s
        From command to torque; 0: no lag; >= 0.
    motor_limit_nm
        Commands are clipped to it, both ways; >= 0.
    brake_limit_nm
        Commands are clipped to it; >= 0.
    counts_per_rev
        Of the encoder; 1 to 16777216.
    encoder_rounding
        How the encoder counts.
    encoder_index
        The pulse at the encoder's count 0, for a device with encoder_index_pin.
    encoder_phase_counts
        Where in a count angle 0 lies.
    encoder_noise_counts
        Standard deviation; 0 leaves the noise out; >= 0.
    spring_and_brake
        Part: spring and brake. Without it knob and brake are one rigid body and the brake never
        engages. This suits the law motor_only and saves about a third of the plant's time. All
        parts below except cogging need it.
    shaft_hardening
        Part: the spring has knees.
    brake_hysteresis
        Part: play in the brake.
    belt
        Part: the belt stretches.
    cogging
        Part: the motor cogs.
    electrics
        Part: windings, bridges, supply, sensor.
    """

    _: KW_ONLY
    knob_inertia_kg_m2: float = 6e-05
    knob_viscous_nm_s_per_rad: float = 2.6e-05
    knob_coulomb_nm: float = 0.006
    brake_inertia_kg_m2: float = 4e-05
    brake_viscous_nm_s_per_rad: float = 2e-06
    brake_drag_nm: float = 0.002
    shaft_stiffness_nm_per_rad: float = 2.873
    shaft_damping_nm_s_per_rad: float = 0.0002
    brake_time_constant_s: float = 0.06
    motor_time_constant_s: float = 4.4e-05
    motor_limit_nm: float = 0.085
    brake_limit_nm: float = 0.11
    counts_per_rev: int = 8192
    encoder_rounding: Literal["floor", "nearest"] = "floor"
    encoder_index: Literal["works", "missing", "doubled", "noisy"] = "works"
    encoder_phase_counts: float = 0.0
    encoder_noise_counts: float = 0.0
    spring_and_brake: bool = True
    shaft_hardening: ShaftHardening | None = None
    brake_hysteresis: BrakeHysteresis | None = None
    belt: Belt | None = None
    cogging: Cogging | None = None
    electrics: Electrics | None = None

    def __post_init__(self) -> None:
        """Ask for the right kinds, and keep sequences so that they compare by value."""
        if self.shaft_hardening is not None:
            checks.kind(
                "shaft_hardening", self.shaft_hardening, ShaftHardening, "ShaftHardening or None"
            )
        if self.brake_hysteresis is not None:
            checks.kind(
                "brake_hysteresis",
                self.brake_hysteresis,
                BrakeHysteresis,
                "BrakeHysteresis or None",
            )
        if self.belt is not None:
            checks.kind("belt", self.belt, Belt, "Belt or None")
        if self.cogging is not None:
            checks.kind("cogging", self.cogging, Cogging, "Cogging or None")
        if self.electrics is not None:
            checks.kind("electrics", self.electrics, Electrics, "Electrics or None")


@dataclass(frozen=True, repr=False)
class ElectricsState(checks.ByName):
    """True electric values of an emulated knob, now.

    Attributes
    ----------
    motor_current_a
        Positive turns the knob to larger angles.
    coil_current_a
        Of the brake.
    supply_v
        At the bridges.
    winding_c
        Temperature of the motor's winding.
    rotor_c
        Of its rotor.
    coil_c
        Of the brake's coil.
    """

    _: KW_ONLY
    motor_current_a: float = 0.0
    coil_current_a: float = 0.0
    supply_v: float = 0.0
    winding_c: float = 0.0
    rotor_c: float = 0.0
    coil_c: float = 0.0
