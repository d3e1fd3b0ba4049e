"""The device's parts and its control: the reports that are kept in flash."""

from __future__ import annotations

from firmware.protocol.definition import constants
from firmware.protocol.definition import enumerations as e
from firmware.protocol.definition.constants import (
    MAX_DAMPING_NM_S_PER_RAD,
    MAX_STIFFNESS_NM_PER_RAD,
    MAX_TORQUE_NM,
    MOTOR_LAG_S,
)
from firmware.protocol.definition.effects import torque
from tools.definition.model import Field, Structure, choice, number, raw, switch, whole

_HEADER = (
    raw("sequence", "u16", "returned in the acknowledgement"),
    raw("axis", "u8", "0: an interface has one axis"),
)


def _configuration(id: int, name: str, doc: str, notes: str, *fields: Field) -> Structure:
    return Structure(
        name, doc, (*_HEADER, *fields), notes, f"{doc} {notes}", id, "feature"
    )  # fmt: skip


ACTUATOR_CONFIG = _configuration(
    0x04,
    "ActuatorConfig",
    "The actuator as built. The defaults are the reference actuator.",
    "Set only while disarmed; another encoder empties the scene.",
    torque("motor_torque_max_nm", "largest torque of the motor", default=constants.REFERENCE_MOTOR_TORQUE_MAX_NM),
    torque("brake_torque_max_nm", "largest torque of the brake", default=constants.REFERENCE_BRAKE_TORQUE_MAX_NM),
    torque("brake_torque_min_nm", "least brake torque that the sensor assumes", default=constants.REFERENCE_BRAKE_FLOOR_NM),
    torque("brake_drag_nm", "drag of the brake without current", default=constants.REFERENCE_BRAKE_DRAG_NM),
    number("brake_time_constant_s", "s", 0.0, 100.0, "the brake's lag from command to torque", default=constants.REFERENCE_BRAKE_TIME_CONSTANT_S),
    number(
        "spring_stiffness_nm_per_rad", "N m/rad", 0.0, MAX_STIFFNESS_NM_PER_RAD,
        "stiffness of the shaft between knob and brake", default=constants.REFERENCE_SHAFT_STIFFNESS_NM_PER_RAD,
    ),
    whole("counts_per_rev", "u32", 4, 1 << 24, "the encoder's counts in a turn", default=constants.REFERENCE_COUNTS_PER_REV),
    whole(
        "counter_bits", "u8", 8, 32, "width at which the encoder's counter wraps", default=32
    ),
    switch("encoder_reversed", e.TOGGLE, "on: it counts down where the angle grows"),
    number(
        "knob_inertia_kg_m2", "kg m^2", 1e-9, 1.0,
        "inertia of motor and knob; this and the next three bound a game's effects", default=constants.REFERENCE_KNOB_INERTIA_KG_M2,
    ),
    torque("knob_coulomb_nm", "dry friction of motor and knob", default=constants.REFERENCE_KNOB_COULOMB_NM),
    number(
        "knob_viscous_nm_s_per_rad", "N m s/rad", 0.0, MAX_DAMPING_NM_S_PER_RAD,
        "viscous friction of motor and knob", default=constants.REFERENCE_KNOB_VISCOUS_NM_S_PER_RAD,
    ),
    number("motor_time_constant_s", "s", 0.0, 1.0, "the motor's lag from command to torque", default=MOTOR_LAG_S),
    number(
        "brake_inertia_kg_m2", "kg m^2", 0.0, 1.0,
        "inertia of pulleys and brake; 0: not counted. This and the next two are for the law calibrated",
        default=constants.REFERENCE_BRAKE_INERTIA_KG_M2,
    ),
    torque(
        "brake_hysteresis_nm", "half the width of the brake's hysteresis loop",
        default=0.0,
    ),
    number(
        "brake_release_time_constant_s", "s", 0.0, 100.0,
        "the brake's lag while its torque falls; 0: as `brake_time_constant_s`",
    ),
    whole(
        "encoder_index_pin", "u8", 0, 29,
        "GPIO of the encoder's index, one pulse a turn; 0: none. Save it: it takes effect at the next start",
        default=0,
    ),
)  # fmt: skip

