"""A curve that a game sends as one value in each of its frames: what is left of it at the motor."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import torsio
from tests.python.game import CONSTANT, Game
from tests.vm.guest.torque_log import FULL_NM, Floats

Line = dict[str, Any]
CURVE = 0.5  # share of full torque
FRAMES_HZ = (60, 120, 360)


def curve(time_s: Floats) -> Floats:
    found: Floats = CURVE * np.sin(2 * np.pi * time_s)
    return found


def measures(time_s: Floats, torque: Floats) -> Line:
    """Compare with the curve, without its first second."""
    counted = time_s > 1

    def error(late_s: float) -> Floats:
        found: Floats = (torque - curve(time_s - late_s))[counted]
        return found

    late_s = min(np.arange(0, 0.05, 1e-4), key=lambda late: float(np.mean(error(float(late)) ** 2)))
    left = error(float(late_s))
    return {
        "late_ms": round(1e3 * float(late_s), 2),
        "ripple_share": round(float(np.abs(left).max()), 5),
        "rms_share": round(float(np.sqrt(np.mean(left**2))), 5),
        "step_share": round(float(np.abs(np.diff(torque[counted])).max()), 5),
        "overshoot_share": round(max(float(np.abs(torque).max()) - CURVE, 0.0), 5),
    }


def _line(rate_hz: int, frames_hz: int, sent: str, *, joined: bool) -> Line:
    """Do the same without USB, driver and machine: what the device itself makes of a curve."""
    duration_s = 3.0
    count = round(duration_s * frames_hz)
    options = torsio.EmulatorOptions(
        control_rate_hz=rate_hz,
        control=torsio.ControlConfig(law="motor_only"),
        game=torsio.GameConfig(join_updates=joined, torque_max_nm=FULL_NM),
        log_truth=True,
    )
    with torsio.open("emulated", emulator=options) as knob:
        knob.emulator.set_hand(torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (1.0, 0.0)]))
        game = Game(knob)
        block = game.create(CONSTANT)
        game.constant(block, 0)
        game.play(block)
        knob.emulator.advance(0.2)
        knob.emulator.truth()
        torque: list[Floats] = []
        ticks = 0
        for index in range(count):
            level = round(32767 * float(curve(np.array(index / frames_hz))))
            until = round((index + 1) / frames_hz * rate_hz)
            for number, report in enumerate(sent.split()):
                if number != 0:
                    knob.emulator.advance(1e-3)
                    ticks += round(1e-3 * rate_hz)
                if report == "level":
                    game.constant(block, level)
                elif report == "envelope":
                    game.envelope(block)
                elif report == "effect":
                    game.effect(block, CONSTANT)
                else:
                    game.play(block)
            knob.emulator.advance((until - ticks) / rate_hz)
            ticks = until
            torque.append(np.array(knob.emulator.truth()["motor_torque_nm"]) / FULL_NM)
    found = measures(np.arange(ticks) / rate_hz, np.concatenate(torque)[:ticks])
    about: Line = {"what": "frames", "frames_hz": frames_hz, "joined": joined, "sent": sent}
    return about | {"updates": count} | found


def measure_in_process(rate_hz: int) -> Iterator[Line]:
    """Measure the filter between updates alone, in seconds, by the virtual clock."""
    about = {"benchmark": "games", "time": "virtual", "control_rate_hz": rate_hz}
    for frames_hz in FRAMES_HZ:
        for joined in (False, True):
            for sent in ("level", "level start", "level envelope effect"):
                yield about | _line(rate_hz, frames_hz, sent, joined=joined)
