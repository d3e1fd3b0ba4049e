"""Configuration of the device. Defaults: the reference actuator.

It can be set only while the device is disarmed, and is lost at power-off unless
`Knob.save` keeps it.
"""

# Printed from the field lists in firmware/protocol/definition/ by `./dev generate`;
# change those instead.

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Final, Literal, TypeAlias

from torsio.common import checks

__all__ = [
    "CONFIGS",
    "ActuatorConfig",
    "BoardConfig",
    "CalibrationConfig",
    "ControlConfig",
    "GameConfig",
    "Law",
    "ShaftConfig",
]

Law: TypeAlias = Literal["paper", "compensated", "parallel", "motor_only", "calibrated"]
"""How motor and brake share the torque."""

MAX_TORQUE_NM = 100.0
"""Largest torque that a limit can be set to."""

MIN_CONTROL_RATE_HZ = 1000.0
"""Slowest control rate of a device."""

MAX_CONTROL_RATE_HZ = 20000.0
"""Fastest control rate of a device."""

EMULATED_CONTROL_PERIOD_NS = 1000000
"""A control period of the emulated device, unless it is told another."""

LET_GO_S = 0.004
"""A torque's way to zero when somebody disarms, where the passive ramp is not shorter."""

EXCITATION_STILL_S = 0.05
"""For so long an excitation's servo may ask for all its torque and see no count."""


@dataclass(frozen=True, repr=False)
class ActuatorConfig(checks.ByName):
    """The actuator as built. The defaults are the reference actuator.

    Set only while disarmed; another encoder empties the scene.

    Attributes
    ----------
    motor_torque_max_nm
        Largest torque of the motor; 0 to 100.
    brake_torque_max_nm
        Largest torque of the brake; 0 to 100.
    brake_torque_min_nm
        Least brake torque that the sensor assumes; 0 to 100.
    brake_drag_nm
        Drag of the brake without current; 0 to 100.
    brake_time_constant_s
        The brake's lag from command to torque; 0 to 100.
    spring_stiffness_nm_per_rad
        Stiffness of the shaft between knob and brake; 0 to 1e6.
    counts_per_rev
        The encoder's counts in a turn; 4 to 16777216.
    counter_bits
        Width at which the encoder's counter wraps; 8 to 32.
    encoder_reversed
        True: it counts down where the angle grows.
    knob_inertia_kg_m2
        Inertia of motor and knob; this and the next three bound a game's effects; 1e-9 to 1.
    knob_coulomb_nm
        Dry friction of motor and knob; 0 to 100.
    knob_viscous_nm_s_per_rad
        Viscous friction of motor and knob; 0 to 1000.
    motor_time_constant_s
        The motor's lag from command to torque; 0 to 1.
    brake_inertia_kg_m2
        Inertia of pulleys and brake; 0: not counted. This and the next two are for the law
        calibrated; 0 to 1.
    brake_hysteresis_nm
        Half the width of the brake's hysteresis loop; 0 to 100.
    brake_release_time_constant_s
        The brake's lag while its torque falls; 0: as `brake_time_constant_s`; 0 to 100.
    encoder_index_pin
        GPIO of the encoder's index, one pulse a turn; 0: none. Save it: it takes effect at the next
        start; 0 to 29.
    """

    _: KW_ONLY
    motor_torque_max_nm: float = 0.085
    brake_torque_max_nm: float = 0.11
    brake_torque_min_nm: float = 0.0033
    brake_drag_nm: float = 0.002
    brake_time_constant_s: float = 0.06
    spring_stiffness_nm_per_rad: float = 2.873
    counts_per_rev: int = 8192
    counter_bits: int = 32
    encoder_reversed: bool = False
    knob_inertia_kg_m2: float = 6e-05
    knob_coulomb_nm: float = 0.006
    knob_viscous_nm_s_per_rad: float = 2.6e-05
    motor_time_constant_s: float = 4.4e-05
    brake_inertia_kg_m2: float = 4e-05
    brake_hysteresis_nm: float = 0.0
    brake_release_time_constant_s: float = 0.0
    encoder_index_pin: int = 0


