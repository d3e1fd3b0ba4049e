"""An emulated knob: its parts, its hand, its options.

The simulator works with these structures directly, and C++ and Python users fill them in.
"""

from __future__ import annotations

from dataclasses import replace

from firmware.protocol.definition import configurations, constants
from firmware.protocol.definition.constants import MOTOR_LAG_S
from tools.definition.model import (
    Field,
    Structure,
    Value,
    any_whole,
    binary,
    choice,
    enumeration,
    for_hosts,
    function,
    group,
    hand,
    number,
    numbers,
    optional_group,
    profile,
    text,
    told,
    whole,
)

# Far beyond any knob, and far within what the plant can compute.
_MOST = 1e15
_LEAST = 1e-15


def positive(name: str, unit: str, doc: str, default: float | None = None) -> Field:
    """Make a quantity that something is divided by."""
    made = for_hosts(number(name, unit, _LEAST, _MOST, doc, default=default))
    return replace(made, rule="> 0")


def amount(
    name: str, unit: str, doc: str, default: float | None = None, *, most: float = _MOST
) -> Field:
    """Make a quantity that may be nothing."""
    made = for_hosts(number(name, unit, 0.0, most, doc, default=default))
    return replace(made, rule=">= 0" if most == _MOST else "")


def share(name: str, doc: str) -> Field:
    """Make a probability."""
    return for_hosts(number(name, "", 0.0, 1.0, doc))


def yes_or_no(name: str, doc: str, *, default: bool = False) -> Field:
    """Make a switch that never travels."""
    return Field(name, "switch", doc, default=default, host="bool")


ENCODER_ROUNDING = enumeration(
    "EncoderRounding", "The count of an angle between two counts.", "floor", "nearest"
)

SHAFT_HARDENING = Structure(
    "ShaftHardening",
    "Part of a plant: the shaft spring is stiffer, or softer, beyond a knee of twist on both sides.",
    (
        positive("knee_rad", "rad", "the spring is linear up to here", 0.015),
        positive("stiffness_factor", "", "stiffness beyond the knee over stiffness before it", 2.0),
    ),
)
BRAKE_HYSTERESIS = Structure(
    "BrakeHysteresis",
    "Part of a plant: magnetic hysteresis of the brake, a play between its current, which has the lag, and its torque.",
    (
        amount(
            "half_width_nm", "N m", "of the play; the default is 5 % of the brake's limit", 5.5e-3
        ),
    ),
)
BELT = Structure(
    "Belt",
    "Part of a plant: a belt that stretches, between the spring's pulley and the brake.",
    (
        positive("stiffness_nm_per_rad", "N m/rad", "of the belt", 60.0),
        amount("damping_nm_s_per_rad", "N m s/rad", "of the belt", 1e-3),
        positive(
            "pulley_inertia_kg_m2",
            "kg m^2",
            "the share of brake_inertia_kg_m2 that lies before the belt",
            1e-5,
        ),
    ),
)
COGGING = Structure(
    "Cogging",
    "Part of a plant: cogging of the motor, a torque on the knob that repeats along the turn.",
    (
        for_hosts(whole("periods_per_rev", "u16", 1, 0xFFFF, "of the torque", default=None)),
        numbers(
            "torque_nm", "N m",
            "2 to 64 torques at equal distances over one period, from angle 0; straight lines between",
        ),
    ),
    base="CoggingShapes",
)  # fmt: skip

CURRENT_SENSOR = enumeration(
    "CurrentSensorState", "State of a current sensor.",
    "works", "dead", "stuck", "saturated",
)  # fmt: skip

INDEX_PULSE = enumeration(
    "IndexPulse", "Pulse of an encoder's index: right, never there, two in a turn, or amid sparks.",
    "works", "missing", "doubled", "noisy",
)  # fmt: skip