CONTROL_CONFIG = _configuration(
    0x05,
    "ControlConfig",
    "How the device controls, and what it does when the host goes silent.",
    "Set only while disarmed.",
    choice("law", e.LAW, "how the desired torque is shared between motor and brake"),
    number("beta", "", 0.0, 1.0, "the brake's share of the desired torque", default=0.5),
    number("speed_bandwidth_hz", "Hz", 1.0, 1e4, "bandwidth of the speed estimate", default=100.0),
    torque(
        "motor_torque_cap_nm", "the user's limit, below the actuator's", default=MAX_TORQUE_NM
    ),
    torque(
        "brake_torque_cap_nm", "the user's limit, below the actuator's", default=MAX_TORQUE_NM
    ),
    number(
        "motor_slew_nm_per_s", "N m/s", 0.0, 1e6,
        "largest rate of the motor's torque; 0 is no limit",
    ),
    number("speed_limit_rad_s", "rad/s", 0.0, 1e4, "a faster knob is a fault; 0: no limit"),
    number("watchdog_s", "s", 0.01, 60.0, "silence of the host after which the knob disarms", default=0.25),
    number(
        "passive_ramp_s", "s", 0.0, 10.0, "time of the motor's torque to zero when the host is lost",
        default=0.05,
    ),
    torque(
        "passive_brake_nm", "the brake's torque during the ramp; 0 releases it", default=0.0
    ),
    switch("autonomous", e.TOGGLE, "on: no watchdog, plays on without a host"),
    torque(
        "free_assist_nm",
        "friction that the motor cancels where the scene asks for nothing, at most three quarters of the "
        "configured friction, for four turns without a rest at most; law calibrated only",
        default=0.0,
    ),
)  # fmt: skip

BOARD_CONFIG = _configuration(
    0x06,
    "BoardConfig",
    "The board's wiring, and the electrical values of motor and brake; docs/how-to/hardware.md.",
    "A pin is the number of its GPIO. Set only while disarmed, then save: it takes effect at the next "
    "start. The emulated device uses it where it has Electrics.",
    number("supply_v", "V", 3.0, 60.0, "voltage of both H-bridges", default=constants.REFERENCE_SUPPLY_V),
    number(
        "motor_torque_constant_nm_per_a", "N m/A", 1e-4, 100.0, "the motor's torque an ampere, at the knob",
        default=constants.REFERENCE_MOTOR_TORQUE_CONSTANT_NM_PER_A,
    ),
    number(
        "motor_current_max_a", "A", 0.0, 100.0,
        "largest current the firmware asks for; a measured current of 1.5 times as much is a fault", default=2.0,
    ),
    number(
        "motor_current_continuous_a", "A", 0.0, 100.0,
        "continuous current of the winding in air of 25 degrees; more is given for seconds only",
        default=1.0,
    ),
    number("motor_resistance_ohm", "ohm", 1e-3, 1e3, "resistance of the winding", default=constants.REFERENCE_MOTOR_RESISTANCE_OHM),
    number("motor_inductance_h", "H", 1e-6, 1.0, "inductance of the winding", default=constants.REFERENCE_MOTOR_INDUCTANCE_H),
    whole(
        "current_bandwidth_hz", "u16", 1, 0xFFFF,
        "of the current loop; on a pico held at a tenth of the control rate",
        default=10_000, unit="Hz",
    ),
    number(
        "current_sense_v_per_a", "V/A", 1e-3, 10.0,
        "of the current sensor; its zero is measured while the power is off", default=constants.REFERENCE_CURRENT_SENSE_V_PER_A,
    ),
    number(
        "brake_torque_constant_nm_per_a", "N m/A", 1e-4, 1e3, "the brake's torque an ampere, on its pulley",
        default=constants.REFERENCE_BRAKE_TORQUE_CONSTANT_NM_PER_A,
    ),
    number("brake_current_max_a", "A", 0.0, 100.0, "largest current of the coil", default=0.3),
    number("brake_resistance_ohm", "ohm", 1e-3, 1e4, "resistance of the coil", default=constants.REFERENCE_BRAKE_RESISTANCE_OHM),
    number(
        "brake_inductance_h", "H", 0.0, 1e3,
        "inductance of the coil. Above 0 the bridge drives the coil both ways, with the actuator's "
        "brake_time_constant_s. 0: the current follows as the coil lets it", default=0.0,
    ),
    switch(
        "motor_reversed", e.TOGGLE,
        "on: a current into the first motor pin turns the knob to smaller angles",
    ),
    switch(
        "confirmed", e.TOGGLE,
        "on: somebody has checked the parts. A real board holds torques and speed low until this is on and "
        "`values_are` is not `assumed`. Acts at once",
    ),
    whole(
        "brake_continuous_percent", "u8", 0, 100,
        "continuous current of the coil in air of 25 degrees, of brake_current_max_a; more is given "
        "for a while only", default=100, unit="%",
    ),
    whole(
        "ambient_c", "u8", 0, 100,
        "highest temperature of the air around motor and brake", default=constants.REFERENCE_AMBIENT_C, unit="degree C",
    ),
    whole(
        "supply_sense_ratio", "u8", 1, 0xFF,
        "of the divider at supply_sense_pin: the supply's voltage over the pin's",
        default=constants.REFERENCE_SUPPLY_SENSE_RATIO,
    ),
    whole("encoder_pin", "u8", 0, 28, "GPIO of A; B is the next one", default=2),
    whole(
        "motor_pin", "u8", 0, 28,
        "GPIO of the first input of the motor's bridge, even; the second is the next one",
        default=6,
    ),
    whole(
        "brake_pin", "u8", 0, 28,
        "GPIO of the first input of the brake's bridge, even; the second is the next one",
        default=8,
    ),
    whole("enable_pin", "u8", 0, 29, "GPIO, high while the power stages are on", default=10),
    whole(
        "emergency_stop_pin", "u8", 0, 29, "GPIO, low to run; an open wire stops", default=11
    ),
    whole(
        "driver_fault_pin", "u8", 0, 29, "GPIO, low when a bridge reports an error", default=12
    ),
    whole("current_sense_pin", "u8", 26, 28, "GPIO of the motor's current sensor", default=26),
    whole(
        "supply_sense_pin", "u8", 0, 28,
        "GPIO of a divider at the supply, 26 to 28; the supply is then watched. 0: none",
    ),
    whole("light_pin", "u8", 0, 29, "GPIO of the status light", default=25),
)  # fmt: skip


