"""Measurements of the device and true values of the emulator, as NumPy structured arrays.

Records are arrays of shape (n_samples,) with the columns below: ``log["angle_rad"]`` is an array of
angles, ``log[0]`` the first sample. Padding bytes are zero.
"""

# Printed from the field lists in firmware/protocol/definition/ by `./dev generate`;
# change those instead.

from __future__ import annotations

from typing import Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = [
    "FLAG_BOUNDED",
    "FLAG_BRAKE_SATURATED",
    "FLAG_GAME",
    "FLAG_LOCAL_MODEL",
    "FLAG_MOTOR_SATURATED",
    "FLAG_PASSIVE",
    "FLAG_STATE_MASK",
    "LOOP_DTYPE",
    "PLANT_DTYPE",
    "TELEMETRY_DTYPE",
    "TRUTH_DTYPE",
    "Record",
]

Record: TypeAlias = npt.NDArray[np.void]
"""A structured array."""

TELEMETRY_DTYPE: Final[np.dtype[Any]] = np.dtype(
    [
        ("tick", "<u8"),  # control periods since power-up
        ("time_s", "<f8"),  # tick times the control period
        ("position_counts", "<i8"),  # from the device's zero, never wraps
        ("angle_rad", "<f8"),  # the same as an angle
        ("speed_rad_s", "<f4"),  # estimated
        ("desired_torque_nm", "<f4"),  # torque that the scene asks for
        ("motor_command_nm", "<f4"),  # asked of the motor
        ("brake_capacity_nm", "<f4"),  # most that the brake can hold, estimated
        ("spring_torque_nm", "<f4"),  # of the shaft on the knob, sensed
        ("flags", "u1"),  # of this sample or a neighbour in the same report
    ],
    align=True,
)
"""One moment of the control loop. Torques are on the knob."""

TRUTH_DTYPE: Final[np.dtype[Any]] = np.dtype(
    [
        ("time_s", "<f8"),  # device time
        ("angle_rad", "<f8"),  # of the knob
        ("brake_angle_rad", "<f8"),  # of the far side of the shaft spring
        ("speed_rad_s", "<f8"),  # of the knob
        ("spring_torque_nm", "<f8"),  # of the shaft spring
        ("brake_torque_nm", "<f8"),  # torque that the brake transmits, drag included
        ("brake_capacity_nm", "<f8"),  # most that it could transmit, drag included, >= 0
        ("motor_torque_nm", "<f8"),  # after the motor's lag
        ("hand_torque_nm", "<f8"),  # of the hand on the knob
    ],
    align=True,
)
"""True values of an emulated knob at the start of a control tick. Torques on the knob."""

PLANT_DTYPE: Final[np.dtype[Any]] = np.dtype(
    [
        ("time_s", "<f8"),
        ("angle_rad", "<f8"),  # of the knob
        ("brake_angle_rad", "<f8"),  # of the far side of the shaft spring
        ("speed_rad_s", "<f8"),  # of the knob
        ("brake_speed_rad_s", "<f8"),
        ("spring_torque_nm", "<f8"),  # of the shaft spring
        ("motor_torque_nm", "<f8"),  # after the motor's lag
        ("brake_torque_nm", "<f8"),  # torque that the brake transmits, drag included
        ("brake_capacity_nm", "<f8"),  # most that it could transmit, drag included, >= 0
        ("hand_torque_nm", "<f8"),  # of the hand on the knob
        ("knob_friction_torque_nm", "<f8"),  # Coulomb friction on the knob
        ("knob_sticks", "?"),
        ("brake_sticks", "?"),
    ],
    align=True,
)
"""True values of a plant at one moment. Torques on the knob."""

LOOP_DTYPE: Final[np.dtype[Any]] = np.dtype(
    [
        ("time_s", "<f8"),
        ("angle_rad", "<f8"),  # of the knob
        ("brake_angle_rad", "<f8"),  # of the far side of the shaft spring
        ("speed_rad_s", "<f8"),  # of the knob
        ("brake_speed_rad_s", "<f8"),
        ("spring_torque_nm", "<f8"),  # of the shaft spring
        ("motor_torque_nm", "<f8"),  # after the motor's lag
        ("brake_torque_nm", "<f8"),  # torque that the brake transmits, drag included
        ("brake_capacity_nm", "<f8"),  # most that it could transmit, drag included, >= 0
        ("hand_torque_nm", "<f8"),  # of the hand on the knob
        ("knob_friction_torque_nm", "<f8"),  # Coulomb friction on the knob
        ("position_counts", "<i8"),  # measured, from the device's zero
        ("estimated_speed_rad_s", "<f4"),  # measured
        ("desired_torque_nm", "<f4"),  # torque that the scene asks for
        ("motor_command_nm", "<f4"),
        ("brake_command_nm", "<f4"),
        ("sensed_spring_torque_nm", "<f4"),  # of the shaft spring, as the soft sensor has it
        ("sensed_brake_capacity_nm", "<f4"),  # believed capacity of the brake, without drag
        ("knob_sticks", "?"),
        ("brake_sticks", "?"),
        ("motor_saturated", "?"),
        ("brake_saturated", "?"),
        ("numeric_error", "?"),  # the scene's torque was not finite
    ],
    align=True,
)
"""One control tick: the truth when it samples the encoder, and its decisions then. Torques on the
knob."""

FLAG_STATE_MASK: Final = 0x03
"""The two lowest bits: 0 disarmed, 1 armed, 2 fault."""
FLAG_MOTOR_SATURATED: Final = 1 << 2
"""The motor gives all it can."""
FLAG_BRAKE_SATURATED: Final = 1 << 3
"""The brake holds all it can."""
FLAG_LOCAL_MODEL: Final = 1 << 4
"""A streamed local model is in force."""
FLAG_PASSIVE: Final = 1 << 5
"""Fading out after silence or a deadline."""
FLAG_GAME: Final = 1 << 6
"""A game has the actuator."""
FLAG_BOUNDED: Final = 1 << 7
"""Less than the scene asks, so that the knob does not buzz."""
