"""A knob's answers to its user: identity, clock, health, telemetry. The library fills these in."""

from __future__ import annotations

from firmware.protocol.definition import enumerations as e
from firmware.protocol.definition import reports
from tools.definition.model import Structure, choice, for_hosts, switch, text, texts, told, told_of

LISTED_DEVICE = Structure(
    "ListedDevice",
    "A device that could be opened.",
    (
        text("path", "path for open()"),
        text("serial", "serial number"),
        text("product", "as its maker calls it"),
        text("board", "empty if the device could not be asked"),
        text("transport", '"hid" or "emulated"'),
        text("problem", "why it cannot be opened now; empty if it can"),
    ),
    comparable=True,
)
DEVICE_INFO = Structure(
    "DeviceInfo",
    "Identity and abilities of the device.",
    (
        text("path", "path for open()"),
        text("serial", "serial number"),
        text("product", "as its maker calls it"),
        text("board", '"pico2", "emulated", ...'),
        text("firmware_version", '"major.minor.patch"'),
        text("transport", '"hid", "emulated" or "own", a transport that the program brings'),
        told("protocol_version", "std::uint16_t", "of the reports"),
        *told_of(reports.IDENTITY, "fingerprint"),
        *told_of(reports.IDENTITY, "axes", "effects", "curve_points"),
        told("control_rate_hz", "double", "ticks in a second"),
        *told_of(reports.IDENTITY, "counts_per_rev", "torque_step_nm", "speed_step_rad_s"),
    ),
)
CLOCK = Structure(
    "Clock",
    "The device's time and position, both exact.",
    (
        *told_of(reports.CLOCK, "tick", "time_ns", "position_counts"),
        told("angle_rad", "double", "the same as an angle"),
    ),
)
HEALTH = Structure(
    "Health",
    "State and counters of the device since its power-up.",
    (
        *told_of(reports.HEALTH, "state"),
        texts("faults", 'names of the latched faults: "over_speed", ...'),
        *told_of(
            reports.HEALTH,
            *("reports_accepted", "reports_refused", "samples_dropped", "tick_overruns"),
            *("tick_time_ns", "tick_time_max_ns", "saves", "owner", "reset_cause"),
            *("unexpected_swings", "centre"),
        ),
    ),
)
ENERGIES = Structure(
    "Energies",
    "Energies that the law `calibrated` has counted since it was chosen. The hand feels the "
    "motor's energy, the shaft stores it, or the brake takes it.",
    (
        *told_of(reports.LEDGER, "tick"),
        told("time_s", "double", "tick times the control period"),
        *told_of(reports.LEDGER, "kept"),
        told("motor_j", "double", "given to the knob by the motor"),
        told(
            "felt_j", "double", "given to the knob by motor and shaft together, which a hand feels"
        ),
        *told_of(reports.LEDGER, "stored_j"),
        told("brake_j", "double", "taken by the brake"),
        *told_of(reports.LEDGER, "bound_nm_per_rad"),
    ),
    comparable=True,
)
MOTOR_CURRENT = Structure(
    "MotorCurrent",
    "Sums of the motor's current readings and of its bridge's shares since the board started. The "
    "difference of two readings covers everything in between.",
    (
        *told_of(reports.MOTOR_CURRENT, "measured"),
        told("time_s", "double", "periods of the current loop since the board started"),
        told("angle_rad", "double", "at the newest tick"),
        *told_of(reports.MOTOR_CURRENT, "period_ns", "delay_ns", "periods"),
        told("current_a", "double", "the newest measurement, without its zero"),
        told("zero_a", "double", "reading without current"),
        told("step_a", "double", "of the converter"),
        told("current_sum_a", "double", "of all measurements, each with its zero"),
        *told_of(reports.MOTOR_CURRENT, "share", "share_before", "share_sum"),
        told(
            "torque_constant_nm_per_a",
            "double",
            "that the board reckons with: what it was configured to when it started",
        ),
    ),
    comparable=True,
)
LIMITS = Structure(
    "Limits",
    "The most that the device gives, by its configuration as it is now.",
    (
        told("motor_torque_max_nm", "double", "of the motor, for seconds"),
        told("motor_torque_continuous_max_nm", "double", "the same for ever, as its winding stands it"),
        told("brake_torque_max_nm", "double", "of the brake"),
        told("speed_limit_rad_s", "double", "more is a fault; 0: no limit"),
        for_hosts(
            switch(
                "held_low", e.TOGGLE,
                "the board gives little, because nobody has confirmed its parts, or because their "
                "values are assumed; `confirmed` and a calibration end it",
            )
        ),
    ),
)  # fmt: skip
GAME_STATUS = Structure(
    "GameStatus",
    "Effects of games on the device.",
    (
        told("time_s", "double", "of this moment: the device's tick times the control period"),
        *told_of(
            reports.GAME_MONITOR,
            "owner",
            "paused",
            "enabled",
            "gain",
            "torque",
            "updates",
            "effects",
            "clipped_ticks",
            "asked_percent",
        ),
    ),
)
GAME_EFFECT = Structure(
    "GameEffect",
    "One effect that a game has made.",
    told_of(reports.GAME_EFFECT, "block", "kind", "state", "torque", "updates", "silent_ms"),
)
LINK_STATISTICS = Structure(
    "LinkStatistics",
    "Counters of this end of the cable, since the knob was opened.",
    (
        told("reports_sent", "std::uint64_t", "to the device"),
        told("reports_received", "std::uint64_t", "from the device"),
        told("reports_undecodable", "std::uint64_t", "damaged on the way, and ignored"),
        told("samples_received", "std::uint64_t", "of telemetry"),
        told(
            "samples_lost", "std::uint64_t", "never arrived, or not read before the ring was full"
        ),
        told("events_lost", "std::uint64_t", "not taken before there were 1,024 of them"),
        told("local_models_refused", "std::uint64_t", "by the device"),
        text("last_refusal", "of a local model, in words"),
    ),
)
EVENT = Structure(
    "Event",
    "Something that the device did without being asked, or that somebody else asked for.",
    (
        text("kind", 'kind of event: "state_changed", "watchdog", "deadline_missed", ...'),
        *told_of(reports.EVENT, "state", "owner"),
        texts("faults", "names of the faults that are latched after it"),
        *told_of(reports.EVENT, "tick"),
        told("time_s", "double", "tick times the control period"),
    ),
    comparable=True,
)
DISARM = Structure(
    "Disarm",
    "How the torque went the last time.",
    (
        for_hosts(choice("reason", e.DISARM_REASON, "why it went")),
        texts("faults", "names of the faults that were latched then"),
        told("tick", "std::uint64_t", "when: control periods since power-up"),
        told("time_s", "double", "tick times the control period"),
    ),
    comparable=True,
)
STABLE_STIFFNESS = Structure(
    "StableStiffness",
    "How stiff a spring can be that a knob swings in and still comes to rest.",
    (
        told("stiffness_nm_per_rad", "double", "the stiffest such spring"),
        text(
            "limited_by",
            'the limit to improve: "rate" of the control, "lag" of the motor, "counts" of the '
            "encoder",
        ),
    ),
    comparable=True,
)
TELEMETRY_SAMPLE = Structure(
    "TelemetrySample",
    "One moment of the control loop. Torques are on the knob.",
    (
        told("tick", "std::uint64_t", "control periods since power-up"),
        told("time_s", "double", "tick times the control period"),
        told("position_counts", "std::int64_t", "from the device's zero, never wraps"),
        told("angle_rad", "double", "the same as an angle"),
        *told_of(
            reports.SAMPLE,
            *("speed", "desired_torque", "motor_command", "brake_capacity", "spring_torque"),
            host="float",
        ),
        told("flags", "std::uint8_t", "of this sample or a neighbour in the same report"),
    ),
    array_record=True,
    comparable=True,
)

TOLD = (
    LISTED_DEVICE, DEVICE_INFO, CLOCK, HEALTH, ENERGIES, MOTOR_CURRENT, LIMITS, STABLE_STIFFNESS, GAME_STATUS, GAME_EFFECT,
    LINK_STATISTICS, EVENT, DISARM,
)  # fmt: skip
__all__ = ["TELEMETRY_SAMPLE", "TOLD"]
