"""Every report, read and written with ``struct`` alone.

This is a second opinion on the protocol: written by hand from its documentation, sharing nothing
with the C++ field lists. Format characters are ``struct``'s; little endian, no padding.
"""

from __future__ import annotations

import itertools
import struct
from dataclasses import dataclass
from typing import Any

REPORT_SIZE = 64
USB_VENDOR_ID, USB_PRODUCT_ID = 0x1209, 0x0001
USB_ID = "1209:0001"

Values = dict[str, Any]

_TARGET = "H target.sequence, B target.axis, B target.slot"
_TIMING = (
    "f timing.delay_s, f timing.duration_s, f timing.attack_level, f timing.attack_s, "
    "f timing.fade_level, f timing.fade_s"
)
_SAMPLES = ", ".join(
    f"h sample.{n}.offset_counts, h sample.{n}.speed, h sample.{n}.desired_torque, "
    f"h sample.{n}.motor_command, h sample.{n}.brake_capacity, h sample.{n}.spring_torque"
    for n in range(4)
)
_GAME_EFFECTS = ", ".join(
    f"B effect.{n}.block, B effect.{n}.kind, B effect.{n}.state, h effect.{n}.torque, "
    f"I effect.{n}.updates, H effect.{n}.silent_ms"
    for n in range(3)
)


@dataclass(frozen=True)
class Report:
    """One report: its id and the format and path of each field, in wire order."""

    name: str
    id: int
    formats: tuple[str, ...]
    paths: tuple[str, ...]

    @property
    def format(self) -> str:
        return "<B" + "".join(self.formats)


def _report(name: str, report_id: int, fields: str) -> Report:
    pairs = [field.split() for field in fields.split(",")]
    return Report(name, report_id, tuple(p[0] for p in pairs), tuple(p[1] for p in pairs))


