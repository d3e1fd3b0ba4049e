"""Everything on the wire that is neither an effect nor configuration: identity, commands, telemetry."""

from __future__ import annotations

from firmware.protocol.definition import enumerations as e
from firmware.protocol.definition.configurations import CONFIGURATIONS
from firmware.protocol.definition.constants import (
    CURVE_POOL_POINTS,
    EMULATED_CONTROL_PERIOD_NS,
    EXCITATION_STILL_S,
    GAME_EFFECTS_PER_REPORT,
    MAX_CONTROL_PERIOD_NS,
    MAX_EFFECTS,
    MAX_TORQUE_NM,
    MIN_CONTROL_PERIOD_NS,
    PROTOCOL_VERSION,
    REFERENCE_COUNTS_PER_REV,
    SAMPLES_PER_REPORT,
)
from firmware.protocol.definition.effects import (
    CURVE_POINTS,
    EFFECTS,
    angle_rad,
    damping,
    stiffness,
    torque,
)
from tools.definition.model import Structure, choice, group, number, on_wire, raw, switch

_SEQUENCE = raw("sequence", "u16", "returned in the acknowledgement")
_AXIS = raw("axis", "u8", "0: an interface has one axis")

# A hundred years and more, whatever is counted; room is left to add to it.
_FOR_EVER = 1 << 62

