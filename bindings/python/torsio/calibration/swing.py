"""How the knob swings on a held shaft: the inertia and the damping of its side."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from torsio.calibration.numeric import Solution, gauss_newton
from torsio.calibration.play import Run
from torsio.calibration.quantity import Array, Refusal

__all__ = ["estimate_swing", "swing_rad_s"]

_STEP = "shaft"
_DAMPING = 2e-4  # N m s/rad, where the search begins
# A resting knob repeats one reading, wrong by up to a count. So only samples this near to a change
# of counts are fitted.
_MOVING_S = 3e-3


def _swing(
    log: Run,
    value: Array,
    spring: tuple[float, float, float],
    coulomb: float,
    cogging: Array,
) -> Array:
    """Angle of a knob on a held shaft, from rest.

    The leapfrog method, with turning points and sticking in closed form. `value`: inertia, damping,
    rest angle and first angle.
    """
    inertia, damping, rest, angle = (float(number) for number in value)
    stiffness, knee, extra = spring
    step_s = log.period_s
    # Error of the method's frequency, to first order.
    inertia += stiffness * step_s**2 / 12.0
    twist, speed, half_s = angle - rest, 0.0, 0.5 * step_s
    result = np.empty(len(log.angle_rad))
    drive = log.motor_nm + cogging
    middles = np.append(0.5 * (drive[1:] + drive[:-1]), drive[-1]).tolist()
    for index, torque in enumerate(middles):
        result[index] = twist
        place = twist + half_s * speed
        held = stiffness * place
        if place > knee:
            held += extra * (place - knee)
        elif place < -knee:
            held += extra * (place + knee)
        pull = torque - held
        if speed == 0.0:
            if -coulomb <= pull <= coulomb:
                continue
            way = 1.0 if pull > 0.0 else -1.0
        else:
            way = 1.0 if speed > 0.0 else -1.0
        rate = (pull - damping * speed - way * coulomb) / inertia
        after = speed + rate * step_s
        if after * way >= 0.0:
            twist = place + half_s * after
            speed = after
            continue
        # It stops within this step, and turns back or sticks.
        until_s = -speed / rate
        twist += 0.5 * speed * until_s
        speed = 0.0
        if pull * way < -coulomb:
            left_s = step_s - until_s
            speed = (pull + way * coulomb) / inertia * left_s
            twist += 0.5 * speed * left_s
    return result + rest


def estimate_swing(
    log: Run,
    spring: tuple[float, float, float],
    rest: float,
    coulomb: float,
    cogging_nm: Callable[[Array], Array],
    inertia: float,
) -> tuple[Solution, Array]:
    """Fit inertia and damping of the knob's side to its angle; all else is nearly known."""
    angle = log.angle_rad + 0.5 * log.count_rad
    cogging = cogging_nm(angle)
    moving = _moving(log)
    measured = angle[moving]

    def model(value: Array) -> Array:
        result: Array = _swing(log, value, spring, coulomb, cogging)[moving]
        return result

    def cost(value: Array) -> float:
        return float(np.sum((model(value) - measured) ** 2))

    def best_of(starts: list[Array]) -> Array:
        return min(starts, key=cost)

    # Start from the inertia that the period gives. A poor start ends on a neighbouring period.
    first = float(angle[0])
    start = np.array([inertia, _DAMPING, rest, first])
    for shares in (np.geomspace(0.25, 0.97, 8), np.geomspace(0.9, 1.11, 7)):
        start = best_of([start * [share, 1.0, 1.0, 1.0] for share in shares])
    # The position within a count is unknown. A small change of it makes the sticking point jump.
    within = np.linspace(-0.45, 0.45, 7) * log.count_rad
    start = best_of(
        [
            start * [1.0, share, 1.0, 0.0] + [0.0, 0.0, 0.0, first + place]
            for share in (0.5, 1.0, 2.0)
            for place in within
        ]
    )
    best = gauss_newton(
        model,
        measured,
        start,
        scale=np.array([2e-3 * inertia, 3e-5, 1e-4, 1e-4]),
        lags=40,
        steps=12,
    )
    left = float(np.std(best.residual))
    if left > 3.0 * log.count_rad and left > 0.2 * float(np.std(measured)):
        raise Refusal(
            _STEP, "unexplained", "the knob's swing on the shaft strays by "
            f"{left / log.count_rad:.0f} counts from an inertia on a spring: something is loose, "
            "a hand is on the knob, or the motor cogs more often in a turn than it can show",
        )  # fmt: skip
    return best, _swing(log, best.value, spring, coulomb, cogging)


def swing_rad_s(angle: Array, log: Run) -> float:
    """Give the speed at which friction takes as much energy as a damping of friction over it."""
    speed = np.abs(np.diff(angle)) / log.period_s
    return float(np.sum(speed**2) / max(np.sum(speed), 1e-12))


def _moving(log: Run) -> Array:
    """Tell which samples lie near to a change of counts, shape (n,)."""
    changes = np.flatnonzero(np.diff(log.counts))
    near = np.zeros(len(log.counts) + 1)
    reach = round(_MOVING_S / log.period_s)
    np.add.at(near, np.maximum(changes - reach, 0), 1.0)
    np.add.at(near, np.minimum(changes + 2 + reach, len(log.counts)), -1.0)
    return np.asarray(np.cumsum(near)[:-1] > 0.0)
