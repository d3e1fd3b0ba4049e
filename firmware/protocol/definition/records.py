"""What a knob tells its user: identity, clock, health, telemetry. The library fills these in."""

from __future__ import annotations

from dataclasses import replace

from firmware.protocol.definition import enumerations as e
from tools.definition.model import Structure, choice, for_hosts, switch, text, texts, told

_STATE = for_hosts(choice("state", e.STATE, "whether it makes torque"))
_OWNER = for_hosts(choice("owner", e.OWNER, "who has the actuator"))

LISTED_DEVICE = Structure(
    "ListedDevice",
    "A device that could be opened.",
    (
        text("path", "what open() takes"),
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
    "Who the device is and what it can do.",
    (
        text("path", "what open() takes"),
        text("serial", "serial number"),
        text("product", "as its maker calls it"),
        text("board", '"pico2", "emulated", ...'),
        text("firmware_version", '"major.minor.patch"'),
        text("transport", '"hid", "emulated" or "own", a transport that the program brings'),
        told("protocol_version", "std::uint16_t", "of the reports"),
        told("fingerprint", "std::uint32_t", "of the report layouts, the same as the library's"),
        told("axes", "int", "actuators that it has"),
        told("effects", "int", "places in a scene"),
        told("curve_points", "int", "shared by all curves of a scene"),
        told("control_rate_hz", "double", "ticks in a second"),
        told("counts_per_rev", "std::uint32_t", "of the encoder"),
        told("torque_step_nm", "double", "resolution of telemetry's torques"),
        told("speed_step_rad_s", "double", "resolution of telemetry's speed"),
    ),
)
CLOCK = Structure(
    "Clock",
    "The device's time and position, both exact.",
    (
        told("tick", "std::uint64_t", "control periods since power-up"),
        told("time_s", "double", "tick times the control period"),
        told("position_counts", "std::int64_t", "from the device's zero, never wraps"),
        told("angle_rad", "double", "the same as an angle"),
    ),
)
HEALTH = Structure(
    "Health",
    "State and counters of the device since its power-up.",
    (
        _STATE,
        texts("faults", 'names of the latched faults: "over_speed", ...'),
        told("reports_accepted", "std::uint32_t", "that did what they asked"),
        told("reports_refused", "std::uint32_t", "that changed nothing"),
        told("samples_dropped", "std::uint32_t", "telemetry that the host did not fetch in time"),
        told("tick_overruns", "std::uint32_t", "ticks that were missed"),
        told("tick_time_s", "double", "time that the last control tick took"),
        told("tick_time_max_s", "double", "longest tick so far"),
        told("saves", "std::uint32_t", "how often the configuration was saved, ever"),
        _OWNER,
        for_hosts(choice("reset_cause", e.RESET_CAUSE, "why the device started")),
    ),
)
ENERGIES = Structure(
    "Energies",
    "What the law `calibrated` has counted since it was chosen. What the motor gave is felt, stored or taken by the brake.",
    (
        told("tick", "std::uint64_t", "of this moment: control periods since power-up"),
        told("time_s", "double", "tick times the control period"),
        for_hosts(switch("kept", e.TOGGLE, "the law keeps count; else all stand still")),
        told("motor_j", "double", "given to the knob by the motor"),
        told(
            "felt_j", "double", "given to the knob by motor and shaft together, which a hand feels"
        ),
        told("stored_j", "double", "in the shaft's spring now"),
        told("brake_j", "double", "taken by the brake"),
        told(
            "bound_nm_per_rad",
            "double",
            "the stiffest that is rendered now, found out from the knob's swings; 0: no bound",
        ),
    ),
    comparable=True,
)
MOTOR_CURRENT = Structure(
    "MotorCurrent",
    "What the motor's current sensor has shown and its bridge was told since the board started: of two "
    "readings the difference tells what was between them.",
    (
        for_hosts(
            switch("measured", e.TOGGLE, "there is a current sensor; else all of this is nothing")
        ),
        told("time_s", "double", "periods of the current loop since the board started"),
        told("angle_rad", "double", "at the newest tick"),
        told("period_s", "double", "of the current loop"),
        told("delay_s", "double", "from a measurement to the voltage that answers it"),
        told("periods", "std::uint64_t", "done, each with one measurement"),
        told("current_a", "double", "the newest measurement, without its zero"),
        told("zero_a", "double", "what is measured without current"),
        told("step_a", "double", "of the converter"),
        told("current_sum_a", "double", "of all measurements, each with its zero"),
        told("share", "double", "of the supply's voltage that answers the newest"),
        told("share_before", "double", "that answered the one before"),
        told("share_sum", "double", "of all"),
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
                "nobody has confirmed the parts of this real board, or their values are assumed, so it "
                "gives little; `confirmed` and a calibration end it",
            )
        ),
    ),
)  # fmt: skip
GAME_STATUS = Structure(
    "GameStatus",
    "What games do with the device.",
    (
        told("time_s", "double", "of this moment: the device's tick times the control period"),
        _OWNER,
        for_hosts(switch("paused", e.TOGGLE, "by the game")),
        for_hosts(switch("enabled", e.TOGGLE, "the game wants the actuator on")),
        told("gain", "double", "of the device, as the game set it, 0 to 1"),
        told("torque_nm", "double", "of all effects together"),
        told("updates", "std::uint32_t", "reports that games sent since power-up"),
        told("effects", "int", "that exist"),
    ),
)
GAME_EFFECT = Structure(
    "GameEffect",
    "One effect that a game has made.",
    (
        told("block", "int", "its number, from 1"),
        for_hosts(choice("kind", e.GAME_EFFECT_KIND, "what it is")),
        for_hosts(choice("state", e.GAME_EFFECT_STATE, "whether it plays")),
        told("torque_nm", "double", "what it gives now, before the cap on all together"),
        told("updates", "std::uint32_t", "reports about it since it was made"),
        told("silent_s", "double", "since the last of them; 65.535 at most"),
    ),
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
        text("kind", 'what happened: "state_changed", "watchdog", "deadline_missed", ...'),
        replace(_STATE, doc="after the event"),
        replace(_OWNER, doc="who has the actuator after the event"),
        texts("faults", "names of the faults that are latched after it"),
        told("tick", "std::uint64_t", "when: control periods since power-up"),
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
            'what to better for more: "rate" of the control, "lag" of the motor, "counts" of the '
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
        told("speed_rad_s", "float", "estimated"),
        told("desired_torque_nm", "float", "what the scene asks"),
        told("motor_command_nm", "float", "asked of the motor"),
        told("brake_capacity_nm", "float", "what the brake can hold, estimated"),
        told("spring_torque_nm", "float", "of the shaft on the knob, sensed"),
        told("flags", "std::uint8_t", "of this sample or a neighbour in the same report"),
    ),
    array_record=True,
    comparable=True,
)

RECORDS = (
    LISTED_DEVICE, DEVICE_INFO, CLOCK, HEALTH, ENERGIES, MOTOR_CURRENT, LIMITS, STABLE_STIFFNESS, GAME_STATUS, GAME_EFFECT,
    LINK_STATISTICS, EVENT, DISARM,
)  # fmt: skip
__all__ = ["RECORDS", "TELEMETRY_SAMPLE", "replace"]
