"""A knob that is tapped against a wall with an `Impact`, and what its acceleration shows of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from torsio.closed_loop import InitialState, LoopOptions, simulate
from torsio.demos.wall import HAND_INERTIA_KG_M2, fingers
from torsio.printed.config import ControlConfig
from torsio.printed.plant import Electrics, PlantParams
from torsio.printed.scenes import Impact, Wall

Array = npt.NDArray[np.float64]

RATE_HZ: Final = 20_000.0
COUNTS: Final = 32_768
WALL_NM_PER_RAD: Final = 2.0
SURFACE_RAD: Final = 0.05
PRESS_RAD: Final = 0.03
AFTER_S: Final = 0.06
CUE: Final = Impact(angle_rad=SURFACE_RAD, strength_nm_s_per_rad=0.02)
"""Default of a trial: 300 Hz and 5 ms."""


@dataclass(frozen=True)
class Tap:
    """A tap with an impact and the same without.

    Attributes
    ----------
    speed_rad_s
        Of the knob as it comes to the wall.
    time_s
        Since then, shape (n,).
    acceleration_rad_s2, plain_rad_s2
        Of the knob, with and without the impact.
    in_s
        For how long both come in; then friction holds the knob, or the wall throws it out.
    energy_j
        Of the knob's motion at the contact.
    given_j
        Most that motor and impact together had given beyond the same wall without impact, at any
        time since the contact; below 0 as long as the impact only takes.
    """

    impact: Impact
    speed_rad_s: float
    time_s: Array
    acceleration_rad_s2: Array
    plain_rad_s2: Array
    in_s: float
    energy_j: float
    given_j: float

    @property
    def cue_rad_s2(self) -> Array:
        """The impact's part of the motion."""
        return self.acceleration_rad_s2 - self.plain_rad_s2


@dataclass(frozen=True)
class Found:
    """The decaying sine that fits a cue best.

    Attributes
    ----------
    amplitude_rad_s2
        As it would be without decay.
    rest
        RMS of what it leaves, as a share of the cue's.
    """

    frequency_hz: float
    decay_s: float
    amplitude_rad_s2: float
    rest: float


def _options(speed_rad_s: float, impact: Impact | None) -> LoopOptions:
    plant = PlantParams(counts_per_rev=COUNTS, electrics=Electrics())
    wall = Wall(angle_rad=SURFACE_RAD, stiffness_nm_per_rad=WALL_NM_PER_RAD)
    deepest_rad = SURFACE_RAD + PRESS_RAD
    path = [(0.0, 0.0), (deepest_rad / speed_rad_s, deepest_rad)]
    return LoopOptions(
        scene=[wall] if impact is None else [wall, impact],
        hand=fingers(path),
        control=ControlConfig(law="calibrated"),
        plant=plant,
        actuator=plant.matching_config(),
        control_period_ns=round(1e9 / RATE_HZ),
        initial=InitialState(speed_rad_s=speed_rad_s),
    )


def inertia_kg_m2() -> float:
    """Give what the torque of the motor turns: knob, rotor and finger."""
    return PlantParams().knob_inertia_kg_m2 + HAND_INERTIA_KG_M2


def tap(speed_rad_s: float, impact: Impact = CUE) -> Tap:
    """Tap the wall with a finger, with an impact and without."""
    duration_s = 2.0 * SURFACE_RAD / speed_rad_s + AFTER_S
    with_it, without = (
        simulate(_options(speed_rad_s, one), duration_s=duration_s) for one in (impact, None)
    )
    # Up to the contact both are the same.
    first = int(np.argmax(with_it["desired_torque_nm"] < 0.0))
    span = slice(first, first + round(AFTER_S * RATE_HZ))
    accelerations = [np.diff(log["speed_rad_s"])[span] * RATE_HZ for log in (with_it, without)]
    contact = float(with_it["speed_rad_s"][first])
    slowest = np.minimum(with_it["speed_rad_s"], without["speed_rad_s"])[span]
    work = [
        np.cumsum(log["motor_torque_nm"][:-1] * np.diff(log["angle_rad"]))[span]
        for log in (with_it, without)
    ]
    return Tap(
        impact,
        contact,
        np.arange(len(accelerations[0])) / RATE_HZ,
        accelerations[0],
        accelerations[1],
        float(np.argmax(slowest < 0.05 * contact)) / RATE_HZ,
        0.5 * inertia_kg_m2() * contact**2,
        float((work[0] - work[1]).max()),
    )


def closed_form_rad_s2(tap_: Tap) -> Array:
    """Give the acceleration of a free mass under the sine that was asked for."""
    impact, time_s = tap_.impact, tap_.time_s
    torque_nm = (
        -impact.strength_nm_s_per_rad
        * tap_.speed_rad_s
        * np.exp(-time_s / impact.decay_s)
        * np.sin(2 * math.pi * impact.frequency_hz * time_s)
    )
    return np.asarray(torque_nm / inertia_kg_m2(), dtype=np.float64)


def fit_sine(tap_: Tap) -> Found:
    """Fit a decaying sine of any phase: for each frequency and decay the best is linear."""
    impact = tap_.impact
    # From where the motor has caught up, for as long as there is something and the knob moves.
    end_s = min(3.0 * impact.decay_s, tap_.in_s)
    chosen = (tap_.time_s > 0.3e-3) & (tap_.time_s < end_s)
    time_s, cue = tap_.time_s[chosen], tap_.cue_rad_s2[chosen]
    frequency_hz, decay_s = impact.frequency_hz, impact.decay_s
    best = Found(math.nan, math.nan, math.nan, math.inf)
    for width in (0.5, 0.1, 0.02, 0.004):
        for f in frequency_hz * np.linspace(1 - width, 1 + width, 21):
            for tau in decay_s * np.linspace(1 - width, 1 + width, 21):
                envelope = np.exp(-time_s / tau)
                waves = np.stack(
                    [envelope * wave(2 * math.pi * f * time_s) for wave in (np.cos, np.sin)]
                )
                weights = np.linalg.solve(waves @ waves.T, waves @ cue)
                rest = float(np.sqrt(np.mean((cue - weights @ waves) ** 2) / np.mean(cue**2)))
                if rest < best.rest:
                    best = Found(float(f), float(tau), float(np.hypot(*weights)), rest)
        frequency_hz, decay_s = best.frequency_hz, best.decay_s
    return best


def spectrum(signal: Array) -> tuple[Array, Array]:
    """Give frequencies in Hz, and the magnitude of what a signal has there per Hz."""
    padded = 1 << 16
    # Fade a signal that is cut off: the cut would be heard at all frequencies.
    fade = np.minimum(1.0, 2.0 * np.arange(len(signal), 0.0, -1.0) / len(signal))
    values = np.abs(np.fft.rfft(signal * np.sin(0.5 * np.pi * fade) ** 2, padded)) / RATE_HZ
    return np.fft.rfftfreq(padded, 1.0 / RATE_HZ).astype(np.float64), values


def peak_hz(signal: Array, *, above_hz: float = 100.0) -> float:
    """Give where a spectrum is highest, past what a finger on a wall swings by itself."""
    frequency_hz, values = spectrum(signal)
    shown = frequency_hz > above_hz
    return float(frequency_hz[shown][np.argmax(values[shown])])


def with_cue(**changes: float) -> Impact:
    """Give the usual cue with other values."""
    return replace(CUE, **changes)  # type: ignore[arg-type]
