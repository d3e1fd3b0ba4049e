"""The effects of a scene: one report each, one class each in C++ and Python."""

from __future__ import annotations

import math
from collections.abc import Mapping

from firmware.protocol.definition import enumerations as e
from firmware.protocol.definition.constants import (
    CURVE_POINTS_PER_REPORT,
    CURVE_POOL_POINTS,
    MAX_CYCLES_PER_TURN_Q32,
    MAX_DAMPING_NM_S_PER_RAD,
    MAX_EFFECTS,
    MAX_INERTIA_KG_M2,
    MAX_SPAN_TURNS_Q32,
    MAX_STIFFNESS_NM_PER_RAD,
    MAX_TIME_S,
    MAX_TORQUE_NM,
    MAX_TURNS_Q32,
    MIN_SPAN_TURNS_Q32,
)
from tools.definition.model import (
    Bound,
    Field,
    Structure,
    angle,
    any_whole,
    choice,
    for_hosts,
    group,
    not_below,
    number,
    numbers,
    on_wire,
    optional_number,
    raw,
    required,
    surface,
    whole,
)


def angle_rad(name: str, doc: str) -> Field:
    """Make an angle from the device's zero."""
    return angle(name, doc, MAX_TURNS_Q32)


def stiffness(doc: str = "", *, low: Bound = 0.0, default: Bound | None = None) -> Field:
    """Make a stiffness."""
    return number(
        "stiffness_nm_per_rad", "N m/rad", low, MAX_STIFFNESS_NM_PER_RAD, doc, default=default
    )


def damping(doc: str = "", *, required: bool = False) -> Field:
    """Make a damping."""
    return number(
        "damping_nm_s_per_rad", "N m s/rad", 0.0, MAX_DAMPING_NM_S_PER_RAD, doc, required=required
    )


def torque(name: str, doc: str = "", *, low: Bound = 0.0, default: Bound | None = None) -> Field:
    """Make a torque on the knob."""
    return number(name, "N m", low, MAX_TORQUE_NM, doc, default=default)


TORQUE_LIMIT = torque(
    "torque_limit_nm", "the torque does not grow beyond this", default=MAX_TORQUE_NM
)

TARGET = Structure(
    "Target",
    "Where an effect belongs.",
    (
        raw("sequence", "u16", "returned in the acknowledgement"),
        raw("axis", "u8", "0: an interface has one axis"),
        raw("slot", "u8", "place in the scene", "", 0, int(MAX_EFFECTS.value) - 1),
    ),
)

TIMING = Structure(
    "Timing",
    "When an effect plays, and how its strength comes and goes.",
    (
        number("delay_s", "s", 0.0, MAX_TIME_S, "silence after the scene begins"),
        number("duration_s", "s", 0.0, MAX_TIME_S, "0 plays without end"),
        number("attack_level", "", 0.0, 1.0, "share of the strength at the start", default=1.0),
        number("attack_s", "s", 0.0, MAX_TIME_S, "time to full strength"),
        number("fade_level", "", 0.0, 1.0, "share of the strength at the end", default=1.0),
        number("fade_s", "s", 0.0, MAX_TIME_S, "fading time before the end"),
    ),
)

_PLACE = on_wire(group("target", TARGET))
_TIMING = group("timing", TIMING, "when it plays, and its envelope")


def _effect(
    id: int,
    name: str,
    doc: str,
    *fields: Field,
    wire_doc: str = "",
    example: Mapping[str, object] | None = None,
) -> Structure:
    return Structure(
        name, doc, (_PLACE, *fields),
        id=id, direction="output", wire_doc=wire_doc, base="Effect", example=example,
    )  # fmt: skip


