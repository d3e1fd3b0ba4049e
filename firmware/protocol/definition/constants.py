"""Numbers that several field lists share: limits of the protocol, and the reference actuator.

The limits are wide on purpose: they keep the arithmetic finite, and the actuator's own limits are applied
where the torque is made.
"""

from __future__ import annotations

from tools.definition.model import Constant

MAX_EFFECTS = Constant("max_effects", 16, "std::uint8_t")
CURVE_POOL_POINTS = Constant("curve_pool_points", 1024, "std::uint16_t")
CURVE_POINTS_PER_REPORT = Constant("curve_points_per_report", 13, "std::uint8_t")
SAMPLES_PER_REPORT = Constant("samples_per_report", 4, "std::uint8_t")
GAME_EFFECTS_PER_REPORT = Constant("game_effects_per_report", 3, "std::uint8_t")
PROTOCOL_VERSION = Constant("protocol_version", 1, "std::uint16_t")
RELEASED_FINGERPRINTS = (0x9DDBBA23,)
"""Fingerprints of the firmware in tests/board/releases: the library drives it with today's reports. If a report changes so
that this fails, raise the protocol version and begin this list anew."""

UNCONFIRMED_MOTOR_TORQUE_MAX_NM = Constant(
    "unconfirmed_motor_torque_max_nm", 15e-3,
    doc="enough to move the reference actuator against its friction, and nothing that hurts",
)  # fmt: skip
UNCONFIRMED_BRAKE_TORQUE_MAX_NM = Constant("unconfirmed_brake_torque_max_nm", 30e-3)
UNCONFIRMED_SPEED_LIMIT_RAD_S = Constant("unconfirmed_speed_limit_rad_s", 10.0)

MIN_CONTROL_PERIOD_NS = Constant("min_control_period_ns", 50_000, "std::uint32_t")
MAX_CONTROL_PERIOD_NS = Constant("max_control_period_ns", 1_000_000, "std::uint32_t")
EMULATED_CONTROL_PERIOD_NS = Constant(
    "emulated_control_period_ns", 1_000_000, "std::uint32_t", doc="unless it is told another"
)
MIN_CONTROL_RATE_HZ = Constant("min_control_rate_hz", 1e9 / MAX_CONTROL_PERIOD_NS.value, "double")
MAX_CONTROL_RATE_HZ = Constant("max_control_rate_hz", 1e9 / MIN_CONTROL_PERIOD_NS.value, "double")

LET_GO_S = Constant(
    "let_go_s", 4e-3,
    doc="a torque's way to zero when somebody disarms; its spectrum is zero at 250 Hz, where the "
    "skin is most sensitive",
)  # fmt: skip

EXCITATION_STILL_S = Constant(
    "excitation_still_s", 50e-3,
    doc="an experiment's servo disarms after so long at full torque without movement; the "
    "reference motor makes the reference knob 40 rad/s faster in this time",
)  # fmt: skip

# The reference actuator: what the device takes it for, and what the emulated one is.
REFERENCE_MOTOR_TORQUE_MAX_NM = 85e-3
REFERENCE_BRAKE_TORQUE_MAX_NM = 110e-3
REFERENCE_BRAKE_DRAG_NM = 2e-3
REFERENCE_BRAKE_TIME_CONSTANT_S = 60e-3
REFERENCE_SHAFT_STIFFNESS_NM_PER_RAD = 2.873
REFERENCE_COUNTS_PER_REV = 8192
REFERENCE_BRAKE_FLOOR_NM = 3.3e-3
REFERENCE_KNOB_INERTIA_KG_M2 = 6e-5
REFERENCE_KNOB_COULOMB_NM = 6e-3
REFERENCE_KNOB_VISCOUS_NM_S_PER_RAD = 2.6e-5
REFERENCE_BRAKE_INERTIA_KG_M2 = 4e-5

# Its electrical values, at 25 degrees.
REFERENCE_SUPPLY_V = 12.0
REFERENCE_SUPPLY_SENSE_RATIO = 11
REFERENCE_MOTOR_RESISTANCE_OHM = 2.5
REFERENCE_MOTOR_INDUCTANCE_H = 1.5e-3
REFERENCE_MOTOR_TORQUE_CONSTANT_NM_PER_A = 0.05
REFERENCE_BRAKE_RESISTANCE_OHM = 40.0
REFERENCE_BRAKE_TORQUE_CONSTANT_NM_PER_A = 0.44
REFERENCE_CURRENT_SENSE_V_PER_A = 0.2
REFERENCE_AMBIENT_C = 25

LEDGER_TORQUE_NM = 2.0**-23
"""Unit of the ledger's torques; firmware/core/ledger.hpp has the same."""

MOTOR_LAG_S = 44e-6
"""By which the reference board's current loop trails: a period of 25 us until its voltage acts, then the
share 1 - exp(-2 pi 10 kHz 25 us) of the way in each, along lines; 25 us (1 / 2 + 1 / share)."""

MAX_TORQUE_NM = Constant("max_torque_nm", 100.0)
MAX_STIFFNESS_NM_PER_RAD = Constant("max_stiffness_nm_per_rad", 1e6)
MAX_DAMPING_NM_S_PER_RAD = Constant("max_damping_nm_s_per_rad", 1e3)
MAX_INERTIA_KG_M2 = Constant("max_inertia_kg_m2", 10.0)
MAX_TIME_S = Constant("max_time_s", 1e5)
MAX_TURNS_Q32 = Constant(
    "max_turns_q32", 1 << 58, "std::int64_t", "std::int64_t{1} << 58", "2^26 turns either way"
)
MAX_SPAN_TURNS_Q32 = Constant(
    "max_span_turns_q32", 1 << 39, "std::uint64_t", "std::uint64_t{1} << 39", "128 turns"
)
MIN_SPAN_TURNS_Q32 = Constant("min_span_turns_q32", 1 << 16, "std::uint64_t")
MAX_CYCLES_PER_TURN_Q32 = Constant(
    "max_cycles_per_turn_q32", 1 << 48, "std::uint64_t", "std::uint64_t{1} << 48"
)
