"""Devices whose state can be looked at behind the library's back, in virtual and in real time."""

from __future__ import annotations

import threading
import time
from typing import Any

import torsio
from torsio import protocol
from torsio.emulator import EmulatedDevice

_REPORTS = {report["name"]: report["id"] for report in protocol.reports()}


class Device(torsio.Transport):
    """An emulated device in virtual time, over a transport of our own."""

    time_is_virtual = True

    def __init__(self, tick_ns: int = 1_000_000) -> None:
        self.lock = threading.RLock()
        self._tick_ns = tick_ns
        self.device = EmulatedDevice(plant=torsio.PlantParams(), control_period_ns=tick_ns)
        self.device.advance(5_000_000)
        self.is_closed = False

    @property
    def is_armed(self) -> bool:
        """The device's own answer, after all reports have arrived."""
        with self.lock:
            self.device.advance(20_000_000)
            return bool(self._told("health")["state"] == "armed")

    @property
    def tick(self) -> int:
        """The newest control tick, asked without the library."""
        return self.now_ns() // self._tick_ns

    def _told(self, name: str) -> dict[str, Any]:
        report = self.device.get_feature(_REPORTS[name])
        assert report is not None
        return protocol.decode(report)[1]

    def config(self, name: str) -> dict[str, Any]:
        """A configuration as the device itself has it."""
        with self.lock:
            return self._told(f"{name}_config")

    def close(self) -> None:
        self.is_closed = True

    def write(self, report: bytes) -> bool:
        with self.lock:
            return bool(self.device.write(report))

    def read(self, timeout_s: float) -> bytes | None:
        with self.lock:
            return self.device.read()

    def get_feature(self, report_id: int) -> bytes | None:
        with self.lock:
            return self.device.get_feature(report_id)

    def set_feature(self, report: bytes) -> bool:
        with self.lock:
            return self.device.set_feature(report)[0] == 0  # else it stalls the request

    def now_ns(self) -> int:
        return int(self.device.time_ns)

    def advance_to(self, time_ns: int) -> None:
        self.device.advance(max(time_ns - int(self.device.time_ns), 0))


class PacedDevice(Device):
    """The same in real time; each look takes a millisecond of the device's time."""

    time_is_virtual = False

    def read(self, timeout_s: float) -> bytes | None:
        with self.lock:
            self.device.advance(1_000_000)
            report = super().read(timeout_s)
        if report is None:
            time.sleep(2e-4)
        return report


def device(*, paced: bool) -> Device:
    """Make one."""
    return PacedDevice() if paced else Device()