@dataclass(frozen=True, repr=False)
class ControlConfig(checks.ByName):
    """How the device controls, and what it does when the host goes silent.

    Set only while disarmed.

    Attributes
    ----------
    law
        How the desired torque is shared between motor and brake.
    beta
        The brake's share of the desired torque; 0 to 1.
    speed_bandwidth_hz
        Bandwidth of the speed estimate; 1 to 1e4.
    motor_torque_cap_nm
        The user's limit, below the actuator's; 0 to 100.
    brake_torque_cap_nm
        The user's limit, below the actuator's; 0 to 100.
    motor_slew_nm_per_s
        Largest rate of the motor's torque; 0 is no limit; 0 to 1e6.
    speed_limit_rad_s
        A faster knob is a fault; 0: no limit; 0 to 1e4.
    watchdog_s
        Silence of the host after which the knob disarms; 0.01 to 60.
    passive_ramp_s
        Time of the motor's torque to zero when the host is lost; 0 to 10.
    passive_brake_nm
        The brake's torque during the ramp; 0 releases it; 0 to 100.
    autonomous
        True: no watchdog, plays on without a host.
    free_assist_nm
        Friction that the motor cancels where the scene asks for nothing, at most three quarters of
        the configured friction, for four turns without a rest at most; law calibrated only; 0 to
        100.
    """

    _: KW_ONLY
    law: Literal["paper", "compensated", "parallel", "motor_only", "calibrated"] = "paper"
    beta: float = 0.5
    speed_bandwidth_hz: float = 100.0
    motor_torque_cap_nm: float = MAX_TORQUE_NM
    brake_torque_cap_nm: float = MAX_TORQUE_NM
    motor_slew_nm_per_s: float = 0.0
    speed_limit_rad_s: float = 0.0
    watchdog_s: float = 0.25
    passive_ramp_s: float = 0.05
    passive_brake_nm: float = 0.0
    autonomous: bool = False
    free_assist_nm: float = 0.0


