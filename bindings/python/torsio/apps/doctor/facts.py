"""Facts that `torsio doctor` gathers before it judges: the USB, the permission, the knob itself."""

from __future__ import annotations

import os
import stat
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from torsio._torsio import protocol as _protocol
from torsio.errors import (
    DeviceBusy,
    DeviceNotFound,
    Error,
    PermissionDenied,
    ProtocolMismatch,
    Timeout,
)
from torsio.knob import Knob
from torsio.printed.told import Clock, DeviceInfo, Health, Limits, LinkStatistics

VENDOR_ID, PRODUCT_ID = f"{_protocol.USB_VENDOR_ID:04x}", f"{_protocol.USB_PRODUCT_ID:04x}"
RULE = "60-torsio.rules"
# The folders of udev(7). A file in one hides a file of the same name in a later one.
RULE_FOLDERS = (
    "etc/udev/rules.d",
    "run/udev/rules.d",
    "usr/local/lib/udev/rules.d",
    "usr/lib/udev/rules.d",
    "lib/udev/rules.d",
)

CLOCK_SPAN_S = 2.0
ROUND_TRIPS = 200
TELEMETRY_S = 1.0


@dataclass(frozen=True)
class Node:
    """The file in /dev through which a knob is opened."""

    path: str
    exists: bool
    usable: bool
    """This user may read and write it."""
    mode: int
    """Permission bits."""


@dataclass(frozen=True)
class UsbKnob:
    """A knob on the USB, as the kernel shows it, whether or not it can be opened."""

    port: str
    """Where it is plugged in: "1-2"."""
    serial: str
    driver: str
    """Driver of the interface that the library talks to; empty if there is none."""
    node: Node | None
    """None if the kernel has made none."""


@dataclass(frozen=True)
class Permission:
    """How this system gives permission."""

    rule: str
    """Path of the installed udev rule; empty if there is none."""
    udev_runs: bool
    remote: bool
    """This session came over ssh: it has no seat."""


@dataclass(frozen=True)
class ClockFit:
    """The device's clock against the host's."""

    offset_s: float
    """Device time minus the host's monotonic time, at the end."""
    drift_ppm: float
    """How much faster the device's clock runs."""
    uncertainty_ppm: float
    """Uncertainty of the drift: the question takes time, and the clock steps by a tick."""


@dataclass(frozen=True)
class RoundTrips:
    """From a command to its answer, in wall-clock time."""

    count: int
    median_s: float
    p99_s: float
    worst_s: float


@dataclass(frozen=True)
class KnobFacts:
    """Reports and behaviour of an open knob."""

    info: DeviceInfo
    before: Health
    after: Health
    watchdog_s: float
    watches_supply: bool
    limits: Limits
    clock: ClockFit
    round_trips: RoundTrips | None
    """None if the knob was armed, for the command that is timed would disarm it."""
    samples: int
    link: LinkStatistics


# The system ---------------------------------------------------------------------------------


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""


def _node(path: Path) -> Node:
    try:
        mode = stat.S_IMODE(path.stat().st_mode)
    except OSError:
        return Node(str(path), exists=False, usable=False, mode=0)
    return Node(str(path), exists=True, usable=os.access(path, os.R_OK | os.W_OK), mode=mode)


def find_usb_knobs(root: Path = Path("/")) -> list[UsbKnob]:
    """Find every knob that the kernel sees, below another root if told."""
    knobs = []
    for device in sorted(root.glob("sys/bus/usb/devices/*")):
        identity = _text(device / "idVendor"), _text(device / "idProduct")
        if identity != (VENDOR_ID, PRODUCT_ID):
            continue
        driver, node = "", None
        # The vendor interface is the first; a second one is for games.
        for interface in sorted(device.glob(f"{device.name}:*.0")):
            if (interface / "driver").exists():
                driver = (interface / "driver").resolve().name
            for hidraw in sorted(interface.glob("*/hidraw/hidraw*")):
                node = _node(root / "dev" / hidraw.name)
        knobs.append(UsbKnob(device.name, _text(device / "serial"), driver, node))
    return knobs


def find_permission(root: Path = Path("/")) -> Permission:
    """Find out how this system gives permission."""
    rules = [root / folder / RULE for folder in RULE_FOLDERS]
    return Permission(
        rule=next((str(rule) for rule in rules if rule.exists()), ""),
        udev_runs=(root / "run/udev/control").exists(),
        remote="SSH_CONNECTION" in os.environ,
    )


# The knob -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class _ClockSample:
    asked_s: float
    answered_s: float
    device_s: float

    @property
    def offset_s(self) -> float:
        return self.device_s - (self.asked_s + self.answered_s) / 2


def ask_clock(clock: Callable[[], Clock]) -> _ClockSample:
    """Read the device's clock between two looks at the host's, the quickest of ten times."""
    samples = []
    for _ in range(10):
        asked_s = time.monotonic()
        device_s = clock().time_s
        samples.append(_ClockSample(asked_s, time.monotonic(), device_s))
    return min(samples, key=lambda sample: sample.answered_s - sample.asked_s)


def fit_clock(first: _ClockSample, last: _ClockSample, step_s: float) -> ClockFit:
    """Compare the clocks at two times; the device's goes in steps."""
    span_s = (last.asked_s + last.answered_s - first.asked_s - first.answered_s) / 2
    doubt_s = (first.answered_s - first.asked_s + last.answered_s - last.asked_s) / 2 + step_s
    return ClockFit(
        offset_s=last.offset_s,
        drift_ppm=1e6 * (last.offset_s - first.offset_s) / span_s,
        uncertainty_ppm=1e6 * doubt_s / span_s,
    )


def time_round_trips(command: Callable[[], None], count: int) -> RoundTrips:
    """Time a command from its call to its answer."""
    times_s = []
    for _ in range(count):
        begin = time.perf_counter()
        command()
        times_s.append(time.perf_counter() - begin)
    times_s.sort()
    return RoundTrips(
        count=count,
        median_s=statistics.median(times_s),
        p99_s=times_s[min(round(0.99 * count), count - 1)],
        worst_s=times_s[-1],
    )


def examine(knob: Knob) -> KnobFacts:
    """Ask and time an open knob, for about three seconds. It must run in real time."""
    before = knob.health()
    first = ask_clock(knob.clock)
    round_trips = None
    if before.state != "armed":
        round_trips = time_round_trips(knob.disarm, ROUND_TRIPS)
    samples = knob.record(duration_s=TELEMETRY_S)
    left_s = first.asked_s + CLOCK_SPAN_S - time.monotonic()
    if left_s > 0:
        knob.sleep(left_s)
    return KnobFacts(
        info=knob.info,
        before=before,
        clock=fit_clock(first, ask_clock(knob.clock), 1 / knob.info.control_rate_hz),
        watchdog_s=knob.control_config().watchdog_s,
        watches_supply=knob.board_config().supply_sense_pin != 0,
        limits=knob.limits(),
        round_trips=round_trips,
        samples=len(samples),
        link=knob.statistics(),
        after=knob.health(),
    )


# Names of the errors that keep a knob from being opened or examined.
FAILURES: dict[type[Exception], str] = {
    DeviceBusy: "busy",
    PermissionDenied: "permission",
    ProtocolMismatch: "protocol",
    DeviceNotFound: "not_found",
    Timeout: "timeout",
}


def failure_name(error: Error) -> str:
    """Give the name of the check that an error belongs to."""
    return next((name for kind, name in FAILURES.items() if isinstance(error, kind)), "failed")
