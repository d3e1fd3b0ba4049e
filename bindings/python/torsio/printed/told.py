"""A knob's reports about itself: identity, clock, health, and the state of the cable."""

# Printed from the field lists in firmware/protocol/definition/ by `./dev generate`;
# change those instead.

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

__all__ = [
    "Clock",
    "DeviceInfo",
    "Disarm",
    "Energies",
    "Event",
    "GameEffect",
    "GameStatus",
    "Health",
    "Limits",
    "LinkStatistics",
    "ListedDevice",
    "MotorCurrent",
    "StableStiffness",
    "State",
]

State: TypeAlias = Literal["disarmed", "armed", "fault", "disconnected"]
"""Whether the device makes torque."""


@dataclass(frozen=True)
class ListedDevice:
    """A device that could be opened.

    Attributes
    ----------
    path
        Path for open()
    serial
        Serial number.
    product
        As its maker calls it.
    board
        Empty if the device could not be asked.
    transport
        "hid" or "emulated".
    problem
        Why it cannot be opened now; empty if it can.
    """

    path: str
    serial: str
    product: str
    board: str
    transport: str
    problem: str


@dataclass(frozen=True)
class DeviceInfo:
    """Identity and abilities of the device.

    Attributes
    ----------
    path
        Path for open()
    serial
        Serial number.
    product
        As its maker calls it.
    board
        "pico2", "emulated", ...
    firmware_version
        "major.minor.patch".
    transport
        "hid", "emulated" or "own", a transport that the program brings.
    protocol_version
        Of the reports.
    fingerprint
        Of the report layouts, the same as the library's.
    axes
        Actuators behind this interface.
    effects
        Places in a scene.
    curve_points
        Shared by all curves of a scene.
    control_rate_hz
        Ticks in a second.
    counts_per_rev
        Of the encoder.
    torque_step_nm
        Resolution of telemetry's torques.
    speed_step_rad_s
        Resolution of telemetry's speed.
    """

    path: str
    serial: str
    product: str
    board: str
    firmware_version: str
    transport: str
    protocol_version: int
    fingerprint: int
    axes: int
    effects: int
    curve_points: int
    control_rate_hz: float
    counts_per_rev: int
    torque_step_nm: float
    speed_step_rad_s: float


@dataclass(frozen=True)
class Clock:
    """The device's time and position, both exact.

    Attributes
    ----------
    tick
        Control periods since power-up.
    time_s
        Tick times the control period.
    position_counts
        From the device's zero, never wraps.
    angle_rad
        The same as an angle.
    """

    tick: int
    time_s: float
    position_counts: int
    angle_rad: float


@dataclass(frozen=True)
class Health:
    """State and counters of the device since its power-up.

    Attributes
    ----------
    state
        Whether it makes torque.
    faults
        Names of the latched faults: "over_speed", ...
    reports_accepted
        That did what they asked.
    reports_refused
        That changed nothing.
    samples_dropped
        Telemetry that the host did not fetch in time.
    tick_overruns
        Ticks that were missed.
    tick_time_s
        Time that the last control tick took.
    tick_time_max_s
        Longest tick so far.
    saves
        How often the configuration was saved, ever.
    owner
        Owner of the actuator.
    reset_cause
        Why the device started.
    unexpected_swings
        Swings of the law `calibrated` that lasted in scenes which the configured parts can render,
        and four for a ring, since the knob was configured, less one for fifty turns.
    centre
        Where angle 0 comes from.
    """

    state: Literal["disarmed", "armed", "fault", "disconnected"]
    faults: tuple[str, ...]
    reports_accepted: int
    reports_refused: int
    samples_dropped: int
    tick_overruns: int
    tick_time_s: float
    tick_time_max_s: float
    saves: int
    owner: Literal["none", "sdk", "game", "dial"]
    reset_cause: Literal[
        "unknown", "power", "brown_out", "reset_pin", "watchdog", "hard_fault", "stack"
    ]
    unexpected_swings: int
    centre: Literal["power_up", "awaits_index", "index"]


@dataclass(frozen=True)
class Energies:
    """Energies that the law `calibrated` has counted since it was chosen.

    The hand feels the motor's energy, the shaft stores it, or the brake takes it.

    Attributes
    ----------
    tick
        Of this moment: control periods since power-up.
    time_s
        Tick times the control period.
    kept
        The law keeps count; else all stand still.
    motor_j
        Given to the knob by the motor.
    felt_j
        Given to the knob by motor and shaft together, which a hand feels.
    stored_j
        In the shaft's spring now.
    brake_j
        Taken by the brake.
    bound_nm_per_rad
        The stiffest that is rendered now, found out from the knob's swings; 0: no bound.
    """

    tick: int
    time_s: float
    kept: bool
    motor_j: float
    felt_j: float
    stored_j: float
    brake_j: float
    bound_nm_per_rad: float


