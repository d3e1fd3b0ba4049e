"""Values that only the simulation knows, and what it keeps of each tick."""

from __future__ import annotations

from emulator.definition.plant import DEVICE_INPUT, ELECTRICS_STATE
from tools.definition.model import Structure, named, told

_TRUE = (
    told("time_s", "double"),
    told("angle_rad", "double", "of the knob"),
    told("brake_angle_rad", "double", "of the far side of the shaft spring"),
    told("speed_rad_s", "double", "of the knob"),
    told("brake_speed_rad_s", "double"),
    told("spring_torque_nm", "double", "of the shaft spring"),
    told("motor_torque_nm", "double", "after the motor's lag"),
    told("brake_torque_nm", "double", "torque that the brake transmits, drag included"),
    told("brake_capacity_nm", "double", "most that it could transmit, drag included, >= 0"),
    told("hand_torque_nm", "double", "of the hand on the knob"),
    told("knob_friction_torque_nm", "double", "Coulomb friction on the knob"),
)
TRUTH_SAMPLE = Structure(
    "TruthSample",
    "True values of an emulated knob at the start of a control tick. Torques on the knob.",
    (
        told("time_s", "double", "device time"),
        *named(
            _TRUE,
            *("angle_rad", "brake_angle_rad", "speed_rad_s", "spring_torque_nm", "brake_torque_nm"),
            *("brake_capacity_nm", "motor_torque_nm", "hand_torque_nm"),
        ),
    ),
    array_record=True,
)
TOLD = (TRUTH_SAMPLE, ELECTRICS_STATE, DEVICE_INPUT)

_STICKS = (told("knob_sticks", "bool"), told("brake_sticks", "bool"))
PLANT_ROW = Structure(
    "PlantRow",
    "True values of a plant at one moment. Torques on the knob.",
    (*_TRUE, *_STICKS),
    array_record=True,
)
LOOP_ROW = Structure(
    "LoopRow",
    "One control tick: the truth when it samples the encoder, and its decisions then. Torques on "
    "the knob.",
    (
        *_TRUE,
        told("position_counts", "std::int64_t", "measured, from the device's zero"),
        told("estimated_speed_rad_s", "float", "measured"),
        told("desired_torque_nm", "float", "torque that the scene asks for"),
        told("motor_command_nm", "float"),
        told("brake_command_nm", "float"),
        told("sensed_spring_torque_nm", "float", "of the shaft spring, as the soft sensor has it"),
        told("sensed_brake_capacity_nm", "float", "believed capacity of the brake, without drag"),
        *_STICKS,
        told("motor_saturated", "bool"),
        told("brake_saturated", "bool"),
        told("numeric_error", "bool", "the scene's torque was not finite"),
    ),
    array_record=True,
)
REPLAY_ROW = Structure(
    "ReplayRow",
    "Decisions of the controller from a count. Torques on the knob.",
    (
        told("position_counts", "std::int64_t"),
        told("speed_rad_s", "double"),
        told("desired_torque_nm", "double"),
        told("motor_command_nm", "double"),
        told("brake_command_nm", "double"),
        told("spring_torque_nm", "double", "sensed"),
        told("numeric_error", "bool"),
    ),
    array_record=True,
)
ROWS = (PLANT_ROW, LOOP_ROW, REPLAY_ROW)
