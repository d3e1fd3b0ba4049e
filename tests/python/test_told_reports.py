"""A device's reports reach Python in SI units, field by field."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import pytest

import torsio
from tests.python import wire
from tests.python.test_own_transport import TICK_NS, Simulated

TORQUE_STEP_NM = 2.0**-10
COUNTS = 1000
RATE_HZ = 1e9 / TICK_NS


class Telling(Simulated):
    """A device whose reports are as a test writes them."""

    def __init__(self) -> None:
        super().__init__()
        self.reports: dict[int, bytes] = {}
        self.tell("identity", torque_step_nm=TORQUE_STEP_NM, counts_per_rev=COUNTS)

    def tell(self, name: str, **values: Any) -> None:
        report_id = wire.REPORTS[name].id
        _, as_it_is = wire.decode(self.device.get_feature(report_id) or b"")
        self.reports[report_id] = wire.encode(name, as_it_is | values)

    def get_feature(self, report_id: int) -> bytes | None:
        return self.reports.get(report_id) or super().get_feature(report_id)


def test_health_is_told_field_by_field() -> None:
    transport = Telling()
    with torsio.open(transport) as knob:
        transport.tell(
            "health",
            state="armed", faults=0, reports_accepted=11, reports_refused=12, samples_dropped=13,
            tick_overruns=14, tick_time_ns=15_000, tick_time_max_ns=16_000, saves=17,
            owner="game", reset_cause="watchdog", unexpected_swings=18, centre="index",
        )  # fmt: skip
        assert asdict(knob.health()) == {
            "state": "armed", "faults": (), "reports_accepted": 11, "reports_refused": 12,
            "samples_dropped": 13, "tick_overruns": 14, "tick_time_s": pytest.approx(15e-6),
            "tick_time_max_s": pytest.approx(16e-6), "saves": 17, "owner": "game",
            "reset_cause": "watchdog", "unexpected_swings": 18, "centre": "index",
        }  # fmt: skip


def test_identity_is_told_field_by_field() -> None:
    transport = Telling()
    transport.tell(
        "identity",
        torque_step_nm=TORQUE_STEP_NM, speed_step_rad_s=0.25, counts_per_rev=COUNTS, axes=3,
        effects=4, curve_points=5, firmware_version=[6, 7, 8], serial=[*b"K" * 15, 0],
    )  # fmt: skip
    with torsio.open(transport) as knob:
        info = asdict(knob.info)
    assert info.pop("fingerprint") > 0
    assert info == {
        "path": "", "serial": "K" * 15, "product": "", "board": "emulated",
        "firmware_version": "6.7.8", "transport": "own", "protocol_version": 1, "axes": 3,
        "effects": 4, "curve_points": 5, "control_rate_hz": RATE_HZ, "counts_per_rev": COUNTS,
        "torque_step_nm": TORQUE_STEP_NM, "speed_step_rad_s": 0.25,
    }  # fmt: skip


def test_clock_is_told_field_by_field() -> None:
    transport = Telling()
    with torsio.open(transport) as knob:
        transport.tell("clock", tick=20, time_ns=2_000_000, position_counts=-2500)
        assert asdict(knob.clock()) == {
            "tick": 20, "time_s": pytest.approx(2e-3), "position_counts": -2500,
            "angle_rad": pytest.approx(-5.0 * math.pi),
        }  # fmt: skip


def test_ledger_is_told_in_joules() -> None:
    transport = Telling()
    with torsio.open(transport) as knob:
        transport.tell(
            "ledger",
            tick=30, kept="on", motor=7 << 23, spring_twice=4 << 23, spring=0, stored_j=0.5,
            bound_nm_per_rad=12.0,
        )  # fmt: skip
        count_rad = 2.0 * math.pi / COUNTS
        assert asdict(knob.energies()) == {
            "tick": 30, "time_s": pytest.approx(3e-3), "kept": True,
            "motor_j": pytest.approx(7.0 * count_rad), "felt_j": pytest.approx(9.0 * count_rad),
            "stored_j": 0.5, "brake_j": pytest.approx(-2.0 * count_rad - 0.5),
            "bound_nm_per_rad": 12.0,
        }  # fmt: skip


def test_motor_current_is_told_in_amperes() -> None:
    transport = Telling()
    with torsio.open(transport) as knob:
        transport.tell(
            "motor_current",
            measured="on", position_counts=250, period_ns=50_000, delay_ns=30_000, periods=40,
            reading_sum=4000, share_sum=1 << 15, reading=110, share=1 << 13,
            share_before=-(1 << 12), zero=100.0, a_per_step=-0.25, a_per_nm=16.0,
        )  # fmt: skip
        assert asdict(knob.motor_current()) == {
            "measured": True, "time_s": pytest.approx(2e-3),
            "angle_rad": pytest.approx(math.pi / 2),
            "period_s": pytest.approx(5e-5), "delay_s": pytest.approx(3e-5), "periods": 40,
            "current_a": -2.5, "zero_a": -25.0, "step_a": 0.25, "current_sum_a": -1000.0,
            "share": 0.5, "share_before": -0.25, "share_sum": 2.0,
            "torque_constant_nm_per_a": 0.0625,
        }  # fmt: skip


def test_what_games_do_is_told_field_by_field() -> None:
    transport = Telling()
    empty = {
        "block": 0,
        "kind": "none",
        "state": "stopped",
        "torque": 0,
        "updates": 0,
        "silent_ms": 0,
    }
    row = {
        "block": 9, "kind": "spring", "state": "playing", "torque": -512, "updates": 50,
        "silent_ms": 1500,
    }  # fmt: skip
    with torsio.open(transport) as knob:
        rows = len(wire.decode(transport.get_feature(0x08) or b"")[1]["effect"])
        transport.tell(
            "game_monitor",
            tick=60, owner="game", paused="on", enabled="on", gain=32767, torque=256, updates=61,
            effects=1, clipped_ticks=70_000, asked_percent=130, effect=[row, *[empty] * (rows - 1)],
        )  # fmt: skip
        assert asdict(knob.game_status()) == {
            "time_s": pytest.approx(6e-3), "owner": "game", "paused": True, "enabled": True,
            "gain": 1.0, "torque_nm": 0.25, "updates": 61, "effects": 1,
            "clipped_ticks": 70_000, "asked_percent": 130,
        }  # fmt: skip
        assert [asdict(effect) for effect in knob.game_effects()] == [
            {"block": 9, "kind": "spring", "state": "playing", "torque_nm": -0.5, "updates": 50,
             "silent_s": pytest.approx(1.5)},
        ]  # fmt: skip