WALL = _effect(
    0x20,
    "Wall",
    "A virtual wall: inside it, stiffness times depth plus damping times inward speed, never a pull.",
    surface(angle_rad("angle_rad", "the wall's surface")),
    choice("side", e.SIDE, "on which side of the surface the wall is solid"),
    stiffness("torque per depth"),
    damping("torque per inward speed"),
    example={"angle_rad": 0.3, "stiffness_nm_per_rad": 1.4, "damping_nm_s_per_rad": 0},
)
SPRING = _effect(
    0x21,
    "Spring",
    "A spring to an angle, with an optional dead band.",
    angle_rad("angle_rad", "rest angle"),
    stiffness("torque per distance from the rest angle"),
    number("deadband_rad", "rad", 0.0, 1e3, "no torque within this distance of the rest angle"),
    TORQUE_LIMIT,
    example={"stiffness_nm_per_rad": 0.1},
)
DAMPER = _effect(
    0x22,
    "Damper",
    "Torque against the speed.",
    damping("torque per speed", required=True),
    TORQUE_LIMIT,
    example={"damping_nm_s_per_rad": 2e-3},
)
FRICTION = _effect(
    0x23,
    "Friction",
    "Dry friction that sticks: a spring to an anchor that is dragged along once the torque is reached.",
    torque("torque_nm", "while sliding"),
    stiffness("while sticking", low=1e-6, default=1.0),
    example={"torque_nm": 0.02},
)
INERTIA = _effect(
    0x24,
    "Inertia",
    "Torque against the acceleration.",
    number(
        "inertia_kg_m2", "kg m^2", 0.0, MAX_INERTIA_KG_M2, "torque per acceleration", required=True
    ),
    TORQUE_LIMIT,
    example={"inertia_kg_m2": 5e-5},
)
CONSTANT = _effect(
    0x25,
    "Constant",
    "A constant torque.",
    torque("torque_nm", "at full strength", low=-MAX_TORQUE_NM),
    _TIMING,
    example={"torque_nm": 0.02},
)
RAMP = _effect(
    0x26,
    "Ramp",
    "A torque that goes from start to end over the duration in `timing`, which must not be 0.",
    torque("start_torque_nm", "when the duration begins", low=-MAX_TORQUE_NM),
    torque("end_torque_nm", "when it ends", low=-MAX_TORQUE_NM),
    _TIMING,
    example={"start_torque_nm": 0, "end_torque_nm": 0.04, "timing": {"duration_s": 1}},
)
PERIODIC = _effect(
    0x27,
    "Periodic",
    "A torque that repeats in time. The envelope acts on the amplitude, not on the offset.",
    choice("waveform", e.WAVEFORM, "starts at 0 and rises; the square starts high"),
    torque("amplitude_nm", "of the wave, from its middle"),
    torque("offset_nm", "the wave's middle", low=-MAX_TORQUE_NM, default=0.0),
    number("frequency_hz", "Hz", 0.0, 1e4, "at most half the control rate", required=True),
    number("phase_turns", "turn", 0.0, 1.0, "where in the period it starts"),
    _TIMING,
    example={"amplitude_nm": 0.02, "frequency_hz": 2},
)
DETENTS = _effect(
    0x28,
    "Detents",
    "Notches at equal distances. Give exactly one of `per_turn` and `pitch_rad`.",
    angle_rad("angle_rad", "where one of the notches is"),
    raw(
        "per_turn_q32", "u64", "notches in a turn; at most half the encoder's counts", "2^-32",
        1, MAX_CYCLES_PER_TURN_Q32, default=24 << 32,
    ),
    optional_number("per_turn", "", "notches in a turn, > 0; need not be whole"),
    optional_number("pitch_rad", "rad", "distance of two notches, > 0"),
    torque("torque_nm", "largest torque"),
    choice("profile", e.DETENT_PROFILE, "torque from one notch to the next"),
    number("width", "", 0.01, 1.0, "share of the pitch; click only", default=0.5),
    wire_doc="Notches at equal distances. Torque at u pitches from a notch: sine -T sin(2 pi u), linear "
    "-2 T u within half a pitch, click linear within the width and T toward the notch beyond it.",
    example={"per_turn": 24, "torque_nm": 0.03},
)  # fmt: skip
END_STOPS = _effect(
    0x29,
    "EndStops",
    "Two walls that bound the range between them.",
    surface(required(angle_rad("lower_rad", "surface of the lower wall"))),
    not_below(
        "lower_rad",
        surface(
            required(angle_rad("upper_rad", "surface of the upper one, not below the lower one"))
        ),
    ),
    stiffness("torque per depth, of either wall"),
    damping("torque per inward speed, of either wall"),
    example={"lower_rad": -0.8, "upper_rad": 0.8, "stiffness_nm_per_rad": 1.4},
)
TEXTURE = _effect(
    0x2A,
    "Texture",
    "A rough surface fixed to the knob, the same in every turn.",
    whole("grains_per_turn", "u16", 1, 0xFFFF, "at most half the encoder's counts", default=None),
    torque("torque_nm", "of the highest grain"),
    choice("grain", e.GRAIN, "shape of a grain", default="noise"),
    any_whole("seed", "u32", "another seed, another surface; noise only"),
    wire_doc="A rough surface fixed to the knob, the same in every turn. sine, square and triangle "
    "repeat with each grain; noise draws a value between -T and T per grain and joins them smoothly.",
    example={"grains_per_turn": 120, "torque_nm": 0.01},
)
CURVE = _effect(
    0x2B,
    "Curve",
    "A torque over angle, linear between equally spaced points on [angle_rad, angle_rad + span_rad].",
    numbers("torque_nm", "N m", "at least 2 points; all curves of a scene share 1024"),
    angle_rad("angle_rad", "angle of the first point"),
    raw(
        "span_turns_q32", "u64", "from the first point to the last; at least two of the encoder's "
        "counts", "2^-32 turn", MIN_SPAN_TURNS_Q32, MAX_SPAN_TURNS_Q32, default=1 << 32,
    ),
    for_hosts(
        number(
            "span_rad", "rad", 0.0, int(MAX_SPAN_TURNS_Q32.value) / 2**32 * math.tau,
            "from the first point to the last; at least two of the encoder's counts", default=1.0,
        )
    ),
    choice("ends", e.ENDS, "its torque outside the span"),
    raw("first_point", "u16", "index in the pool", "", 0, int(CURVE_POOL_POINTS.value) - 2),
    raw("points", "u16", "", "", 2, CURVE_POOL_POINTS, default=2),
    wire_doc="A torque over angle, linear between points of the pool. Outside its span it holds its "
    "end values or repeats.",
    example={"span_rad": 1, "torque_nm": [0, 0.03, 0, -0.03, 0]},
)  # fmt: skip
IMPACT = _effect(
    0x2C,
    "Impact",
    "The knock of something hard, in proportion to the knob's speed into the surface: a decaying sine, "
    "and a pulse that brakes. It acts inside only. At control rates from 4 kHz it gives back no more "
    "energy than it took, within one count, unless it needs the whole supply or the motor is over 2.5 "
    "times as slow as configured.",
    angle_rad("angle_rad", "the surface, usually a wall's"),
    choice("side", e.SIDE, "on which side of the surface it is solid"),
    number(
        "strength_nm_s_per_rad", "N m s/rad", 0.0, MAX_DAMPING_NM_S_PER_RAD,
        "the sine's torque at first, per speed of impact",
    ),
    number(
        "frequency_hz", "Hz", 1.0, 1e3, "of the sine; at most half the control rate", default=300.0
    ),
    number("decay_s", "s", 1e-4, 0.1, "in which the sine falls to 1/e", default=5e-3),
    number(
        "pulse_nm_s_per_rad", "N m s/rad", 0.0, MAX_DAMPING_NM_S_PER_RAD,
        "the pulse's torque, per speed of impact",
    ),
    number(
        "pulse_s", "s", 0.0, 0.1, "how long the pulse lasts; it ends where the knob stops",
        default=5e-3,
    ),
    TORQUE_LIMIT,
    example={"angle_rad": 0.3, "strength_nm_s_per_rad": 0.02, "pulse_nm_s_per_rad": 0.01},
)  # fmt: skip

EFFECTS = (
    WALL, SPRING, DAMPER, FRICTION, INERTIA, CONSTANT, RAMP, PERIODIC, DETENTS, END_STOPS, TEXTURE,
    CURVE, IMPACT,
)  # fmt: skip
"""Every effect, in the order of the documentation and of the variants."""

CURVE_POINTS = Structure(
    "CurvePoints",
    "Writes points into the pool of the scene that is being built.",
    (
        raw("sequence", "u16", "returned in the acknowledgement"),
        raw("axis", "u8", "0: an interface has one axis"),
        raw("first_point", "u16", "index in the pool", "", 0, int(CURVE_POOL_POINTS.value) - 1),
        raw(
            "points", "u8", "how many of the values count", "", 1, CURVE_POINTS_PER_REPORT, default=1
        ),
        raw(
            "torque_nm", "f32", "", "N m", -MAX_TORQUE_NM, MAX_TORQUE_NM,
            count=CURVE_POINTS_PER_REPORT,
        ),
    ),
    id=0x2F,
    direction="output",
)  # fmt: skip