REPORTS = {
    report.name: report
    for report in (
        _report(
            "identity",
            0x01,
            "I fingerprint, H version, 3B firmware_version, B board, 16B serial, B axes, "
            "B effects, H curve_points, I control_period_ns, I counts_per_rev, f torque_step_nm, "
            "f speed_step_rad_s",
        ),
        _report("clock", 0x02, "Q tick, Q time_ns, q position_counts"),
        _report(
            "health",
            0x03,
            "B state, H faults, I reports_accepted, I reports_refused, I samples_dropped, "
            "I tick_overruns, I tick_time_ns, I tick_time_max_ns, I saves, B owner, B reset_cause, "
            "I unexpected_swings, B centre",
        ),
        _report(
            "actuator_config",
            0x04,
            "H sequence, B axis, f motor_torque_max_nm, f brake_torque_max_nm, "
            "f brake_torque_min_nm, f brake_drag_nm, f brake_time_constant_s, "
            "f spring_stiffness_nm_per_rad, I counts_per_rev, B counter_bits, B encoder_reversed, "
            "f knob_inertia_kg_m2, f knob_coulomb_nm, f knob_viscous_nm_s_per_rad, "
            "f motor_time_constant_s, f brake_inertia_kg_m2, f brake_hysteresis_nm, "
            "f brake_release_time_constant_s, "
            "B encoder_index_pin",
        ),
        _report(
            "control_config",
            0x05,
            "H sequence, B axis, B law, f beta, f speed_bandwidth_hz, f motor_torque_cap_nm, "
            "f brake_torque_cap_nm, f motor_slew_nm_per_s, f speed_limit_rad_s, f watchdog_s, "
            "f passive_ramp_s, f passive_brake_nm, B autonomous, f free_assist_nm",
        ),
        _report(
            "board_config",
            0x06,
            "H sequence, B axis, f supply_v, f motor_torque_constant_nm_per_a, "
            "f motor_current_max_a, f motor_current_continuous_a, f motor_resistance_ohm, "
            "f motor_inductance_h, "
            "H current_bandwidth_hz, f current_sense_v_per_a, f brake_torque_constant_nm_per_a, "
            "f brake_current_max_a, f brake_resistance_ohm, f brake_inductance_h, "
            "B motor_reversed, B confirmed, B brake_continuous_percent, B ambient_c, "
            "B supply_sense_ratio, B encoder_pin, B motor_pin, B brake_pin, B enable_pin, "
            "B emergency_stop_pin, B driver_fault_pin, B current_sense_pin, B supply_sense_pin, "
            "B light_pin",
        ),
        _report(
            "game_config",
            0x07,
            "H sequence, B axis, B enabled, f range_deg, f torque_max_nm, f gain, f spring_gain, "
            "f speed_full_rad_s, f acceleration_full_rad_s2, f blend_s, f silence_s, "
            "B join_updates, f end_stiffness_nm_per_rad, B personality, B dial_use, "
            "B dial_detents, f dial_torque_nm, B own_damper_percent, B own_friction_percent, "
            "B own_inertia_percent, B own_spring_percent, B constants_gain_percent, "
            "B waves_gain_percent, B springs_gain_percent, B dampers_gain_percent, "
            "B inertias_gain_percent, B frictions_gain_percent, B torque_max_percent, "
            "B reversed, B dial_coarse, B dial_fast_steps, B remote_wakeup",
        ),
        _report(
            "game_monitor",
            0x08,
            "Q tick, B owner, B paused, B enabled, H gain, h torque, I updates, B effects, "
            "I clipped_ticks, H asked_percent, " + _GAME_EFFECTS,
        ),
        _report(
            "ledger",
            0x09,
            "Q tick, B kept, q motor, q spring_twice, i spring, f stored_j, f bound_nm_per_rad",
        ),
        _report(
            "motor_current",
            0x0C,
            "B measured, q position_counts, I period_ns, I delay_ns, Q periods, q reading_sum, "
            "q share_sum, i reading, h share, h share_before, f zero, f a_per_step, f a_per_nm",
        ),
        _report(
            "shaft_config",
            0x0A,
            "H sequence, B axis, f knee_1_rad, f knee_1_nm_per_rad, f knee_2_rad, "
            "f knee_2_nm_per_rad, f knee_3_rad, f knee_3_nm_per_rad, f knee_4_rad, "
            "f knee_4_nm_per_rad",
        ),
        _report(
            "calibration_config",
            0x0B,
            "H sequence, B axis, B values_are, I calibrated_unix_s, f ambient_k, "
            "f calibrated_rate_hz, f sigma_knob_inertia_kg_m2, f sigma_knob_coulomb_nm, "
            "f sigma_knob_viscous_nm_s_per_rad, f sigma_spring_stiffness_nm_per_rad, "
            "f sigma_knee_1_rad, f sigma_knee_1_nm_per_rad, f sigma_brake_drag_nm, "
            "f sigma_brake_time_constant_s, f sigma_brake_release_time_constant_s, "
            "f sigma_brake_inertia_kg_m2, f sigma_brake_hysteresis_nm, "
            "B sigma_motor_resistance_permille, B sigma_motor_inductance_permille, "
            "B sigma_motor_torque_constant_permille",
        ),
        _report("command", 0x10, "H sequence, B axis, B op"),
        _report("commit", 0x11, "H sequence, B axis, H active"),
        _report("stream", 0x12, "H sequence, B axis, B decimation, B prompt"),
        _report(
            "local_model",
            0x13,
            "H sequence, B axis, f torque_nm, q angle_turns_q32, f stiffness_nm_per_rad, "
            "f damping_nm_s_per_rad, f deadline_s",
        ),
        _report(
            "excitation",
            0x14,
            "H sequence, B axis, f duration_s, f travel_rad, f speed_limit_rad_s, "
            "f torque_limit_nm, f motor_command_nm, f brake_command_nm, f ramp_s, f sine_nm, "
            "f sine_begin_hz, f sine_end_hz, f stiffness_nm_per_rad, f damping_nm_s_per_rad, "
            "f servo_rad_s",
        ),
        _report(
            "wall",
            0x20,
            f"{_TARGET}, q angle_turns_q32, B side, f stiffness_nm_per_rad, f damping_nm_s_per_rad",
        ),
        _report(
            "spring",
            0x21,
            f"{_TARGET}, q angle_turns_q32, f stiffness_nm_per_rad, f deadband_rad, "
            "f torque_limit_nm",
        ),
        _report("damper", 0x22, f"{_TARGET}, f damping_nm_s_per_rad, f torque_limit_nm"),
        _report("friction", 0x23, f"{_TARGET}, f torque_nm, f stiffness_nm_per_rad"),
        _report("inertia", 0x24, f"{_TARGET}, f inertia_kg_m2, f torque_limit_nm"),
        _report("constant", 0x25, f"{_TARGET}, f torque_nm, {_TIMING}"),
        _report("ramp", 0x26, f"{_TARGET}, f start_torque_nm, f end_torque_nm, {_TIMING}"),
        _report(
            "periodic",
            0x27,
            f"{_TARGET}, B waveform, f amplitude_nm, f offset_nm, f frequency_hz, f phase_turns, "
            f"{_TIMING}",
        ),
        _report(
            "detents",
            0x28,
            f"{_TARGET}, q angle_turns_q32, Q per_turn_q32, f torque_nm, B profile, f width",
        ),
        _report(
            "end_stops",
            0x29,
            f"{_TARGET}, q lower_turns_q32, q upper_turns_q32, f stiffness_nm_per_rad, "
            "f damping_nm_s_per_rad",
        ),
        _report("texture", 0x2A, f"{_TARGET}, H grains_per_turn, f torque_nm, B grain, I seed"),
        _report(
            "curve",
            0x2B,
            f"{_TARGET}, q angle_turns_q32, Q span_turns_q32, B ends, H first_point, H points",
        ),
        _report(
            "impact",
            0x2C,
            f"{_TARGET}, q angle_turns_q32, B side, f strength_nm_s_per_rad, f frequency_hz, "
            "f decay_s, f pulse_nm_s_per_rad, f pulse_s, f torque_limit_nm",
        ),
        _report("curve_points", 0x2F, "H sequence, B axis, H first_point, B points, 13f torque_nm"),
        _report(
            "telemetry",
            0x40,
            f"B axis_samples, B decimation, B flags, Q tick, i base_counts, {_SAMPLES}",
        ),
        _report(
            "acknowledgement",
            0x41,
            "H sequence, B report, B status, B field, B state, Q tick, B owner",
        ),
        _report("event", 0x42, "B kind, B state, H faults, Q tick, B owner"),
    )
}

