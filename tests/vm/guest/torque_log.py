"""The true torque of a virtual knob's motor, tick by tick."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import torsio
from tests.vm.guest.virtual_bus import Cable, VirtualBus, VirtualKnob, plain_cable, wait_for

FULL_NM = 0.06  # full level here
QUIET = 1e-4  # shares of full below this are none
Floats = npt.NDArray[np.float64]


def set_up(knob: VirtualKnob, **game: Any) -> None:
    """Hold the knob still, and let its motor alone render; `game` is for the `GameConfig`."""
    knob.say("still")
    with torsio.open(knob.serial) as opened:
        opened.configure(torsio.ControlConfig(law="motor_only"))
        # A spring's closed form goes over the whole range.
        settings = {"torque_max_nm": FULL_NM, "spring_gain": 1, **game}
        opened.configure(torsio.GameConfig(**settings))


def plug(
    bus: VirtualBus,
    folder: Path,
    *,
    rate_hz: int = 1000,
    cable: Cable = plain_cable,
    **game: Any,
) -> tuple[VirtualKnob, Path]:
    """Plug such a knob in, and return it with the file that it writes what it gives to."""
    log = folder / "log"
    knob = bus.plug(rate_hz=rate_hz, options=["--status", "--log", str(log)], cable=cable)
    set_up(knob, **game)
    return knob, log


def let_pass(knob: VirtualKnob, duration_s: float) -> None:
    """Wait until so much of the knob's own time is over, which a busy machine makes slower."""
    assert knob.process.stdout is not None
    file = knob.process.stdout.fileno()
    os.set_blocking(file, False)
    end_s: float | None = None

    def is_over() -> bool:
        nonlocal end_s
        try:
            lines = os.read(file, 1 << 16).decode().splitlines()
        except BlockingIOError:
            return False
        words = [line.split() for line in lines]
        # The first and the last line may be parts of a line.
        times = [float(word[1]) for word in words if len(word) == 7 and word[0] == "status"]
        if not times:
            return False
        if end_s is None:
            # A line comes every 0.1 s, the last one may be as old.
            end_s = times[-1] + 0.1 + duration_s
        return times[-1] >= end_s

    wait_for("the knob's time to pass", is_over)


def turn(knob: VirtualKnob, folder: Path, path: list[tuple[float, float]]) -> None:
    """Turn the knob along a path of times in s and angles in rad."""
    script = folder / "script"
    script.write_text("motion_rad\n" + "".join(f"{t} {angle}\n" for t, angle in path))
    knob.say(f"script {script}")


def read_log(bus: VirtualBus, log: Path) -> tuple[Floats, Floats, Floats]:
    """End all knobs and return time in s, angle, and the motor's torque as a share of full."""
    bus.end()
    data = np.loadtxt(log, delimiter=",", skiprows=1, usecols=(0, 1, 2))
    return data[:, 0] * 1e-9, data[:, 1], data[:, 2] / FULL_NM


def pieces(time_s: Floats, torque: Floats, pause_s: float) -> list[tuple[Floats, Floats]]:
    """Return what lies between pauses, each with a bit of the pause before and behind."""
    loud = np.flatnonzero(np.abs(torque) > QUIET)
    cuts = np.flatnonzero(np.diff(time_s[loud]) > pause_s)
    firsts = loud[np.concatenate(([0], cuts + 1))]
    lasts = loud[np.concatenate((cuts, [loud.size - 1]))]
    around = round(0.02 / (time_s[1] - time_s[0]))
    return [
        (
            time_s[max(first - around, 0) : last + around],
            torque[max(first - around, 0) : last + around],
        )
        for first, last in zip(firsts, lasts, strict=True)
    ]


def held(torque: Floats, ticks: int = 50) -> list[float]:
    """Return the torques that are held for so many ticks at least, one after the other."""
    steady = np.convolve(np.abs(np.diff(torque)) < 1e-5, np.ones(ticks), "valid") == ticks
    levels = torque[:-ticks][steady]
    return [float(levels[0]), *(float(x) for x in levels[1:][np.abs(np.diff(levels)) > 1e-3])]


def fall_s(time_s: Floats, torque: Floats, full: float = 0.99) -> float:
    """Return the time from the last full torque to none for good."""
    last_full = np.flatnonzero(np.abs(torque) > full)[-1]
    loud = np.flatnonzero(np.abs(torque) > QUIET)[-1]
    return float(time_s[loud] - time_s[last_full])