IDENTITY = Structure(
    "Identity",
    "Identity and abilities of the device. Read only.",
    (
        raw("fingerprint", "u32", "of the report layouts, the same as the library's"),
        raw("version", "u16", "version of the protocol", default="protocol_version"),
        raw("firmware_version", "u8", "major, minor, patch", count=3),
        raw("board", "u8", "board of the firmware: 0 is the emulated device; firmware/boards/"),
        raw("serial", "u8", "ASCII, padded with zeros", count=16),
        raw("axes", "u8", "actuators behind this interface", "", 1, 16, default=1),
        raw("effects", "u8", "places in a scene", "", 1, MAX_EFFECTS, default="max_effects"),
        raw(
            "curve_points", "u16", "shared by all curves of a scene", "", 0, CURVE_POOL_POINTS,
            default="curve_pool_points",
        ),
        raw(
            "control_period_ns", "u32", "length of a tick", "ns", MIN_CONTROL_PERIOD_NS,
            MAX_CONTROL_PERIOD_NS, default=EMULATED_CONTROL_PERIOD_NS,
        ),
        raw("counts_per_rev", "u32", "of the encoder", "", 4, 1 << 24, default=REFERENCE_COUNTS_PER_REV),
        raw("torque_step_nm", "f32", "resolution of telemetry's torques", "N m", 1e-9, 1.0, default=1e-5),
        raw(
            "speed_step_rad_s", "f32", "resolution of telemetry's speed", "rad/s", 1e-9, 100.0,
            default=0.01,
        ),
    ),
    id=0x01,
    direction="feature",
)  # fmt: skip
CLOCK = Structure(
    "Clock",
    "The device's time and position in full. Read only.",
    (
        raw("tick", "u64", "control periods since power-up", "", 0, _FOR_EVER),
        raw("time_ns", "u64", "tick times the control period", "ns", 0, _FOR_EVER),
        raw(
            "position_counts",
            "i64",
            "from the device's zero, never wraps",
            "count",
            -_FOR_EVER,
            _FOR_EVER,
        ),
    ),
    id=0x02,
    direction="feature",
)
HEALTH = Structure(
    "Health",
    "State and counters since power-up. Read only.",
    (
        on_wire(choice("state", e.STATE, "whether it makes torque")),
        raw("faults", "u16", "bits, see above"),
        raw("reports_accepted", "u32", "that did what they asked"),
        raw("reports_refused", "u32", "that changed nothing"),
        raw("samples_dropped", "u32", "telemetry that the host did not fetch in time"),
        raw("tick_overruns", "u32", "ticks that were missed"),
        raw("tick_time_ns", "u32", "time that the last control tick took", "ns"),
        raw("tick_time_max_ns", "u32", "longest tick so far", "ns"),
        raw("saves", "u32", "how often the configuration was saved, ever"),
        on_wire(choice("owner", e.OWNER, "owner of the actuator")),
        on_wire(choice("reset_cause", e.RESET_CAUSE, "why the device started")),
        raw(
            "unexpected_swings",
            "u32",
            "swings of the law `calibrated` that lasted in scenes which the configured parts can "
            "render, and four for a ring, since the knob was configured, less one for fifty turns",
        ),
        on_wire(choice("centre", e.CENTRE, "where angle 0 comes from")),
    ),
    id=0x03,
    direction="feature",
)
GAME_EFFECT = Structure(
    "GameEffect",
    "One effect of a game.",
    (
        raw("block", "u8", "its number, from 1; 0: an empty row of the report"),
        on_wire(choice("kind", e.GAME_EFFECT_KIND, "its kind")),
        on_wire(choice("state", e.GAME_EFFECT_STATE, "whether it plays")),
        raw("torque", "i16", "torque now, before the cap on all together", "torque_step_nm"),
        raw("updates", "u32", "reports about it since it was made"),
        raw("silent_ms", "u16", "since the last of them; 65.535 s is that or longer", "ms"),
    ),
)
GAME_MONITOR = Structure(
    "GameMonitor",
    "Effects of games. Each reading shows the next of the effects, in turns. Read only.",
    (
        raw("tick", "u64", "of this moment"),
        on_wire(choice("owner", e.OWNER, "owner of the actuator")),
        on_wire(switch("paused", e.TOGGLE, "by the game")),
        on_wire(switch("enabled", e.TOGGLE, "the game wants the actuator on")),
        raw("gain", "u16", "of the device, as the game set it, 0 to 1", "1/32767"),
        raw("torque", "i16", "of all effects together", "torque_step_nm"),
        raw("updates", "u32", "reports that games sent since power-up"),
        raw("effects", "u8", "that exist"),
        raw(
            "clipped_ticks",
            "u32",
            "ticks in which effects asked for more than all together get, since power-up",
        ),
        raw(
            "asked_percent",
            "u16",
            "the most that effects asked for in the last half second, as a share of their joint limit",
        ),
        on_wire(group("effect", GAME_EFFECT, count=GAME_EFFECTS_PER_REPORT)),
    ),
    id=0x08,
    direction="feature",
)
LEDGER = Structure(
    "Ledger",
    "The energy that motor and shaft have given to the knob since the law began to count. The numbers "
    "are whole and lose nothing; `energies()` makes joules of them. Read only.",
    (
        raw("tick", "u64", "of this moment: control periods since power-up"),
        on_wire(switch("kept", e.TOGGLE, "the law keeps count; else all stand still")),
        raw(
            "motor", "i64",
            "given to the knob by the motor: its command in 2^-23 N m, times the counts it moved",
        ),
        raw("spring_twice", "i64", "given to the knob by the shaft's spring, twice the same"),
        raw("spring", "i32", "that spring's torque on the knob now", "2^-23 N m"),
        raw("stored_j", "f32", "in the shaft's spring now", "J"),
        raw(
            "bound_nm_per_rad", "f32",
            "the stiffest that is rendered now, found out from the knob's swings; 0: no bound",
            "N m/rad",
        ),
    ),
    id=0x09,
    direction="feature",
)  # fmt: skip
MOTOR_CURRENT = Structure(
    "MotorCurrent",
    "Sums over all periods of the current loop since the board started: readings of the motor's current "
    "sensor and shares of its bridge. Read the report twice; the difference is what happened between. "
    "Read only.",
    (
        on_wire(switch("measured", e.TOGGLE, "there is a current sensor; without one the other fields are 0")),
        raw("position_counts", "i64", "at the newest tick", "count", -_FOR_EVER, _FOR_EVER),
        raw("period_ns", "u32", "of the current loop", "ns"),
        raw("delay_ns", "u32", "from a measurement to the voltage that answers it", "ns"),
        raw("periods", "u64", "done, each with one measurement", "", 0, _FOR_EVER),
        raw("reading_sum", "i64", "sum of the sensor's readings, one a period", "step"),
        raw("share_sum", "i64", "sum of all shares, positive to larger angles", "2^-14 of the supply"),
        raw("reading", "i32", "newest reading", "step"),
        raw("share", "i16", "share of the supply's voltage that answers it", "2^-14 of the supply"),
        raw("share_before", "i16", "share before it", "2^-14 of the supply"),
        raw("zero", "f32", "reading without current, learnt while the power was off", "step"),
        raw("a_per_step", "f32", "positive or negative, as the board was configured when it started", "A"),
        raw("a_per_nm", "f32", "current asked of the motor for a torque", "A/(N m)"),
    ),
    id=0x0C,
    direction="feature",
)  # fmt: skip
COMMAND = Structure(
    "Command",
    "An order without values.",
    (_SEQUENCE, _AXIS, on_wire(choice("op", e.OP, "the order"))),
    id=0x10,
    direction="output",
)
COMMIT = Structure(
    "Commit",
    "Plays the whole scene as written from the next tick on. Slots written since the last commit start "
    "anew, the others go on.",
    (_SEQUENCE, _AXIS, raw("active", "u16", "bit n: slot n plays")),
    id=0x11,
    direction="output",
)
STREAM = Structure(
    "Stream",
    "Starts or stops telemetry.",
    (
        _SEQUENCE,
        _AXIS,
        raw("decimation", "u8", "one sample every so many ticks; 0 stops"),
        on_wire(
            switch(
                "prompt", e.TOGGLE,
                "on: a report in every frame with the newest samples; off: full reports, a few "
                "frames later",
            )
        ),
    ),
    id=0x12,
    direction="output",
)  # fmt: skip
LOCAL_MODEL = Structure(
    "LocalModel",
    "A torque, a spring and a damper that the device renders at its own rate, on top of the scene, "
    "until the next one comes: `torque - stiffness (angle - angle_rad) - damping speed`.",
    (
        raw("sequence", "u16", "must be newer (modulo 2^16) than the last one"),
        _AXIS,
        torque("torque_nm", "at the reference, at rest", low=-MAX_TORQUE_NM, default=0.0),
        angle_rad("angle_rad", "reference position"),
        stiffness(default=0.0),
        damping(),
        number(
            "deadline_s", "s", 0.0, 60.0,
            "how long it holds; 0 ends the stream in good order", default=0.02,
        ),
    ),
    wire_doc="A torque, a spring and a damper that the device renders at its own rate, on top of the "
    "scene, until the next one comes. A host that streams these renders stiff things without its own "
    "delay. Only refusals are acknowledged. Past the deadline the device fails passive.",
    id=0x13,
    direction="output",
)  # fmt: skip
EXCITATION = Structure(
    "Excitation",
    "A bounded experiment: commands of motor and brake that go past scene and law. Both commands move "
    "in a straight line from where the last excitation is now. The motor also gets a sine and the torque "
    "of a servo, `servo_stiffness (reference - angle) + servo_damping (reference' - speed)`. The device "
    "disarms when a bound is left, or when the time is over and no next one has come. It also disarms "
    f"when the servo asks for all of the motor for {1e3 * EXCITATION_STILL_S.value:.0f} ms and the encoder "
    "stands still.",
    (
        _SEQUENCE,
        _AXIS,
        number(
            "duration_s", "s", 1e-3, 60.0, "until it disarms, unless the next one comes first",
            required=True,
        ),
        number("travel_rad", "rad", 1e-3, 1e3, "further from its first angle disarms", required=True),
        number("speed_limit_rad_s", "rad/s", 0.1, 1e4, "faster disarms", required=True),
        number(
            "torque_limit_nm", "N m", 0.0, MAX_TORQUE_NM, "largest torque of the motor", required=True
        ),
        torque("motor_command_nm", "where the motor goes", low=-MAX_TORQUE_NM, default=0.0),
        torque("brake_command_nm", "where the brake's command goes", default=0.0),
        number("ramp_s", "s", 0.0, 60.0, "time that both take; 0 is a step"),
        torque("sine_nm", "amplitude of the sine on top of `motor_command_nm`", default=0.0),
        number("sine_begin_hz", "Hz", 0.0, 1e3, "its frequency at the beginning"),
        number("sine_end_hz", "Hz", 0.0, 1e3, "and after `duration_s`"),
        stiffness("of the servo", default=0.0),
        damping("of the servo"),
        number("servo_rad_s", "rad/s", -1e3, 1e3, "speed of the servo's reference", default=0.0),
    ),
    id=0x14,
    direction="output",
)  # fmt: skip