@dataclass(frozen=True, repr=False)
class BoardConfig(checks.ByName):
    """The board's wiring, and the electrical values of motor and brake; docs/how-to/hardware.md.

    A pin is the number of its GPIO. Set only while disarmed, then save: it takes effect at the next
    start. The emulated device uses it where it has Electrics.

    Attributes
    ----------
    supply_v
        Voltage of both H-bridges; 3 to 60.
    motor_torque_constant_nm_per_a
        The motor's torque an ampere, at the knob; 1e-4 to 100.
    motor_current_max_a
        Largest current the firmware asks for; a measured current of 1.5 times as much is a fault; 0
        to 100.
    motor_current_continuous_a
        Continuous current of the winding in air of 25 degrees; more is given for seconds only; 0 to
        100.
    motor_resistance_ohm
        Resistance of the winding; 0.001 to 1000.
    motor_inductance_h
        Inductance of the winding; 1e-6 to 1.
    current_bandwidth_hz
        Of the current loop; on a pico held at a tenth of the control rate; 1 to 65535.
    current_sense_v_per_a
        Of the current sensor; its zero is measured while the power is off; 0.001 to 10.
    brake_torque_constant_nm_per_a
        The brake's torque an ampere, on its pulley; 1e-4 to 1000.
    brake_current_max_a
        Largest current of the coil; 0 to 100.
    brake_resistance_ohm
        Resistance of the coil; 0.001 to 1e4.
    brake_inductance_h
        Inductance of the coil. Above 0 the bridge drives the coil both ways, with the actuator's
        brake_time_constant_s. 0: the current follows as the coil lets it; 0 to 1000.
    motor_reversed
        True: a current into the first motor pin turns the knob to smaller angles.
    confirmed
        True: somebody has checked the parts. A real board holds torques and speed low until this is
        on and `values_are` is not `assumed`. Acts at once.
    brake_continuous_percent
        Continuous current of the coil in air of 25 degrees, of brake_current_max_a; more is given
        for a while only; 0 to 100.
    ambient_c
        Highest temperature of the air around motor and brake; 0 to 100.
    supply_sense_ratio
        Of the divider at supply_sense_pin: the supply's voltage over the pin's; 1 to 255.
    encoder_pin
        GPIO of A; B is the next one; 0 to 28.
    motor_pin
        GPIO of the first input of the motor's bridge, even; the second is the next one; 0 to 28.
    brake_pin
        GPIO of the first input of the brake's bridge, even; the second is the next one; 0 to 28.
    enable_pin
        GPIO, high while the power stages are on; 0 to 29.
    emergency_stop_pin
        GPIO, low to run; an open wire stops; 0 to 29.
    driver_fault_pin
        GPIO, low when a bridge reports an error; 0 to 29.
    current_sense_pin
        GPIO of the motor's current sensor; 26 to 28.
    supply_sense_pin
        GPIO of a divider at the supply, 26 to 28; the supply is then watched. 0: none; 0 to 28.
    light_pin
        GPIO of the status light; 0 to 29.
    """

    _: KW_ONLY
    supply_v: float = 12.0
    motor_torque_constant_nm_per_a: float = 0.05
    motor_current_max_a: float = 2.0
    motor_current_continuous_a: float = 1.0
    motor_resistance_ohm: float = 2.5
    motor_inductance_h: float = 0.0015
    current_bandwidth_hz: int = 10000
    current_sense_v_per_a: float = 0.2
    brake_torque_constant_nm_per_a: float = 0.44
    brake_current_max_a: float = 0.3
    brake_resistance_ohm: float = 40.0
    brake_inductance_h: float = 0.0
    motor_reversed: bool = False
    confirmed: bool = False
    brake_continuous_percent: int = 100
    ambient_c: int = 25
    supply_sense_ratio: int = 11
    encoder_pin: int = 2
    motor_pin: int = 6
    brake_pin: int = 8
    enable_pin: int = 10
    emergency_stop_pin: int = 11
    driver_fault_pin: int = 12
    current_sense_pin: int = 26
    supply_sense_pin: int = 0
    light_pin: int = 25


