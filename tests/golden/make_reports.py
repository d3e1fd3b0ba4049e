"""Write ``reports.json``: reports as values and as bytes, made without any code of the product.

The values differ from field to field and byte to byte, so that two fields swapped, a byte order
reversed or an offset slipped cannot cancel out. Every float is exact in 32 bits.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from tests.python import wire

TARGET = {"sequence": 0x1234, "axis": 0, "slot": 7}
TIMING = {
    "delay_s": 0.125,
    "duration_s": 2.5,
    "attack_level": 0.25,
    "attack_s": 0.0625,
    "fade_level": 0.75,
    "fade_s": 0.5,
}
LAST = {"sequence": 0xFFFF, "axis": 0, "slot": 15}
LONG = {
    "delay_s": 0.0,
    "duration_s": 100000.0,
    "attack_level": 0.0,
    "attack_s": 100000.0,
    "fade_level": 1.0,
    "fade_s": 0.0,
}


def _sample(start: int) -> dict[str, int]:
    names = (
        *("offset_counts", "speed", "desired_torque"),
        *("motor_command", "brake_capacity", "spring_torque"),
    )
    return {name: start + 257 * n for n, name in enumerate(names)}


CASES: list[tuple[str, dict[str, Any]]] = [
    (
        "identity",
        {
            "fingerprint": 0x89ABCDEF,
            "version": 0x0102,
            "firmware_version": [1, 20, 255],
            "board": 2,
            "serial": [*b"TS-0042", *[0] * 9],
            "axes": 1,
            "effects": 16,
            "curve_points": 1024,
            "control_period_ns": 50000,
            "counts_per_rev": 32768,
            "torque_step_nm": 2.0**-16,
            "speed_step_rad_s": 2.0**-7,
        },
    ),
    (
        "clock",
        {
            "tick": 0x0102030405060708,
            "time_ns": 0x31E2D3C4B5A69788,
            "position_counts": -0x1122334455667788,
        },
    ),
    (
        "health",
        {
            "state": "fault",
            "faults": 0x2103,
            "reports_accepted": 0x01020304,
            "reports_refused": 0x11121314,
            "samples_dropped": 0x21222324,
            "tick_overruns": 0x31323334,
            "tick_time_ns": 0x41424344,
            "tick_time_max_ns": 0x51525354,
            "saves": 0xF1F2F3F4,
            "owner": "game",
            "reset_cause": "stack",
        },
    ),
    (
        "actuator_config",
        {
            "sequence": 0xABCD,
            "axis": 0,
            "motor_torque_max_nm": 0.0625,
            "brake_torque_max_nm": 0.125,
            "brake_torque_min_nm": 0.00390625,
            "brake_drag_nm": 0.001953125,
            "brake_time_constant_s": 0.05078125,
            "spring_stiffness_nm_per_rad": 2.875,
            "counts_per_rev": 16777216,
            "counter_bits": 24,
            "encoder_reversed": "on",
            "knob_inertia_kg_m2": 2.0**-14,
            "knob_coulomb_nm": 2.0**-7,
            "knob_viscous_nm_s_per_rad": 2.0**-15,
            "motor_time_constant_s": 2.0**-13,
            "brake_inertia_kg_m2": 2.0**-16,
            "brake_hysteresis_nm": 2.0**-8,
            "brake_release_time_constant_s": 2.0**-6,
        },
    ),
    (
        "control_config",
        {
            "sequence": 0x00FF,
            "axis": 0,
            "law": "parallel",
            "beta": 0.75,
            "speed_bandwidth_hz": 150.5,
            "motor_torque_cap_nm": 0.03125,
            "brake_torque_cap_nm": 0.046875,
            "motor_slew_nm_per_s": 12.5,
            "speed_limit_rad_s": 90.25,
            "watchdog_s": 0.375,
            "passive_ramp_s": 0.015625,
            "passive_brake_nm": 0.0078125,
            "autonomous": "on",
            "free_assist_nm": 2.0**-9,
        },
    ),
    (
        "board_config",
        {
            "sequence": 0x0102,
            "axis": 0,
            "supply_v": 24.5,
            "motor_torque_constant_nm_per_a": 0.0625,
            "motor_current_max_a": 3.25,
            "motor_current_continuous_a": 1.375,
            "motor_resistance_ohm": 1.75,
            "motor_inductance_h": 0.0009765625,
            "current_bandwidth_hz": 800,
            "current_sense_v_per_a": 0.1875,
            "brake_torque_constant_nm_per_a": 0.40625,
            "brake_current_max_a": 0.28125,
            "brake_resistance_ohm": 41.5,
            "brake_inductance_h": 2.5,
            "motor_reversed": "on",
            "confirmed": "on",
            "brake_continuous_percent": 85,
            "ambient_c": 45,
            "supply_sense_ratio": 16,
            "encoder_pin": 3,
            "motor_pin": 14,
            "brake_pin": 20,
            "enable_pin": 5,
            "emergency_stop_pin": 6,
            "driver_fault_pin": 7,
            "current_sense_pin": 28,
            "supply_sense_pin": 27,
            "light_pin": 22,
        },
    ),
    (
        "game_config",
        {
            "sequence": 0x0304,
            "axis": 0,
            "enabled": "off",
            "range_deg": 1080.5,
            "torque_max_nm": 0.0703125,
            "gain": 0.625,
            "spring_gain": 4.25,
            "speed_full_rad_s": 31.5,
            "acceleration_full_rad_s2": 2500.5,
            "blend_s": 0.00390625,
            "silence_s": 12.5,
            "join_updates": "off",
            "end_stiffness_nm_per_rad": 5.75,
            "personality": "dial",
            "dial_use": "volume",
            "dial_detents": 36,
            "dial_torque_nm": 0.01171875,
        },
    ),
    (
        "shaft_config",
        {
            "sequence": 0x0405,
            "axis": 0,
            "knee_1_rad": 2.0**-6,
            "knee_1_nm_per_rad": 5.75,
            "knee_2_rad": 2.0**-5,
            "knee_2_nm_per_rad": 1.5,
            "knee_3_rad": 2.0**-4,
            "knee_3_nm_per_rad": 12.25,
            "knee_4_rad": 2.0**-3,
            "knee_4_nm_per_rad": 20.5,
        },
    ),
    (
        "calibration_config",
        {
            "sequence": 0x0506,
            "axis": 0,
            "values_are": "measured",
            "calibrated_unix_s": 0x6A1B2C3D,
            "ambient_k": 294.5,
            "calibrated_rate_hz": 20000.0,
            "sigma_knob_inertia_kg_m2": 2.0**-22,
            "sigma_knob_coulomb_nm": 2.0**-16,
            "sigma_knob_viscous_nm_s_per_rad": 2.0**-24,
            "sigma_spring_stiffness_nm_per_rad": 2.0**-9,
            "sigma_knee_1_rad": 2.0**-14,
            "sigma_knee_1_nm_per_rad": 2.0**-8,
            "sigma_brake_drag_nm": 2.0**-17,
            "sigma_brake_time_constant_s": 2.0**-13,
            "sigma_brake_release_time_constant_s": 2.0**-12,
            "sigma_brake_inertia_kg_m2": 2.0**-21,
            "sigma_brake_hysteresis_nm": 2.0**-15,
            "sigma_motor_resistance_permille": 6,
            "sigma_motor_inductance_permille": 0xFE,
            "sigma_motor_torque_constant_permille": 3,
        },
    ),
    (
        "ledger",
        {
            "tick": 0x0A0B0C0D0E0F1011,
            "kept": "on",
            "motor": -0x1213141516171819,
            "spring_twice": 0x2223242526272829,
            "spring": -0x32333435,
            "stored_j": 2.0**-11,
            "bound_nm_per_rad": 66.5,
        },
    ),
    (
        "motor_current",
        {
            "measured": "on",
            "position_counts": -0x0112233445566778,
            "period_ns": 0x0000A1A2,
            "delay_ns": 0x0000B1B2,
            "periods": 0x0203040506070809,
            "reading_sum": -0x1213141516171819,
            "share_sum": 0x2223242526272829,
            "reading": 0x00C1C2C3,
            "share": -0x3132,
            "share_before": 0x2A2B,
            "zero": 2047.75,
            "a_per_step": -(2.0**-8),
            "a_per_nm": 20.25,
        },
    ),
    (
        "game_monitor",
        {
            "tick": 0x0807060504030201,
            "owner": "game",
            "paused": "on",
            "enabled": "off",
            "gain": 0x7FFE,
            "torque": -0x1234,
            "updates": 0xA1A2A3A4,
            "effects": 40,
            "effect": [
                {
                    "block": 39,
                    "kind": "friction",
                    "state": "set_aside",
                    "torque": -2,
                    "updates": 0xB1B2B3B4,
                    "silent_ms": 0xC1C2,
                },
                {
                    "block": 40,
                    "kind": "ramp",
                    "state": "playing",
                    "torque": 0x7ABC,
                    "updates": 1,
                    "silent_ms": 0xFFFF,
                },
                {
                    "block": 0,
                    "kind": "none",
                    "state": "stopped",
                    "torque": 0,
                    "updates": 0,
                    "silent_ms": 0,
                },
            ],
        },
    ),
    ("command", {"sequence": 0x1234, "axis": 0, "op": "bootloader"}),
    ("command", {"sequence": 0, "axis": 255, "op": "arm"}),
    ("commit", {"sequence": 0x8001, "axis": 0, "active": 0x8102}),
    ("stream", {"sequence": 0x0203, "axis": 0, "decimation": 20, "prompt": "on"}),
    (
        "local_model",
        {
            "sequence": 0xFEDC,
            "axis": 0,
            "torque_nm": -0.0625,
            "angle_turns_q32": -(2**58),
            "stiffness_nm_per_rad": 1000000.0,
            "damping_nm_s_per_rad": 0.0009765625,
            "deadline_s": 0.03125,
        },
    ),
    (
        "excitation",
        {
            "sequence": 0xBA98,
            "axis": 0,
            "duration_s": 1.5,
            "travel_rad": 12.5,
            "speed_limit_rad_s": 90.0,
            "torque_limit_nm": 0.0625,
            "motor_command_nm": -0.03125,
            "brake_command_nm": 0.046875,
            "ramp_s": 0.25,
            "sine_nm": 0.0078125,
            "sine_begin_hz": 20.0,
            "sine_end_hz": 60.0,
            "stiffness_nm_per_rad": 0.5625,
            "damping_nm_s_per_rad": 0.001953125,
            "servo_rad_s": -2.5,
        },
    ),
    (
        "wall",
        {
            "target": TARGET,
            "angle_turns_q32": 0x0002000380000001,
            "side": "below",
            "stiffness_nm_per_rad": 1.4375,
            "damping_nm_s_per_rad": 0.001953125,
        },
    ),
    (
        "wall",
        {
            "target": LAST,
            "angle_turns_q32": -1,
            "side": "above",
            "stiffness_nm_per_rad": 0.0,
            "damping_nm_s_per_rad": 1000.0,
        },
    ),
    (
        "spring",
        {
            "target": TARGET,
            "angle_turns_q32": -0x0000000123456789,
            "stiffness_nm_per_rad": 0.5625,
            "deadband_rad": 0.03125,
            "torque_limit_nm": 0.046875,
        },
    ),
    ("damper", {"target": TARGET, "damping_nm_s_per_rad": 0.0078125, "torque_limit_nm": 0.0625}),
    ("friction", {"target": TARGET, "torque_nm": 0.0234375, "stiffness_nm_per_rad": 2.25}),
    ("inertia", {"target": TARGET, "inertia_kg_m2": 2.0**-14, "torque_limit_nm": 0.03125}),
    ("constant", {"target": TARGET, "torque_nm": -0.046875, "timing": TIMING}),
    (
        "ramp",
        {
            "target": TARGET,
            "start_torque_nm": -0.0625,
            "end_torque_nm": 0.03125,
            "timing": TIMING,
        },
    ),
    (
        "periodic",
        {
            "target": TARGET,
            "waveform": "sawtooth_down",
            "amplitude_nm": 0.0234375,
            "offset_nm": -0.0078125,
            "frequency_hz": 12.5,
            "phase_turns": 0.625,
            "timing": TIMING,
        },
    ),
    (
        "periodic",
        {
            "target": LAST,
            "waveform": "square",
            "amplitude_nm": 100.0,
            "offset_nm": 100.0,
            "frequency_hz": 10000.0,
            "phase_turns": 1.0,
            "timing": LONG,
        },
    ),
    (
        "detents",
        {
            "target": TARGET,
            "angle_turns_q32": 0x0000000040000001,
            "per_turn_q32": 0x00000018C0000003,
            "torque_nm": 0.01953125,
            "profile": "click",
            "width": 0.375,
        },
    ),
    (
        "end_stops",
        {
            "target": TARGET,
            "lower_turns_q32": -0x0000000280000003,
            "upper_turns_q32": 0x0000000340000005,
            "stiffness_nm_per_rad": 1.125,
            "damping_nm_s_per_rad": 0.00390625,
        },
    ),
    (
        "texture",
        {
            "target": TARGET,
            "grains_per_turn": 0x0123,
            "torque_nm": 0.01171875,
            "grain": "noise",
            "seed": 0x89ABCDEF,
        },
    ),
    (
        "curve",
        {
            "target": TARGET,
            "angle_turns_q32": -0x0000000060000007,
            "span_turns_q32": 0x2222111100,
            "ends": "repeat",
            "first_point": 0x0102,
            "points": 0x0203,
        },
    ),
    (
        "impact",
        {
            "target": TARGET,
            "angle_turns_q32": -0x0000000123456789,
            "side": "below",
            "strength_nm_s_per_rad": 0.015625,
            "frequency_hz": 312.5,
            "decay_s": 0.00390625,
            "pulse_nm_s_per_rad": 0.03125,
            "pulse_s": 0.0078125,
            "torque_limit_nm": 0.75,
        },
    ),
    (
        "curve_points",
        {
            "sequence": 0x0304,
            "axis": 0,
            "first_point": 0x0203,
            "points": 13,
            "torque_nm": [(n - 6) * 0.0078125 for n in range(13)],
        },
    ),
    (
        "telemetry",
        {
            "axis_samples": 0x40,
            "decimation": 5,
            "flags": 0x35,
            "tick": 0x1112131415161718,
            "base_counts": -0x01020304,
            "sample": [_sample(start) for start in (-32768, -1500, 4660, 31482)],
        },
    ),
    (
        "acknowledgement",
        {
            "sequence": 0xBEEF,
            "report": 0x27,
            "status": 5,
            "field": 9,
            "state": "armed",
            "tick": 0x2122232425262728,
            "owner": "sdk",
        },
    ),
    (
        "event",
        {
            "kind": "deadline_missed",
            "state": "fault",
            "faults": 0x0021,
            "tick": 0xF122232425262728,
            "owner": "game",
        },
    ),
]


def reports_json() -> str:
    """Give the text of the golden file."""
    rows = [
        {
            "report": name,
            "id": wire.REPORTS[name].id,
            "values": values,
            "hex": wire.encode(name, values).hex(),
        }
        for name, values in CASES
    ]
    return "[\n" + ",\n".join("  " + json.dumps(row) for row in rows) + "\n]\n"


if __name__ == "__main__":
    Path(sys.argv[1] if len(sys.argv) > 1 else "tests/golden/reports.json").write_text(
        reports_json()
    )