SAMPLE = Structure(
    "Sample",
    "One moment of telemetry. Torques and speed are in the units that identity gives and hold at the "
    "ends of the range.",
    (
        raw("offset_counts", "i16", "position behind the base", "count"),
        raw("speed", "i16", "estimated", "speed_step_rad_s"),
        raw("desired_torque", "i16", "torque that the scene asks for", "torque_step_nm"),
        raw("motor_command", "i16", "asked of the motor", "torque_step_nm"),
        raw("brake_capacity", "i16", "most that the brake can hold, estimated", "torque_step_nm"),
        raw("spring_torque", "i16", "of the shaft on the knob, sensed", "torque_step_nm"),
    ),
)
TELEMETRY = Structure(
    "Telemetry",
    "Samples at equal distances. A gap between two reports shows in their ticks.",
    (
        raw(
            "axis_samples", "u8",
            "low four bits: axis, 0; high four bits: how many samples are filled", "",
            0x10, 0x4F, default=0x10,
        ),
        raw("decimation", "u8", "ticks from one sample to the next"),
        raw("flags", "u8", "bits, see above, of all samples together"),
        raw("tick", "u64", "of the first sample"),
        raw("base_counts", "i32", "low 32 bits of the first sample's position", "count"),
        on_wire(group("sample", SAMPLE, count=SAMPLES_PER_REPORT)),
    ),
    id=0x40,
    direction="input",
)  # fmt: skip
ACKNOWLEDGEMENT = Structure(
    "Acknowledgement",
    "Answer to a report.",
    (
        raw("sequence", "u16", "of the report that is answered"),
        raw("report", "u8", "its id"),
        raw("status", "u8", "0: accepted; otherwise the reason, see above"),
        raw(
            "field", "u8", "index of the offending field, nested fields opened; 255 is none",
            default="kNoField",
        ),
        on_wire(choice("state", e.STATE, "after the report")),
        raw("tick", "u64", "when it took effect or was refused"),
        on_wire(choice("owner", e.OWNER, "owner of the actuator after the report")),
    ),
    id=0x41,
    direction="input",
)  # fmt: skip
EVENT = Structure(
    "Event",
    "Something that the host did not ask for.",
    (
        on_wire(choice("kind", e.EVENT_KIND, "kind of event")),
        on_wire(choice("state", e.STATE, "after the event")),
        raw("faults", "u16", "bits, see above"),
        raw("tick", "u64", "when: control periods since power-up"),
        on_wire(choice("owner", e.OWNER, "owner of the actuator after the event")),
    ),
    id=0x42,
    direction="input",
)

ALL_REPORTS = (
    IDENTITY, CLOCK, HEALTH, *CONFIGURATIONS, GAME_MONITOR, LEDGER, MOTOR_CURRENT, COMMAND, COMMIT, STREAM, LOCAL_MODEL, EXCITATION,
    *EFFECTS,
    CURVE_POINTS, TELEMETRY, ACKNOWLEDGEMENT, EVENT,
)  # fmt: skip
"""Every report, in the order of the documentation and of the fingerprint."""

__all__ = ["ALL_REPORTS", "CURVE_POOL_POINTS", "MAX_EFFECTS", "PROTOCOL_VERSION"]