ELECTRICS = Structure(
    "Electrics",
    "Part of a plant: windings, bridges, supply and current sensor. With it the emulated device runs "
    "the board's own power stage; without it motor and brake are the lags that are given.",
    (
        positive("winding_resistance_ohm", "ohm", "of the motor, at 25 degrees", constants.REFERENCE_MOTOR_RESISTANCE_OHM),
        positive("winding_inductance_h", "H", "of the motor", constants.REFERENCE_MOTOR_INDUCTANCE_H),
        positive("torque_constant_nm_per_a", "N m/A", "of the motor, at the knob; V s/rad of back EMF as well", constants.REFERENCE_MOTOR_TORQUE_CONSTANT_NM_PER_A),
        yes_or_no("motor_reversed", "a current into the first pin turns the knob to smaller angles"),
        positive("coil_resistance_ohm", "ohm", "of the brake", constants.REFERENCE_BRAKE_RESISTANCE_OHM),
        positive("coil_inductance_h", "H", "of the brake", 2.4),
        positive("coil_torque_constant_nm_per_a", "N m/A", "of the brake, on the pulley", constants.REFERENCE_BRAKE_TORQUE_CONSTANT_NM_PER_A),
        positive("supply_v", "V", "without load", constants.REFERENCE_SUPPLY_V),
        amount("supply_resistance_ohm", "ohm", "of the supply; it takes no current back", 0.1),
        positive("supply_capacitance_f", "F", "behind that", 2.2e-3),
        positive("supply_divider_ratio", "", "the supply's voltage over what a board with supply_sense_pin measures of it", float(constants.REFERENCE_SUPPLY_SENSE_RATIO)),
        for_hosts(number("ambient_c", "degree C", -100.0, 300.0, "of the air; everything begins there", default=float(constants.REFERENCE_AMBIENT_C))),
        positive("winding_heat_j_per_k", "J/K", "heat capacity of the motor's winding", 12.0),
        positive("winding_to_rotor_k_per_w", "K/W", "from there to the rotor", 4.0),
        positive("rotor_heat_j_per_k", "J/K", "heat capacity of the rotor", 60.0),
        positive("rotor_to_air_k_per_w", "K/W", "from there to the air", 8.0),
        positive("coil_heat_j_per_k", "J/K", "heat capacity of the brake's coil", 40.0),
        positive("coil_to_air_k_per_w", "K/W", "from there to the air", 20.0),
        for_hosts(whole("pwm_steps", "u16", 1, 0xFFFF, "of a bridge's full share", default=1875)),
        for_hosts(number("current_period_s", "s", 0.0, 1e-3, "of the current loop, rounded to a whole part of the control period, which 0 is", default=25e-6)),
        for_hosts(number("output_delay_s", "s", 1e-6, 1e-3, "from a measurement to the voltage that answers it; at most a period of the current loop", default=25e-6)),
        yes_or_no("predictive", "the current loop of the RP2350; off: the one of the RP2040", default=True),
        for_hosts(number("sample_offset_s", "s", 0.0, 1e-5, "from the beginning of a measurement until it takes the current; boards begin 1 us before the middle of the bridge's pulse", default=1e-6)),
        positive("sensor_v_per_a", "V/A", "of the current sensor", constants.REFERENCE_CURRENT_SENSE_V_PER_A),
        for_hosts(number("sensor_zero_v", "V", -10.0, 10.0, "its output without current", default=1.65)),
        amount("sensor_noise_v", "V", "standard deviation", 1e-3),
        positive("sensor_range_v", "V", "of its converter, from 0", 3.3),
        for_hosts(whole("sensor_bits", "u8", 1, 24, "of its converter", default=12)),
        for_hosts(choice("sensor_state", CURRENT_SENSOR, "dead: 0 V; stuck: at its zero; saturated: at the end of its range")),
    ),
)  # fmt: skip

