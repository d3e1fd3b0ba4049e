"""Scenes: what the knob shall feel like.

A scene is one effect or a list of up to 16, whose torques add up. Torques are torques on the knob,
positive along positive angle; angles are measured from the device's zero. All quantities are in SI
units, named by the suffix, and given by keyword.

The classes only hold values. Their ranges are checked when they are played, before anything is
sent to the device.
"""

# Printed from the field lists in firmware/protocol/definition/ by `./dev generate`;
# change those instead.

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass
from typing import Literal, TypeAlias

from torsio.common import checks
from torsio.printed.effect_methods import EffectMethods

__all__ = [
    "Constant",
    "Curve",
    "Damper",
    "Detents",
    "Effect",
    "EndStops",
    "Excitation",
    "Friction",
    "Impact",
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


class Effect(EffectMethods):
    """Base class of all effects."""

    __slots__ = ()


Scene: TypeAlias = Effect | Iterable[Effect]
"""Effects for `Knob.play`."""


@dataclass(frozen=True, repr=False)
class Timing(checks.ByName):
    """When an effect plays, and how its strength comes and goes.

    Attributes
    ----------
    delay_s
        Silence after the scene begins; 0 to 1e5.
    duration_s
        0 plays without end; 0 to 1e5.
    attack_level
        Share of the strength at the start; 0 to 1.
    attack_s
        Time to full strength; 0 to 1e5.
    fade_level
        Share of the strength at the end; 0 to 1.
    fade_s
        Fading time before the end; 0 to 1e5.
    """

    _: KW_ONLY
    delay_s: float = 0.0
    duration_s: float = 0.0
    attack_level: float = 1.0
    attack_s: float = 0.0
    fade_level: float = 1.0
    fade_s: float = 0.0


@dataclass(frozen=True, repr=False)
class Wall(Effect):
    """A virtual wall.

    Inside it, stiffness times depth plus damping times inward speed, never a pull.

    Attributes
    ----------
    angle_rad
        The wall's surface.
    side
        On which side of the surface the wall is solid.
    stiffness_nm_per_rad
        Torque per depth; 0 to 1e6.
    damping_nm_s_per_rad
        Torque per inward speed; 0 to 1000.
    """

    _: KW_ONLY
    stiffness_nm_per_rad: float
    angle_rad: float = 0.0
    side: Literal["above", "below"] = "above"
    damping_nm_s_per_rad: float = 0.0


@dataclass(frozen=True, repr=False)
class Spring(Effect):
    """A spring to an angle, with an optional dead band.

    Attributes
    ----------
    angle_rad
        Rest angle.
    stiffness_nm_per_rad
        Torque per distance from the rest angle; 0 to 1e6.
    deadband_rad
        No torque within this distance of the rest angle; 0 to 1000.
    torque_limit_nm
        The torque does not grow beyond this; 0 to 100.
    """

    _: KW_ONLY
    stiffness_nm_per_rad: float
    angle_rad: float = 0.0
    deadband_rad: float = 0.0
    torque_limit_nm: float = MAX_TORQUE_NM


@dataclass(frozen=True, repr=False)
class Damper(Effect):
    """Torque against the speed.

    Attributes
    ----------
    damping_nm_s_per_rad
        Torque per speed; 0 to 1000.
    torque_limit_nm
        The torque does not grow beyond this; 0 to 100.
    """

    _: KW_ONLY
    damping_nm_s_per_rad: float
    torque_limit_nm: float = MAX_TORQUE_NM


@dataclass(frozen=True, repr=False)
class Friction(Effect):
    """Dry friction that sticks.

    A spring to an anchor that is dragged along once the torque is reached.

    Attributes
    ----------
    torque_nm
        While sliding; 0 to 100.
    stiffness_nm_per_rad
        While sticking; 1e-6 to 1e6.
    """

    _: KW_ONLY
    torque_nm: float
    stiffness_nm_per_rad: float = 1.0


@dataclass(frozen=True, repr=False)
class Inertia(Effect):
    """Torque against the acceleration.

    Attributes
    ----------
    inertia_kg_m2
        Torque per acceleration; 0 to 10.
    torque_limit_nm
        The torque does not grow beyond this; 0 to 100.
    """

    _: KW_ONLY
    inertia_kg_m2: float
    torque_limit_nm: float = MAX_TORQUE_NM


@dataclass(frozen=True, repr=False)
class Constant(Effect):
    """A constant torque.

    Attributes
    ----------
    torque_nm
        At full strength; -100 to 100.
    timing
        When it plays, and its envelope.
    """

    _: KW_ONLY
    torque_nm: float
    timing: Timing = Timing()

    def __post_init__(self) -> None:
        """Ask for the right kinds, and keep sequences so that they compare by value."""
        checks.kind("timing", self.timing, Timing, "a torsio.Timing")


@dataclass(frozen=True, repr=False)
class Ramp(Effect):
    """A torque that goes from start to end over the duration in `timing`, which must not be 0.

    Attributes
    ----------
    start_torque_nm
        When the duration begins; -100 to 100.
    end_torque_nm
        When it ends; -100 to 100.
    timing
        When it plays, and its envelope.
    """

    _: KW_ONLY
    start_torque_nm: float
    end_torque_nm: float
    timing: Timing = Timing()

    def __post_init__(self) -> None:
        """Ask for the right kinds, and keep sequences so that they compare by value."""
        checks.kind("timing", self.timing, Timing, "a torsio.Timing")


@dataclass(frozen=True, repr=False)
class Periodic(Effect):
    """A torque that repeats in time. The envelope acts on the amplitude, not on the offset.

    Attributes
    ----------
    waveform
        Starts at 0 and rises; the square starts high.
    amplitude_nm
        Of the wave, from its middle; 0 to 100.
    offset_nm
        The wave's middle; -100 to 100.
    frequency_hz
        At most half the control rate; 0 to 1e4.
    phase_turns
        Where in the period it starts; 0 to 1.
    timing
        When it plays, and its envelope.
    """

    _: KW_ONLY
    amplitude_nm: float
    frequency_hz: float
    waveform: Literal["sine", "square", "triangle", "sawtooth_up", "sawtooth_down"] = "sine"
    offset_nm: float = 0.0
    phase_turns: float = 0.0
    timing: Timing = Timing()

    def __post_init__(self) -> None:
        """Ask for the right kinds, and keep sequences so that they compare by value."""
        checks.kind("timing", self.timing, Timing, "a torsio.Timing")


@dataclass(frozen=True, repr=False)
class Detents(Effect):
    """Notches at equal distances. Give exactly one of `per_turn` and `pitch_rad`.

    Attributes
    ----------
    angle_rad
        Where one of the notches is.
    per_turn
        Notches in a turn, > 0; need not be whole.
    pitch_rad
        Distance of two notches, > 0.
    torque_nm
        Largest torque; 0 to 100.
    profile
        Torque from one notch to the next.
    width
        Share of the pitch; click only; 0.01 to 1.
    """

    _: KW_ONLY
    torque_nm: float
    angle_rad: float = 0.0
    per_turn: float | None = None
    pitch_rad: float | None = None
    profile: Literal["sine", "linear", "click"] = "sine"
    width: float = 0.5


@dataclass(frozen=True, repr=False)
class EndStops(Effect):
    """Two walls that bound the range between them.

    Attributes
    ----------
    lower_rad
        Surface of the lower wall.
    upper_rad
        Surface of the upper one, not below the lower one.
    stiffness_nm_per_rad
        Torque per depth, of either wall; 0 to 1e6.
    damping_nm_s_per_rad
        Torque per inward speed, of either wall; 0 to 1000.
    """

    _: KW_ONLY
    lower_rad: float
    upper_rad: float
    stiffness_nm_per_rad: float
    damping_nm_s_per_rad: float = 0.0


@dataclass(frozen=True, repr=False)
class Texture(Effect):
    """A rough surface fixed to the knob, the same in every turn.

    Attributes
    ----------
    grains_per_turn
        At most half the encoder's counts; 1 to 65535.
    torque_nm
        Of the highest grain; 0 to 100.
    grain
        Shape of a grain.
    seed
        Another seed, another surface; noise only.
    """

    _: KW_ONLY
    grains_per_turn: int
    torque_nm: float
    grain: Literal["sine", "square", "triangle", "noise"] = "noise"
    seed: int = 0


@dataclass(frozen=True, repr=False)
class Curve(Effect):
    """A torque over angle.

    Linear between equally spaced points on [angle_rad, angle_rad + span_rad].

    Attributes
    ----------
    torque_nm
        At least 2 points; all curves of a scene share 1024.
    angle_rad
        Angle of the first point.
    span_rad
        From the first point to the last; at least two of the encoder's counts; 0 to 804.247719.
    ends
        Its torque outside the span.
    """

    _: KW_ONLY
    torque_nm: Iterable[float]
    angle_rad: float = 0.0
    span_rad: float = 1.0
    ends: Literal["hold", "repeat"] = "hold"

    def __post_init__(self) -> None:
        """Ask for the right kinds, and keep sequences so that they compare by value."""
        object.__setattr__(self, "torque_nm", checks.numbers("torque_nm", self.torque_nm))


@dataclass(frozen=True, repr=False)
class Impact(Effect):
    """The knock of something hard, in proportion to the knob's speed into the surface.

    A decaying sine, and a pulse that brakes. It acts inside only. At control rates from 4 kHz it
    gives back no more energy than it took, within one count, unless it needs the whole supply or
    the motor is over 2.5 times as slow as configured.

    Attributes
    ----------
    angle_rad
        The surface, usually a wall's.
    side
        On which side of the surface it is solid.
    strength_nm_s_per_rad
        The sine's torque at first, per speed of impact; 0 to 1000.
    frequency_hz
        Of the sine; at most half the control rate; 1 to 1000.
    decay_s
        In which the sine falls to 1/e; 1e-4 to 0.1.
    pulse_nm_s_per_rad
        The pulse's torque, per speed of impact; 0 to 1000.
    pulse_s
        How long the pulse lasts; it ends where the knob stops; 0 to 0.1.
    torque_limit_nm
        The torque does not grow beyond this; 0 to 100.
    """

    _: KW_ONLY
    angle_rad: float = 0.0
    side: Literal["above", "below"] = "above"
    strength_nm_s_per_rad: float = 0.0
    frequency_hz: float = 300.0
    decay_s: float = 0.005
    pulse_nm_s_per_rad: float = 0.0
    pulse_s: float = 0.005
    torque_limit_nm: float = MAX_TORQUE_NM


@dataclass(frozen=True, repr=False)
class Excitation(checks.ByName):
    """A bounded experiment: commands of motor and brake that go past scene and law.

    Both commands move in a straight line from where the last excitation is now. The motor also gets
    a sine and the torque of a servo, `servo_stiffness (reference - angle) + servo_damping
    (reference' - speed)`. The device disarms when a bound is left, or when the time is over and no
    next one has come. It also disarms when the servo asks for all of the motor for 50 ms and the
    encoder stands still.

    Attributes
    ----------
    duration_s
        Until it disarms, unless the next one comes first; 0.001 to 60.
    travel_rad
        Further from its first angle disarms; 0.001 to 1000.
    speed_limit_rad_s
        Faster disarms; 0.1 to 1e4.
    torque_limit_nm
        Largest torque of the motor; 0 to 100.
    motor_command_nm
        Where the motor goes; -100 to 100.
    brake_command_nm
        Where the brake's command goes; 0 to 100.
    ramp_s
        Time that both take; 0 is a step; 0 to 60.
    sine_nm
        Amplitude of the sine on top of `motor_command_nm`; 0 to 100.
    sine_begin_hz
        Its frequency at the beginning; 0 to 1000.
    sine_end_hz
        And after `duration_s`; 0 to 1000.
    stiffness_nm_per_rad
        Of the servo; 0 to 1e6.
    damping_nm_s_per_rad
        Of the servo; 0 to 1000.
    servo_rad_s
        Speed of the servo's reference; -1000 to 1000.
    """

    _: KW_ONLY
    duration_s: float
    travel_rad: float
    speed_limit_rad_s: float
    torque_limit_nm: float
    motor_command_nm: float = 0.0
    brake_command_nm: float = 0.0
    ramp_s: float = 0.0
    sine_nm: float = 0.0
    sine_begin_hz: float = 0.0
    sine_end_hz: float = 0.0
    stiffness_nm_per_rad: float = 0.0
    damping_nm_s_per_rad: float = 0.0
    servo_rad_s: float = 0.0
