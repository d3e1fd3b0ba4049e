"""Closed forms of effects that depend on time only, and how far a torque is from them."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.vm.guest import gamepad
from tests.vm.guest.gamepad import Effect, Envelope
from tests.vm.guest.torque_log import QUIET, Floats

Form = Callable[[Floats], Floats]


@dataclass(frozen=True)
class Case:
    """An effect and its torque.

    Attributes
    ----------
    length_s
        Of all loops.
    form
        Torque over time in s, as a share of full.
    loops
        How often it is played.
    """

    effect: Effect
    length_s: float
    form: Form
    loops: int = 1


def envelope(peak: float, length_s: float, shape: Envelope, t: Floats) -> Floats:
    """Straight lines from the attack's level and to the fade's."""
    attack_s, fade_s = shape.attack_ms / 1e3, shape.fade_ms / 1e3
    points = [(attack_s, peak), (length_s - fade_s, peak)]
    if attack_s:
        points.insert(0, (0.0, shape.attack_level / 32767))
    if fade_s:
        points.append((length_s, shape.fade_level / 32767))
    times, levels = np.array(points, dtype=np.float64).T
    found: Floats = np.interp(t, times, levels)
    return found


def sine(t: Floats) -> Floats:
    return np.sin(2 * np.pi * t)


def square(t: Floats) -> Floats:
    return np.where(t % 1 < 0.5, 1.0, -1.0)


def triangle(t: Floats) -> Floats:
    return 1 - 4 * np.abs((t + 0.25) % 1 - 0.5)


def saw_up(t: Floats) -> Floats:
    return 2 * (t % 1) - 1


def saw_down(t: Floats) -> Floats:
    return 1 - 2 * (t % 1)


WAVES = {
    gamepad.SQUARE: square,
    gamepad.TRIANGLE: triangle,
    gamepad.SINE: sine,
    gamepad.SAW_UP: saw_up,
    gamepad.SAW_DOWN: saw_down,
}
FADING = Envelope(attack_ms=60, attack_level=0, fade_ms=80, fade_level=32767)


def _level(share: float) -> Form:
    return lambda t: np.full_like(t, share)


def _wave(
    wave: Form, period_s: float, amplitude: float, *, offset: float = 0, phase: float = 0
) -> Form:
    """Return a wave over time in s; the phase is in turns."""
    return lambda t: amplitude * wave(t / period_s + phase) + offset


def cases() -> dict[str, Case]:
    """Return what is played, by name."""
    kind, share = gamepad.CONSTANT, 20000 / 32767
    full, fading = gamepad.constant(32767), gamepad.constant(20000, FADING)
    found = {
        "largest": Case(Effect(kind, full, 100), 0.1, _level(1)),
        "smallest": Case(Effect(kind, gamepad.constant(-32767), 100), 0.1, _level(-1)),
        "to the left": Case(Effect(kind, full, 100, direction=gamepad.LEFT), 0.1, _level(-1)),
        "from the north-west": Case(
            Effect(kind, full, 100, direction=0xE000), 0.1, _level(np.sqrt(0.5))
        ),
        "envelope": Case(Effect(kind, fading, 300), 0.3, lambda t: envelope(share, 0.3, FADING, t)),
        "loops with delay": Case(
            Effect(kind, fading, 200, delay_ms=150),
            0.6,
            lambda t: envelope(share, 0.2, FADING, t % 0.2),
            loops=3,
        ),
        "ramp": Case(
            Effect(gamepad.RAMP, gamepad.ramp(-32767, 32767), 300), 0.3, lambda t: 2 * t / 0.3 - 1
        ),
    }
    # The kernel makes a sine of it, from nowhere, with a third and a sixth of the two strengths.
    found["rumble"] = Case(
        Effect(gamepad.RUMBLE, struct.pack("<2H", 0xC000, 0x6000), 300, direction=0),
        0.3,
        _wave(sine, 0.05, -0x5000 / 32767),
    )
    for code, wave in WAVES.items():
        found[f"{wave.__name__}, full"] = Case(
            Effect(gamepad.PERIODIC, gamepad.periodic(code, 32767, 100), 300),
            0.3,
            _wave(wave, 0.1, 1.0),
        )
        found[f"{wave.__name__}, offset and phase"] = Case(
            Effect(
                gamepad.PERIODIC,
                gamepad.periodic(code, 15000, 80, offset=-12000, phase=0x4000),
                280,
            ),
            0.28,
            _wave(wave, 0.08, 15000 / 32767, offset=-12000 / 32767, phase=0.25),
        )
    return found


def residual(time_s: Floats, torque: Floats, case: Case) -> Floats:
    """Return the distances from a closed form.

    The beginning is not known to the tick: it is where the form fits best, within 4 ms before
    the first torque. Left out are 3 ms after the beginning, before the end, and on either side of
    the form's own jumps: there the device blends for 2 ms, and a tick is held for 1 ms.
    """
    first = time_s[np.flatnonzero(np.abs(torque) > QUIET)[0]]
    best = np.full(1, np.inf)
    for begin in first + np.arange(-4e-3, 1e-3, 0.1e-3):
        t = time_s - begin
        counted = (t > 3e-3) & (t < case.length_s - 3e-3)
        for shift in (-3e-3, 3e-3):
            counted &= np.abs(case.form(t + shift) - case.form(t)) < 0.5
        distances = np.abs(torque - case.form(t))[counted]
        if distances.max() < best.max():
            best = distances
    return best


def length_error_s(time_s: Floats, torque: Floats, case: Case) -> float:
    """Return how much longer than it should be an effect sounds."""
    loud = np.flatnonzero(np.abs(torque) > QUIET)
    return float(time_s[loud[-1]] - time_s[loud[0]]) - case.length_s