ELECTRICS_STATE = Structure(
    "ElectricsState",
    "True electric values of an emulated knob, now.",
    (
        told("motor_current_a", "double", "positive turns the knob to larger angles"),
        told("coil_current_a", "double", "of the brake"),
        told("supply_v", "double", "at the bridges"),
        told("winding_c", "double", "temperature of the motor's winding"),
        told("rotor_c", "double", "of its rotor"),
        told("coil_c", "double", "of the brake's coil"),
    ),
)

PLANT_PARAMS = Structure(
    "PlantParams",
    "Motor, knob, shaft spring, brake and encoder of an emulated knob. Torques are at the knob.",
    (
        positive(
            "knob_inertia_kg_m2", "kg m^2", "motor and knob", constants.REFERENCE_KNOB_INERTIA_KG_M2
        ),
        amount(
            "knob_viscous_nm_s_per_rad",
            "N m s/rad",
            "viscous friction there",
            constants.REFERENCE_KNOB_VISCOUS_NM_S_PER_RAD,
        ),
        amount("knob_coulomb_nm", "N m", "dry friction there", constants.REFERENCE_KNOB_COULOMB_NM),
        positive(
            "brake_inertia_kg_m2",
            "kg m^2",
            "pulleys and brake",
            constants.REFERENCE_BRAKE_INERTIA_KG_M2,
        ),
        amount("brake_viscous_nm_s_per_rad", "N m s/rad", "viscous friction there", 2e-6),
        amount(
            "brake_drag_nm", "N m", "drag of the released brake", constants.REFERENCE_BRAKE_DRAG_NM
        ),
        amount(
            "shaft_stiffness_nm_per_rad",
            "N m/rad",
            "0: the shaft is cut",
            constants.REFERENCE_SHAFT_STIFFNESS_NM_PER_RAD,
        ),
        amount("shaft_damping_nm_s_per_rad", "N m s/rad", "of the shaft", 2e-4),
        amount(
            "brake_time_constant_s",
            "s",
            "from command to torque; 0: no lag",
            constants.REFERENCE_BRAKE_TIME_CONSTANT_S,
        ),
        amount("motor_time_constant_s", "s", "from command to torque; 0: no lag", MOTOR_LAG_S),
        amount(
            "motor_limit_nm",
            "N m",
            "commands are clipped to it, both ways",
            constants.REFERENCE_MOTOR_TORQUE_MAX_NM,
        ),
        amount(
            "brake_limit_nm",
            "N m",
            "commands are clipped to it",
            constants.REFERENCE_BRAKE_TORQUE_MAX_NM,
        ),
        for_hosts(
            whole(
                "counts_per_rev",
                "u32",
                1,
                1 << 24,
                "of the encoder",
                default=constants.REFERENCE_COUNTS_PER_REV,
            )
        ),
        for_hosts(choice("encoder_rounding", ENCODER_ROUNDING, "how the encoder counts")),
        for_hosts(
            choice(
                "encoder_index",
                INDEX_PULSE,
                "the pulse at the encoder's count 0, for a device with encoder_index_pin",
            )
        ),
        told("encoder_phase_counts", "double", "where in a count angle 0 lies"),
        amount("encoder_noise_counts", "", "standard deviation; 0 leaves the noise out", 0.0),
        yes_or_no(
            "spring_and_brake",
            "part: spring and brake. Without it knob and brake are one rigid body and the brake "
            "never engages. This suits the law motor_only and saves about a third of the plant's "
            "time. All parts below except cogging need it",
            default=True,
        ),
        optional_group("shaft_hardening", SHAFT_HARDENING, "part: the spring has knees"),
        optional_group("brake_hysteresis", BRAKE_HYSTERESIS, "part: play in the brake"),
        optional_group("belt", BELT, "part: the belt stretches"),
        optional_group("cogging", COGGING, "part: the motor cogs"),
        optional_group("electrics", ELECTRICS, "part: windings, bridges, supply, sensor"),
    ),
    notes="The defaults are the reference actuator; docs/explanation/theory.md has the equations. Parts that are "
    "not named cost nothing; the lags of motor and brake are always carried.",
    base="PlantMethods",
)

