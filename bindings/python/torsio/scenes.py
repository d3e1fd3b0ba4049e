"""Scenes: what the knob shall feel like.

A scene is one effect or a list of up to 16, whose torques add up. Torques are torques on the knob,
positive along positive angle; angles are measured from the device's zero. All quantities are in SI
units, named by the suffix, and given by keyword.

The classes only hold values. Their ranges are checked when they are played, before anything is
sent to the device.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass
from typing import Literal, TypeAlias

from torsio import checks

__all__ = [
    "Constant",
    "Curve",
    "Damper",
    "Detents",
    "Effect",
    "EndStops",
    "Friction",
    "Inertia",
    "Periodic",
    "Ramp",
    "Scene",
    "Spring",
    "Texture",
    "Timing",
    "Wall",
]

MAX_TORQUE_NM = 100.0
"""Largest torque of any effect. The actuator's own limits are lower."""


@dataclass(frozen=True)
class Timing:
    """When an effect plays, and how its strength comes and goes.

    Attributes
    ----------
    delay_s
        Silence after the scene begins, >= 0.
    duration_s
        0 plays without end.
    attack_level, attack_s
        Share of the strength at the start, 0 to 1, and the time to full strength.
    fade_level, fade_s
        Share of the strength at the end, 0 to 1, and the fading time before the end.
    """

    _: KW_ONLY
    delay_s: float = 0.0
    duration_s: float = 0.0
    attack_level: float = 1.0
    attack_s: float = 0.0
    fade_level: float = 1.0
    fade_s: float = 0.0


class Effect:
    """Base class of all effects."""

    __slots__ = ()


class _Timed(Effect):
    """Base class of effects that come and go in time."""

    timing: Timing

    def __post_init__(self) -> None:
        """Ask for a `Timing`, for None is a likely slip."""
        checks.kind("timing", self.timing, Timing, "a torsio.Timing")


Scene: TypeAlias = Effect | Iterable[Effect]
"""What `Knob.play` takes."""


@dataclass(frozen=True)
class Wall(Effect):
    """A virtual wall: stiffness times depth plus damping times inward speed, never a pull.

    Attributes
    ----------
    angle_rad
        The wall's surface.
    side
        On which side of the surface the wall is solid.
    """

    _: KW_ONLY
    stiffness_nm_per_rad: float
    angle_rad: float = 0.0
    damping_nm_s_per_rad: float = 0.0
    side: Literal["above", "below"] = "above"


@dataclass(frozen=True)
class Spring(Effect):
    """A spring to an angle, with an optional dead band.

    Attributes
    ----------
    angle_rad
        Rest angle.
    deadband_rad
        No torque within this distance of the rest angle.
    torque_limit_nm
        The torque does not grow beyond this.
    """

    _: KW_ONLY
    stiffness_nm_per_rad: float
    angle_rad: float = 0.0
    deadband_rad: float = 0.0
    torque_limit_nm: float = MAX_TORQUE_NM


@dataclass(frozen=True)
class Damper(Effect):
    """Torque against the speed."""

    _: KW_ONLY
    damping_nm_s_per_rad: float
    torque_limit_nm: float = MAX_TORQUE_NM


@dataclass(frozen=True)
class Friction(Effect):
    """Dry friction that sticks: a spring to an anchor that is dragged along.

    Attributes
    ----------
    torque_nm
        While sliding.
    stiffness_nm_per_rad
        While sticking, > 0.
    """

    _: KW_ONLY
    torque_nm: float
    stiffness_nm_per_rad: float = 1.0


@dataclass(frozen=True)
class Inertia(Effect):
    """Torque against the acceleration."""

    _: KW_ONLY
    inertia_kg_m2: float
    torque_limit_nm: float = MAX_TORQUE_NM


@dataclass(frozen=True)
class Constant(_Timed):
    """A constant torque."""

    _: KW_ONLY
    torque_nm: float
    timing: Timing = Timing()


@dataclass(frozen=True)
class Ramp(_Timed):
    """A torque that goes from start to end over `timing.duration_s`, which must not be 0."""

    _: KW_ONLY
    start_torque_nm: float
    end_torque_nm: float
    timing: Timing = Timing()


@dataclass(frozen=True)
class Periodic(_Timed):
    """A torque that repeats in time. The envelope acts on the amplitude, not on the offset.

    Attributes
    ----------
    frequency_hz
        At most half the control rate.
    phase_turns
        Where in the period it starts, 0 to 1.
    """

    _: KW_ONLY
    amplitude_nm: float
    frequency_hz: float
    waveform: Literal["sine", "square", "triangle", "sawtooth_up", "sawtooth_down"] = "sine"
    offset_nm: float = 0.0
    phase_turns: float = 0.0
    timing: Timing = Timing()


@dataclass(frozen=True)
class Detents(Effect):
    """Notches at equal distances. Give exactly one of `per_turn` and `pitch_rad`.

    Attributes
    ----------
    torque_nm
        Largest torque.
    per_turn
        Notches in a turn, > 0; need not be whole.
    pitch_rad
        Distance of two notches, > 0.
    angle_rad
        Where one of the notches is.
    profile
        "sine", "linear", or "click": linear within the width, beyond it full torque toward the
        notch.
    width
        Share of the pitch, 0.01 to 1; click only.
    """

    _: KW_ONLY
    torque_nm: float
    per_turn: float | None = None
    pitch_rad: float | None = None
    angle_rad: float = 0.0
    profile: Literal["sine", "linear", "click"] = "sine"
    width: float = 0.5


@dataclass(frozen=True)
class EndStops(Effect):
    """Two walls that bound the range between them."""

    _: KW_ONLY
    lower_rad: float
    upper_rad: float
    stiffness_nm_per_rad: float
    damping_nm_s_per_rad: float = 0.0


@dataclass(frozen=True)
class Texture(Effect):
    """A rough surface fixed to the knob, the same in every turn.

    Attributes
    ----------
    grains_per_turn
        1 to half the encoder's counts.
    seed
        Another seed, another surface; noise only.
    """

    _: KW_ONLY
    torque_nm: float
    grains_per_turn: int
    grain: Literal["sine", "square", "triangle", "noise"] = "noise"
    seed: int = 0


@dataclass(frozen=True)
class Curve(Effect):
    """A torque over angle, linear between equally spaced points.

    Attributes
    ----------
    torque_nm
        At least 2 points; all curves of a scene share 1024. Any iterable of numbers.
    angle_rad
        Angle of the first point.
    span_rad
        From the first point to the last.
    ends
        Outside the span: "hold" the end values, or "repeat".
    """

    _: KW_ONLY
    torque_nm: Iterable[float]
    angle_rad: float = 0.0
    span_rad: float = 1.0
    ends: Literal["hold", "repeat"] = "hold"

    def __post_init__(self) -> None:
        """Keep the points as a tuple, so that curves compare and hash by value."""
        object.__setattr__(self, "torque_nm", checks.numbers("torque_nm", self.torque_nm))