@dataclass(frozen=True, repr=False)
class GameConfig(checks.ByName):
    """Permissions of games on the game interface, and the scale of their torques.

    Docs/reference/games.md.

    Set only while disarmed.

    Attributes
    ----------
    enabled
        False: games see the axis but move nothing.
    range_deg
        Angle from one end of the game's axis to the other, round angle 0; 10 to 36000.
    torque_max_nm
        Torque at full level, and the limit of all effects together; never more than the motor's; 0
        to 100.
    gain
        Strength of all games' effects, times their own gains; 0 to 1.
    spring_gain
        1: a full spring reaches full torque at the end of the axis; 0 to 1000.
    speed_full_rad_s
        Speed at which a full damper reaches full torque; 0.1 to 1e4.
    acceleration_full_rad_s2
        Acceleration at which a full inertia reaches full torque; 1 to 1e7.
    blend_s
        In which a change of an effect, its beginning or its end takes full effect; 0 to 0.1.
    silence_s
        Silence of the game after which forces without end stop; 0: never; 0 to 3600.
    join_updates
        True: updates of a steady force are joined by lines, half a frame of the game late; hits
        pass.
    end_stiffness_nm_per_rad
        Stiffness of walls at both ends of the axis, while a game has the actuator; 0: none; 0 to
        1e6.
    personality
        The computer's view of the knob; save it: it takes effect at the next start.
    dial_use
        Use of a dial.
    dial_detents
        Detents of a dial in a turn; 1 to 240.
    dial_torque_nm
        Torque between two detents of a dial, held down to a stable one; 0: it turns freely; 0 to
        100.
    own_damper_percent
        Share of a full damper, always felt while somebody turns the knob, with a game and without;
        0 to 100.
    own_friction_percent
        Share of full torque as friction, always felt, with a game and without; 0 to 100.
    own_inertia_percent
        Share of a full inertia, always felt, with a game and without; 0 to 100.
    own_spring_percent
        Share of a full spring to the middle, while no game plays; 0 to 100.
    constants_gain_percent
        Strength of games' constant forces and ramps; 0 to 100.
    waves_gain_percent
        Strength of games' waves; 0 to 100.
    springs_gain_percent
        Strength of games' springs; 0 to 100.
    dampers_gain_percent
        Strength of games' dampers; 0 to 100.
    inertias_gain_percent
        Strength of games' inertias; 0 to 100.
    frictions_gain_percent
        Strength of games' frictions; 0 to 100.
    torque_max_percent
        Share of the motor's torque that all effects together get at most; the smaller of this and
        `torque_max_nm` counts; 1 to 100.
    reversed
        True: axis, games' forces and the dial go the other way.
    dial_coarse
        True: a dial tells whole detents, although the host asks for fine ones.
    dial_fast_steps
        Steps of a wheel for a detent that is turned at two turns a second or faster; in proportion
        below, down to one; 1 to 20.
    remote_wakeup
        True: turning or pressing wakes a host that sleeps, if it lets; from the next start on.
    """

    _: KW_ONLY
    enabled: bool = True
    range_deg: float = 900.0
    torque_max_nm: float = MAX_TORQUE_NM
    gain: float = 1.0
    spring_gain: float = 20.0
    speed_full_rad_s: float = 20.0
    acceleration_full_rad_s2: float = 3000.0
    blend_s: float = 0.002
    silence_s: float = 10.0
    join_updates: bool = True
    end_stiffness_nm_per_rad: float = 0.0
    personality: Literal["game_controller", "dial"] = "game_controller"
    dial_use: Literal[
        "wheel", "pan", "volume", "radial", "wheel_or_pan", "wheel_or_volume", "volume_or_wheel"
    ] = "wheel"
    dial_detents: int = 24
    dial_torque_nm: float = 0.02
    own_damper_percent: int = 0
    own_friction_percent: int = 0
    own_inertia_percent: int = 0
    own_spring_percent: int = 0
    constants_gain_percent: int = 100
    waves_gain_percent: int = 100
    springs_gain_percent: int = 100
    dampers_gain_percent: int = 100
    inertias_gain_percent: int = 100
    frictions_gain_percent: int = 100
    torque_max_percent: int = 100
    reversed: bool = False
    dial_coarse: bool = False
    dial_fast_steps: int = 1
    remote_wakeup: bool = False


@dataclass(frozen=True, repr=False)
class ShaftConfig(checks.ByName):
    """The curve of the shaft's spring beyond its first straight piece.

    Up to the first knee the stiffness is the actuator's `spring_stiffness_nm_per_rad`. Both
    directions are alike.

    Set only while disarmed.

    Attributes
    ----------
    knee_1_rad
        Twist of the first knee; 0: the spring is one straight line; 0 to 100.
    knee_1_nm_per_rad
        Stiffness beyond this knee; more than 0, so that the torque always grows; 0 to 1e6.
    knee_2_rad
        Twist of the second knee, beyond the first; 0: none; 0 to 100.
    knee_2_nm_per_rad
        Stiffness beyond this knee; more than 0, so that the torque always grows; 0 to 1e6.
    knee_3_rad
        Twist of the third knee; 0 to 100.
    knee_3_nm_per_rad
        Stiffness beyond this knee; more than 0, so that the torque always grows; 0 to 1e6.
    knee_4_rad
        Twist of the fourth knee; 0 to 100.
    knee_4_nm_per_rad
        Stiffness beyond this knee; more than 0, so that the torque always grows; 0 to 1e6.
    """

    _: KW_ONLY
    knee_1_rad: float = 0.0
    knee_1_nm_per_rad: float = 0.0
    knee_2_rad: float = 0.0
    knee_2_nm_per_rad: float = 0.0
    knee_3_rad: float = 0.0
    knee_3_nm_per_rad: float = 0.0
    knee_4_rad: float = 0.0
    knee_4_nm_per_rad: float = 0.0