ENUMERATORS = {
    "side": ("above", "below"),
    "waveform": ("sine", "square", "triangle", "sawtooth_up", "sawtooth_down"),
    "profile": ("sine", "linear", "click"),
    "grain": ("sine", "square", "triangle", "noise"),
    "ends": ("hold", "repeat"),
    "state": ("disarmed", "armed", "fault"),
    "owner": ("none", "sdk", "game", "dial"),
    "law": ("paper", "compensated", "parallel", "motor_only", "calibrated"),
    "encoder_reversed": ("off", "on"),
    "motor_reversed": ("off", "on"),
    "confirmed": ("off", "on"),
    "values_are": ("assumed", "stated", "measured"),
    "reset_cause": (
        *("unknown", "power", "brown_out", "reset_pin", "watchdog", "hard_fault", "stack"),
    ),
    "centre": ("power_up", "awaits_index", "index"),
    "autonomous": ("off", "on"),
    "enabled": ("off", "on"),
    "prompt": ("off", "on"),
    "op": (
        *("keep_alive", "arm", "disarm", "stop", "zero"),
        *("relax", "save", "load_defaults", "clear_fault", "bootloader"),
    ),
    "kind": (
        *("state_changed", "watchdog", "deadline_missed", "owner_changed"),
        *("excitation_over", "excitation_stopped"),
    ),
    "paused": ("off", "on"),
    "kept": ("off", "on"),
    "measured": ("off", "on"),
    "join_updates": ("off", "on"),
    "reversed": ("off", "on"),
    "dial_coarse": ("off", "on"),
    "remote_wakeup": ("off", "on"),
    "personality": ("game_controller", "dial"),
    "dial_use": (
        *("wheel", "pan", "volume", "radial"),
        *("wheel_or_pan", "wheel_or_volume", "volume_or_wheel"),
    ),
}
for _n in range(3):
    ENUMERATORS[f"effect.{_n}.kind"] = (
        *("none", "constant", "ramp", "square", "sine", "triangle", "sawtooth_up"),
        *("sawtooth_down", "spring", "damper", "inertia", "friction"),
    )
    ENUMERATORS[f"effect.{_n}.state"] = ("stopped", "playing", "set_aside")


def _find(values: Any, path: str) -> Any:
    for key in path.split("."):
        values = values[int(key) if key.isdigit() else key]
    return values


def _store(values: Any, path: str, value: Any) -> None:
    keys = path.split(".")
    for key, following in itertools.pairwise(keys):
        empty: Any = [] if following.isdigit() else {}
        if key.isdigit():
            if len(values) == int(key):
                values.append(empty)
            values = values[int(key)]
        else:
            values = values.setdefault(key, empty)
    values[keys[-1]] = value


def encode(name: str, values: Values) -> bytes:
    """Make a report of 64 bytes from nested values; enumerations are given by name."""
    report = REPORTS[name]
    scalars: list[Any] = []
    for path in report.paths:
        value = _find(values, path)
        if path in ENUMERATORS:
            value = ENUMERATORS[path].index(value)
        scalars.extend(value if isinstance(value, list) else [value])
    return struct.pack(report.format, report.id, *scalars).ljust(REPORT_SIZE, b"\0")


def decode(data: bytes) -> tuple[str, Values]:
    """Read a report of 64 bytes into its name and nested values, without checking ranges."""
    report = next(report for report in REPORTS.values() if report.id == data[0])
    length = struct.calcsize(report.format)
    assert len(data) == REPORT_SIZE
    assert not any(data[length:])
    _, *scalars = struct.unpack(report.format, data[:length])
    values: Values = {}
    for field_format, path in zip(report.formats, report.paths, strict=True):
        count = len(struct.unpack("<" + field_format, bytes(struct.calcsize("<" + field_format))))
        taken, scalars = scalars[:count], scalars[count:]
        value: Any = taken if count > 1 else taken[0]
        if path in ENUMERATORS:
            value = ENUMERATORS[path][value]
        _store(values, path, value)
    return report.name, values
