"""The emulated device on the bench, in place of a chip that runs a firmware file."""

from __future__ import annotations

import struct
from typing import Any

from tests.board.world import ROW_NS, columns
from tests.python import wire
from torsio.emulator import EmulatedDevice
from torsio.printed.hands import Hand
from torsio.printed.plant import PlantParams

SET_REPORT, GET_REPORT = 0x09, 0x01


class Twin:
    """Does what a chip's bench is told, as far as reports and time go; a world of its own."""

    def __init__(self, params: PlantParams, tick_ns: int, *, seed: int = 1) -> None:
        self.params = params
        self._device = EmulatedDevice(plant=params, control_period_ns=tick_ns, seed=seed)
        self._rows: list[dict[str, Any]] = []

    def do(self, name: str, **details: Any) -> Any:
        return getattr(self, f"_{name}")(**details)

    def close(self) -> None:
        """Nothing to end."""

    @property
    def time_s(self) -> float:
        """Since power-up."""
        return 1e-9 * self._device.time_ns

    def set_hand(self, hand: Hand) -> None:
        """Let another hand take over; its times are this world's."""
        self._device.set_hand(hand)

    def record(self) -> Any:
        """Give the rows so far, one a millisecond, as columns by name."""
        return columns(self._rows)

    def _run(self, ns: float) -> int:
        end = self._device.time_ns + round(ns)
        while self._device.time_ns < end:
            now = self._device.time_ns
            if now % ROW_NS == 0 and (not self._rows or now > self._rows[-1]["time_ns"]):
                self._rows.append({**self._device.plant_state, "time_ns": now})
            self._device.advance(min(end, (now // ROW_NS + 1) * ROW_NS) - now)
        return self._device.time_ns

    def _control(self, setup: str, data: str = "") -> dict[str, Any]:
        _, request, value, _, _ = struct.unpack("<BBHHH", bytes.fromhex(setup))
        if request == SET_REPORT:
            self._device.set_feature(bytes.fromhex(data))
            return {"data": ""}
        assert request == GET_REPORT
        report = self._device.get_feature(value & 0xFF)
        return {"stall": True} if report is None else {"data": report.hex()}

    def _out(self, endpoint: int, data: str, within_ns: float) -> str:
        report = bytes.fromhex(data).ljust(wire.REPORT_SIZE, b"\0")
        return "ack" if endpoint == 1 and self._device.write(report) and within_ns else "nak"

    def _in(self, endpoint: int, within_ns: float) -> Any:
        end = self._device.time_ns + within_ns
        while endpoint == 1:
            report = self._device.read()
            if report is not None:
                return {"data": report.hex()}
            if self._device.time_ns >= end:
                break
            self._run(ROW_NS / 10)
        return "nak"