def _own(effect: str, doc: str) -> Field:
    return whole(f"own_{effect}_percent", "u8", 0, 100, doc, default=0)


def _gain(effects: str, doc: str) -> Field:
    return whole(f"{effects}_gain_percent", "u8", 0, 100, doc, default=100)


GAME_CONFIG = _configuration(
    0x07,
    "GameConfig",
    "Permissions of games on the game interface, and the scale of their torques; docs/reference/games.md.",
    "Set only while disarmed.",
    switch("enabled", e.TOGGLE, "off: games see the axis but move nothing", default=True),
    number(
        "range_deg", "degree", 10.0, 36000.0,
        "angle from one end of the game's axis to the other, round angle 0", default=900.0,
    ),
    torque(
        "torque_max_nm",
        "torque at full level, and the limit of all effects together; never more than the motor's",
        default=MAX_TORQUE_NM,
    ),
    number("gain", "", 0.0, 1.0, "strength of all games' effects, times their own gains", default=1.0),
    number(
        "spring_gain", "", 0.0, 1000.0,
        "1: a full spring reaches full torque at the end of the axis", default=20.0,
    ),
    number(
        "speed_full_rad_s", "rad/s", 0.1, 1e4,
        "speed at which a full damper reaches full torque", default=20.0,
    ),
    number(
        "acceleration_full_rad_s2", "rad/s^2", 1.0, 1e7,
        "acceleration at which a full inertia reaches full torque", default=3000.0,
    ),
    number(
        "blend_s", "s", 0.0, 0.1,
        "in which a change of an effect, its beginning or its end takes full effect", default=2e-3,
    ),
    number(
        "silence_s", "s", 0.0, 3600.0,
        "silence of the game after which forces without end stop; 0: never", default=10.0,
    ),
    switch(
        "join_updates", e.TOGGLE,
        "on: updates of a steady force are joined by lines, half a frame of the game late; hits pass",
        default=True,
    ),
    number(
        "end_stiffness_nm_per_rad", "N m/rad", 0.0, MAX_STIFFNESS_NM_PER_RAD,
        "stiffness of walls at both ends of the axis, while a game has the actuator; 0: none", default=0.0,
    ),
    choice(
        "personality", e.PERSONALITY,
        "the computer's view of the knob; save it: it takes effect at the next start",
    ),
    choice("dial_use", e.DIAL_USE, "use of a dial"),
    whole("dial_detents", "u8", 1, 240, "detents of a dial in a turn", default=24),
    torque(
        "dial_torque_nm",
        "torque between two detents of a dial, held down to a stable one; 0: it turns freely",
        default=20e-3,
    ),
    _own("damper", "share of a full damper, always felt while somebody turns the knob, with a game and without"),
    _own("friction", "share of full torque as friction, always felt, with a game and without"),
    _own("inertia", "share of a full inertia, always felt, with a game and without"),
    _own("spring", "share of a full spring to the middle, while no game plays"),
    _gain("constants", "strength of games' constant forces and ramps"),
    _gain("waves", "strength of games' waves"),
    _gain("springs", "strength of games' springs"),
    _gain("dampers", "strength of games' dampers"),
    _gain("inertias", "strength of games' inertias"),
    _gain("frictions", "strength of games' frictions"),
    whole(
        "torque_max_percent", "u8", 1, 100,
        "share of the motor's torque that all effects together get at most; the smaller of this and `torque_max_nm` counts",
        default=100,
    ),
    switch("reversed", e.TOGGLE, "on: axis, games' forces and the dial go the other way", default=False),
    switch("dial_coarse", e.TOGGLE, "on: a dial tells whole detents, although the host asks for fine ones", default=False),
    whole(
        "dial_fast_steps", "u8", 1, 20,
        "steps of a wheel for a detent that is turned at two turns a second or faster; in proportion below, down to one",
        default=1,
    ),
    switch("remote_wakeup", e.TOGGLE, "on: turning or pressing wakes a host that sleeps, if it lets; from the next start on", default=False),
)  # fmt: skip