NO_HAND = Structure("NoHand", "Nobody touches the knob.", (), base="Hand")
TORQUE_HAND = Structure(
    "TorqueHand",
    "A torque on the knob that does not depend on its motion, such as a weight on a string.",
    (
        profile(
            "torque_nm",
            "N m",
            "two knots at the same time make a jump",
            100.0,
            default="{0.0, 0.0}",
        ),
    ),
    base="Hand",
)
IMPEDANCE_HAND = Structure(
    "ImpedanceHand",
    "A hand that holds the knob and means to move it along a path: `torque = stiffness (intended - "
    "angle) + damping (intended' - speed)`, with the hand's own inertia fixed to the knob.",
    (
        amount("inertia_kg_m2", "kg m^2", "of the hand", 0.0, most=10.0),
        amount("stiffness_nm_per_rad", "N m/rad", "of the hand", most=1e6),
        amount("damping_nm_s_per_rad", "N m s/rad", "of the hand", 0.0, most=1e3),
        profile("intended_angle_rad", "rad", "without jumps", 1e9, default="{0.0, 0.0}"),
    ),
    base="Hand",
)
PRESCRIBED_MOTION = Structure(
    "PrescribedMotion",
    "The knob follows the path whatever torque that takes.",
    (profile("angle_rad", "rad", "without jumps", 1e9, default="{0.0, 0.0}"),),
    base="Hand",
)
FEEDBACK_HAND = Structure(
    "FeedbackHand",
    "A hand whose torque is a function of the knob's motion, such as a controller or a person's model.",
    (
        function(
            "torque_nm", "HandFunction", "the torque on the knob; held until it is asked again"
        ),
        for_hosts(number("period_s", "s", 1e-5, 1.0, "from one asking to the next", default=1e-3)),
    ),
    notes="The function is asked when the hand takes over and then once a period. It must not use the "
    "knob that it holds.",
    base="Hand",
)
LINK_FAULTS = Structure(
    "LinkFaults",
    "Damage to reports on the cable of an emulated knob, as probabilities for each report.",
    (
        share("drop_output", "host to device"),
        share("corrupt_output", "a bit of it is another"),
        share("drop_input", "device to host"),
        share("corrupt_input", "a bit of it is another"),
    ),
)
INPUT_KIND = enumeration(
    "InputKind", "Kind of input to an emulated device. In brackets: its bytes; numbers are little "
        "endian.",
    Value("stored", "content of the storage from now on (both slots)"),
    Value("power", "(0 or 1)"),
    Value("connected", "the bus (0 or 1)"),
    Value("output", "a report that has arrived (64 bytes)"),
    Value("feature", "a report (any length)"),
    Value("game_output", "a report of the game interface (any length)"),
    Value("game_feature", "the same (any length)"),
    Value("buttons", "pressed ones (a bit each)"),
    Value("emergency_stop", "(0 or 1)"),
    Value("actuator_fault", "(0 or 1)"),
    Value("power_faults", "which, as bits of the faults; 0: the one of the actuator (32 bits)"),
    Value("missed_ticks", "before the next one (32 bits)"),
    Value("power_cut", "in the next save, after so many bytes (32 bits)"),
    Value("counts", "of the encoder, one control tick for each (32 bits each)"),
    Value("index", "of the encoder (0 or 1)"),
)  # fmt: skip
EMULATED_SERIAL = "EMULATED"
DEVICE_INPUT = Structure(
    "DeviceInput",
    "Something that entered an emulated device, so that it can run again.",
    (
        told("tick", "std::uint64_t", "control ticks that had run before it, since the first power-up"),
        for_hosts(choice("kind", INPUT_KIND, "its kind")),
        binary("bytes", "its content: a report, or as its kind has it; of counts one control tick for each, in 32 bits, little endian"),
    ),
)  # fmt: skip
EMULATOR_OPTIONS = Structure(
    "EmulatorOptions",
    "Options of an emulated knob: parts, hand and records.",
    (
        for_hosts(any_whole("seed", "u64", "of everything random: encoder noise, damaged reports")),
        for_hosts(number("control_rate_hz", "Hz", constants.MIN_CONTROL_RATE_HZ, constants.MAX_CONTROL_RATE_HZ, "ticks in a second", default=1e9 / constants.EMULATED_CONTROL_PERIOD_NS.value)),
        group("plant", PLANT_PARAMS, "its parts"),
        hand("hand", "the hand on it"),
        text("serial", "at most 16 ASCII characters; empty: derived from the device's name"),
        optional_group("actuator", configurations.ACTUATOR_CONFIG, "configuration at power-up; it replaces the stored one and the defaults"),
        optional_group("control", configurations.CONTROL_CONFIG, "the same"),
        optional_group("board", configurations.BOARD_CONFIG, "the same; a plant with electrics has use for it"),
        optional_group("game", configurations.GAME_CONFIG, "the same"),
        optional_group("shaft", configurations.SHAFT_CONFIG, "the same"),
        yes_or_no("paced", "on: real time, as with hardware; off: virtual time, which passes only "
            "inside calls that wait, as fast as the computer can. The same calls with the same "
            "seed give the same bytes"),
        yes_or_no("log_truth", "record what no sensor sees, once a tick"),
        yes_or_no("log_inputs", "record what enters the device, from power-up on, so that it can run again"),
    ),
    checked=True,
)  # fmt: skip
SPIN_UP = Structure(
    "SpinUp",
    "A first phase of a closed loop with the law held off: the motor's torque is prescribed, the brake "
    "is off.",
    (
        replace(for_hosts(number("motor_command_nm", "N m", -_MOST, _MOST, default=None)), rule="positive or negative, not 0"),
        positive("speed_rad_s", "rad/s", "to be reached in the direction of the torque"),
        positive("longest_s", "s", "giving up after", 10.0),
    ),
    notes="It ends when the knob is fast enough. Where that happens becomes angle 0, and when it happens "
    "time 0; the rows begin there.",
)  # fmt: skip
INITIAL_STATE = Structure(
    "InitialState",
    "Where a plant begins, if not at rest at angle 0.",
    (
        for_hosts(number("time_s", "s", 0.0, 1e9, default=0.0)),
        replace(told("revolutions", "std::int64_t", "whole turns, exact however many"), low=-(10**12), high=10**12),
        for_hosts(number("angle_rad", "rad", -1e9, 1e9, "beyond them", default=0.0)),
        for_hosts(number("speed_rad_s", "rad/s", -_MOST, _MOST, "of knob and brake together", default=0.0)),
        for_hosts(number("twist_rad", "rad", -1e9, 1e9, "of the shaft spring: knob minus brake", default=0.0)),
        for_hosts(number("motor_torque_nm", "N m", -_MOST, _MOST, "after the motor's lag", default=0.0)),
        amount("brake_magnetic_nm", "N m", "torque that the brake holds by its current, without its drag", 0.0),
    ),
)  # fmt: skip
BEGINNINGS = (SPIN_UP, INITIAL_STATE)
HAND_FUNCTION = (
    "Time since the hand took over in s, the knob's true angle in rad and its speed in rad/s, to the "
    "torque on the knob in N m, -100 to 100."
)
ENUMERATIONS = (ENCODER_ROUNDING, INDEX_PULSE, CURRENT_SENSOR, INPUT_KIND)
PARTS = (SHAFT_HARDENING, BRAKE_HYSTERESIS, BELT, COGGING, ELECTRICS)
HANDS = (NO_HAND, TORQUE_HAND, IMPEDANCE_HAND, PRESCRIBED_MOTION, FEEDBACK_HAND)
