"""Names of the protocol's numbers, and what to do about them."""

# Printed from the field lists in firmware/protocol/definition/ by `./dev generate`;
# change those instead.

from __future__ import annotations

from typing import Final

__all__ = [
    "FAULT_ADVICE",
    "STATUS_NAMES",
]

STATUS_NAMES: Final = (
    "ok",
    "bad_length",
    "bad_padding",
    "unknown_report",
    "not_finite",
    "out_of_range",
    "inconsistent",
    "bad_axis",
    "empty_slot",
    "not_armed",
    "not_disarmed",
    "fault_latched",
    "fault_persists",
    "stale",
    "busy",
    "not_owner",
    "unsupported",
)
"""Names of the status codes, by code."""

FAULT_ADVICE: Final = {
    "emergency_stop": ("release it, or close its contact to ground, then clear the fault"),
    "over_speed": (
        "look for a scene that is too stiff or too little damped, then clear the fault; the "
        "limit is speed_limit_rad_s of the control configuration"
    ),
    "encoder": ("check the encoder's cable and supply, then clear the fault"),
    "actuator": (
        "check supply, motor cable, temperature, and the current sensor with its wire, then "
        "clear the fault"
    ),
    "overrun": (
        "clear the fault; if it comes back the scene is too much for the board: play fewer effects"
    ),
    "numeric": ("stop, clear the fault, and look for extreme values in scene and configuration"),
    "current_sensor": (
        "check the sensor's supply and wire; then current_sense_v_per_a and "
        "motor_current_max_a of the board configuration: the sensor must see one and a half "
        "times that current"
    ),
    "winding": (
        "check the current sensor, the motor's wires, the supply and the encoder's cable, "
        "then resistance, torque constant and signs in the configuration; clear the fault"
    ),
    "temperature": (
        "let it cool down, then look for an unwanted current; compare "
        "motor_current_continuous_a, brake_continuous_percent and ambient_c of the board "
        "configuration with the parts; clear the fault"
    ),
    "supply": (
        "switch the supply on and measure it; then compare supply_v, supply_sense_ratio and "
        "the divider's wire with the board configuration. A fault while nobody was armed goes"
        " by itself; clear any other"
    ),
}
"""Advice for each fault of the device."""