def _knee(number_: int, place: str) -> tuple[Field, Field]:
    return (
        number(f"knee_{number_}_rad", "rad", 0.0, 100.0, place),
        number(
            f"knee_{number_}_nm_per_rad", "N m/rad", 0.0, MAX_STIFFNESS_NM_PER_RAD,
            "stiffness beyond this knee; more than 0, so that the torque always grows",
        ),
    )  # fmt: skip


SHAFT_CONFIG = _configuration(
    0x0A,
    "ShaftConfig",
    "The curve of the shaft's spring beyond its first straight piece. Up to the first knee the stiffness "
    "is the actuator's `spring_stiffness_nm_per_rad`. Both directions are alike.",
    "Set only while disarmed.",
    *_knee(1, "twist of the first knee; 0: the spring is one straight line"),
    *_knee(2, "twist of the second knee, beyond the first; 0: none"),
    *_knee(3, "twist of the third knee"),
    *_knee(4, "twist of the fourth knee"),
)


def _sigma(field: str, unit: str) -> Field:
    return number(f"sigma_{field}", unit, 0.0, 1e6, f"of `{field}`")


def _permille(field: str, of: str) -> Field:
    doc = f"standard uncertainty of the board's `{of}` in thousandths of it; 0: it was not measured"
    return whole(f"sigma_{field}_permille", "u8", 0, 255, doc)


CALIBRATION_CONFIG = _configuration(
    0x0B,
    "CalibrationConfig",
    "How well the values of actuator and shaft are known, and since when. It belongs to the values that "
    "the device has when it takes this report. When one of them changes, `values_are` reads `assumed`. A "
    "`sigma` is the standard uncertainty of a value; 0: it was not measured.",
    "Set only while disarmed.",
    choice("values_are", e.BASIS, "source of the values of actuator and shaft"),
    whole(
        "calibrated_unix_s", "u32", 0, 2**32 - 1,
        "time of the measurement, in seconds since 1970; 0: never",
    ),
    number(
        "ambient_k", "K", 0.0, 1000.0,
        "the room's temperature, as the user gave it; 0: not given",
    ),
    number("calibrated_rate_hz", "Hz", 0.0, 1e6, "control rate of the measurement"),
    _sigma("knob_inertia_kg_m2", "kg m^2"),
    _sigma("knob_coulomb_nm", "N m"),
    _sigma("knob_viscous_nm_s_per_rad", "N m s/rad"),
    _sigma("spring_stiffness_nm_per_rad", "N m/rad"),
    _sigma("knee_1_rad", "rad"),
    _sigma("knee_1_nm_per_rad", "N m/rad"),
    _sigma("brake_drag_nm", "N m"),
    _sigma("brake_time_constant_s", "s"),
    _sigma("brake_release_time_constant_s", "s"),
    _sigma("brake_inertia_kg_m2", "kg m^2"),
    _sigma("brake_hysteresis_nm", "N m"),
    _permille("motor_resistance", "motor_resistance_ohm"),
    _permille("motor_inductance", "motor_inductance_h"),
    _permille("motor_torque_constant", "motor_torque_constant_nm_per_a"),
)  # fmt: skip

CONFIGURATIONS = (
    ACTUATOR_CONFIG, CONTROL_CONFIG, BOARD_CONFIG, GAME_CONFIG, SHAFT_CONFIG, CALIBRATION_CONFIG,
)  # fmt: skip
# Their fields must go together, as firmware/device/config.cpp and sdk/conversion/configuration.cpp say.
WITH_RULES = (ACTUATOR_CONFIG, SHAFT_CONFIG)