@dataclass(frozen=True, repr=False)
class CalibrationConfig(checks.ByName):
    """How well the values of actuator and shaft are known, and since when.

    It belongs to the values that the device has when it takes this report. When one of them
    changes, `values_are` reads `assumed`. A `sigma` is the standard uncertainty of a value; 0: it
    was not measured.

    Set only while disarmed.

    Attributes
    ----------
    values_are
        Source of the values of actuator and shaft.
    calibrated_unix_s
        Time of the measurement, in seconds since 1970; 0: never; 0 to 4294967300.
    ambient_k
        The room's temperature, as the user gave it; 0: not given; 0 to 1000.
    calibrated_rate_hz
        Control rate of the measurement; 0 to 1e6.
    sigma_knob_inertia_kg_m2
        Of `knob_inertia_kg_m2`; 0 to 1e6.
    sigma_knob_coulomb_nm
        Of `knob_coulomb_nm`; 0 to 1e6.
    sigma_knob_viscous_nm_s_per_rad
        Of `knob_viscous_nm_s_per_rad`; 0 to 1e6.
    sigma_spring_stiffness_nm_per_rad
        Of `spring_stiffness_nm_per_rad`; 0 to 1e6.
    sigma_knee_1_rad
        Of `knee_1_rad`; 0 to 1e6.
    sigma_knee_1_nm_per_rad
        Of `knee_1_nm_per_rad`; 0 to 1e6.
    sigma_brake_drag_nm
        Of `brake_drag_nm`; 0 to 1e6.
    sigma_brake_time_constant_s
        Of `brake_time_constant_s`; 0 to 1e6.
    sigma_brake_release_time_constant_s
        Of `brake_release_time_constant_s`; 0 to 1e6.
    sigma_brake_inertia_kg_m2
        Of `brake_inertia_kg_m2`; 0 to 1e6.
    sigma_brake_hysteresis_nm
        Of `brake_hysteresis_nm`; 0 to 1e6.
    sigma_motor_resistance_permille
        Standard uncertainty of the board's `motor_resistance_ohm` in thousandths of it; 0: it was
        not measured; 0 to 255.
    sigma_motor_inductance_permille
        Standard uncertainty of the board's `motor_inductance_h` in thousandths of it; 0: it was not
        measured; 0 to 255.
    sigma_motor_torque_constant_permille
        Standard uncertainty of the board's `motor_torque_constant_nm_per_a` in thousandths of it;
        0: it was not measured; 0 to 255.
    """

    _: KW_ONLY
    values_are: Literal["assumed", "stated", "measured"] = "assumed"
    calibrated_unix_s: int = 0
    ambient_k: float = 0.0
    calibrated_rate_hz: float = 0.0
    sigma_knob_inertia_kg_m2: float = 0.0
    sigma_knob_coulomb_nm: float = 0.0
    sigma_knob_viscous_nm_s_per_rad: float = 0.0
    sigma_spring_stiffness_nm_per_rad: float = 0.0
    sigma_knee_1_rad: float = 0.0
    sigma_knee_1_nm_per_rad: float = 0.0
    sigma_brake_drag_nm: float = 0.0
    sigma_brake_time_constant_s: float = 0.0
    sigma_brake_release_time_constant_s: float = 0.0
    sigma_brake_inertia_kg_m2: float = 0.0
    sigma_brake_hysteresis_nm: float = 0.0
    sigma_motor_resistance_permille: int = 0
    sigma_motor_inductance_permille: int = 0
    sigma_motor_torque_constant_permille: int = 0


Config: TypeAlias = (
    ActuatorConfig | ControlConfig | BoardConfig | GameConfig | ShaftConfig | CalibrationConfig
)
"""One of them."""

CONFIGS: Final[dict[str, type[Config]]] = {
    "actuator": ActuatorConfig,
    "control": ControlConfig,
    "board": BoardConfig,
    "game": GameConfig,
    "shaft": ShaftConfig,
    "calibration": CalibrationConfig,
}
"""All there are; the report of one is called NAME_config."""
