"""What a knob tells about itself: identity, clock, health, and how the cable is doing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

__all__ = [
    "Clock",
    "DeviceEvent",
    "DeviceInfo",
    "Health",
    "LinkStatistics",
    "ListedDevice",
    "State",
]

State: TypeAlias = Literal["disarmed", "armed", "fault", "disconnected"]


@dataclass(frozen=True)
class ListedDevice:
    """A device that could be opened.

    Attributes
    ----------
    path
        What `open` takes.
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
class DeviceEvent:
    """A knob was plugged in or pulled out.

    Attributes
    ----------
    device
        As `list_devices` has it, but without `board`: a watch does not open the device, so that it
        never gets into the way of who opens it.
    """

    kind: Literal["arrived", "departed"]
    device: ListedDevice


@dataclass(frozen=True)
class DeviceInfo:
    """Who the device is and what it can do."""

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
    """The device's time and position, both exact."""

    tick: int
    time_s: float
    position_counts: int
    angle_rad: float


@dataclass(frozen=True)
class Health:
    """State and counters of the device since its power-up.

    Attributes
    ----------
    faults
        Names of the latched faults: "over_speed" ...
    samples_dropped
        Telemetry that the host did not fetch in time.
    tick_time_s, tick_time_max_s
        Time that the last control tick took, and the longest one so far.
    owner
        Who has the actuator: "none" unless it is armed.
    """

    state: State
    faults: tuple[str, ...]
    reports_accepted: int
    reports_refused: int
    samples_dropped: int
    tick_overruns: int
    tick_time_s: float
    tick_time_max_s: float
    saves: int
    owner: Literal["none", "sdk", "game"]


@dataclass(frozen=True)
class LinkStatistics:
    """Counters of this end of the cable, since the knob was opened.

    Attributes
    ----------
    samples_lost
        Never arrived, or not read before the ring was full.
    last_refusal
        Of a local model, in words.
    """

    reports_sent: int
    reports_received: int
    reports_undecodable: int
    samples_received: int
    samples_lost: int
    local_models_refused: int
    last_refusal: str