@dataclass(frozen=True)
class MotorCurrent:
    """Sums of the motor's current readings and of its bridge's shares since the board started.

    The difference of two readings covers everything in between.

    Attributes
    ----------
    measured
        There is a current sensor; without one the other fields are 0.
    time_s
        Periods of the current loop since the board started.
    angle_rad
        At the newest tick.
    period_s
        Of the current loop.
    delay_s
        From a measurement to the voltage that answers it.
    periods
        Done, each with one measurement.
    current_a
        The newest measurement, without its zero.
    zero_a
        Reading without current.
    step_a
        Of the converter.
    current_sum_a
        Of all measurements, each with its zero.
    share
        Share of the supply's voltage that answers it.
    share_before
        Share before it.
    share_sum
        Sum of all shares, positive to larger angles.
    torque_constant_nm_per_a
        That the board reckons with: what it was configured to when it started.
    """

    measured: bool
    time_s: float
    angle_rad: float
    period_s: float
    delay_s: float
    periods: int
    current_a: float
    zero_a: float
    step_a: float
    current_sum_a: float
    share: float
    share_before: float
    share_sum: float
    torque_constant_nm_per_a: float


@dataclass(frozen=True)
class Limits:
    """The most that the device gives, by its configuration as it is now.

    Attributes
    ----------
    motor_torque_max_nm
        Of the motor, for seconds.
    motor_torque_continuous_max_nm
        The same for ever, as its winding stands it.
    brake_torque_max_nm
        Of the brake.
    speed_limit_rad_s
        More is a fault; 0: no limit.
    held_low
        The board gives little, because nobody has confirmed its parts, or because their values are
        assumed; `confirmed` and a calibration end it.
    """

    motor_torque_max_nm: float
    motor_torque_continuous_max_nm: float
    brake_torque_max_nm: float
    speed_limit_rad_s: float
    held_low: bool


@dataclass(frozen=True)
class StableStiffness:
    """How stiff a spring can be that a knob swings in and still comes to rest.

    Attributes
    ----------
    stiffness_nm_per_rad
        The stiffest such spring.
    limited_by
        The limit to improve: "rate" of the control, "lag" of the motor, "counts" of the encoder.
    """

    stiffness_nm_per_rad: float
    limited_by: str


@dataclass(frozen=True)
class GameStatus:
    """Effects of games on the device.

    Attributes
    ----------
    time_s
        Of this moment: the device's tick times the control period.
    owner
        Owner of the actuator.
    paused
        By the game.
    enabled
        The game wants the actuator on.
    gain
        Of the device, as the game set it, 0 to 1.
    torque_nm
        Of all effects together.
    updates
        Reports that games sent since power-up.
    effects
        That exist.
    clipped_ticks
        Ticks in which effects asked for more than all together get, since power-up.
    asked_percent
        The most that effects asked for in the last half second, as a share of their joint limit.
    """

    time_s: float
    owner: Literal["none", "sdk", "game", "dial"]
    paused: bool
    enabled: bool
    gain: float
    torque_nm: float
    updates: int
    effects: int
    clipped_ticks: int
    asked_percent: int


@dataclass(frozen=True)
class GameEffect:
    """One effect that a game has made.

    Attributes
    ----------
    block
        Its number, from 1; 0: an empty row of the report.
    kind
        Its kind.
    state
        Whether it plays.
    torque_nm
        Torque now, before the cap on all together.
    updates
        Reports about it since it was made.
    silent_s
        Since the last of them; 65.535 s is that or longer.
    """

    block: int
    kind: Literal[
        "none",
        "constant",
        "ramp",
        "square",
        "sine",
        "triangle",
        "sawtooth_up",
        "sawtooth_down",
        "spring",
        "damper",
        "inertia",
        "friction",
    ]
    state: Literal["stopped", "playing", "set_aside"]
    torque_nm: float
    updates: int
    silent_s: float


@dataclass(frozen=True)
class LinkStatistics:
    """Counters of this end of the cable, since the knob was opened.

    Attributes
    ----------
    reports_sent
        To the device.
    reports_received
        From the device.
    reports_undecodable
        Damaged on the way, and ignored.
    samples_received
        Of telemetry.
    samples_lost
        Never arrived, or not read before the ring was full.
    events_lost
        Not taken before there were 1,024 of them.
    local_models_refused
        By the device.
    last_refusal
        Of a local model, in words.
    """

    reports_sent: int
    reports_received: int
    reports_undecodable: int
    samples_received: int
    samples_lost: int
    events_lost: int
    local_models_refused: int
    last_refusal: str


@dataclass(frozen=True)
class Event:
    """Something that the device did without being asked, or that somebody else asked for.

    Attributes
    ----------
    kind
        Kind of event: "state_changed", "watchdog", "deadline_missed", ...
    state
        After the event.
    owner
        Owner of the actuator after the event.
    faults
        Names of the faults that are latched after it.
    tick
        When: control periods since power-up.
    time_s
        Tick times the control period.
    """

    kind: str
    state: Literal["disarmed", "armed", "fault", "disconnected"]
    owner: Literal["none", "sdk", "game", "dial"]
    faults: tuple[str, ...]
    tick: int
    time_s: float


@dataclass(frozen=True)
class Disarm:
    """How the torque went the last time.

    Attributes
    ----------
    reason
        Why it went.
    faults
        Names of the faults that were latched then.
    tick
        When: control periods since power-up.
    time_s
        Tick times the control period.
    """

    reason: Literal[
        "order",
        "watchdog",
        "deadline_missed",
        "fault",
        "game_idle",
        "disconnected",
        "unknown",
        "excitation_over",
        "excitation_stopped",
        "dial_idle",
    ]
    faults: tuple[str, ...]
    tick: int
    time_s: float
