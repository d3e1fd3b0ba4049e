"""A step with the brake off: friction, cogging and inertia of the knob that turns freely."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import numpy.typing as npt

from torsio.calibration.cogging import Cogging, find_waves
from torsio.calibration.numeric import Solution, kernel, linear, smooth
from torsio.calibration.play import Player, Run
from torsio.calibration.quantity import Array, Fit, Quantity, Refusal
from torsio.printed.config import EXCITATION_STILL_S

__all__ = ["Free", "estimate_free", "spin", "through_shaft"]

_FREE = "friction and inertia"
SLOW_RAD_S, FAST_RAD_S = 3.0, 80.0
FREE_LIMIT_RAD_S = 160.0  # overshoot of the turns
SLOW_S = 2.5
_THROUGH_SHAFT = 0.03  # share of a wave that its way through the shaft leaves uncertain
_FAST_S = 0.7  # until it turns the other way


@dataclass(frozen=True)
class Free:
    """The free knob as found.

    Attributes
    ----------
    inertia, coulomb, viscous
        Values of knob and brake side together; the dry friction once the brake has held and let go.
    amplitude
        Amplitude of the cogging's largest wave.
    through_shaft
        Share of that wave which the brake's side takes off in the slow turns; 0 until it is known.
    """

    inertia: Quantity
    coulomb: Quantity
    viscous: Quantity
    amplitude: Quantity
    offset: Quantity
    cogging: Cogging
    fits: tuple[Fit, ...]
    through_shaft: float = 0.0


def spin(player: Player, torque_nm: float, *, slow_s: float = SLOW_S) -> Run:
    """Turn slowly for so long each way, a turn and more by default, then fast both ways.

    Raises
    ------
    Refusal
        "runs_away", "held", or why the device disarmed.
    """
    slow = {"stiffness_nm_per_rad": 0.3, "damping_nm_s_per_rad": 6e-3}
    fast = {"damping_nm_s_per_rad": 6e-3}
    stretches = [
        (slow_s, {**slow, "servo_rad_s": SLOW_RAD_S}),
        (slow_s, {**slow, "servo_rad_s": -SLOW_RAD_S}),
        (_FAST_S, {**fast, "servo_rad_s": FAST_RAD_S}),
        (1.2, {**fast, "servo_rad_s": -FAST_RAD_S}),
        (0.8, {**fast, "servo_rad_s": 0.4 * FAST_RAD_S}),
        (0.6, {**fast, "servo_rad_s": -0.4 * FAST_RAD_S}),
        (0.3, {**fast, "servo_rad_s": 0.0}),
    ]
    log = player.chain(
        stretches,
        travel_rad=600.0,
        speed_limit_rad_s=FREE_LIMIT_RAD_S,
        torque_limit_nm=0.75 * torque_nm,
    )
    if log.stopped == "excitation_stopped" and not _encoder_failed(log):
        _refuse_slow(log)
    log.refuse_if_stopped(
        _FREE, "runs_away", "the device stopped the turns: the encoder stopped counting while "
        "the motor pulled, or the knob has changed. Look at the encoder's wires, its disc and its "
        "coupling",
    )  # fmt: skip
    return log


def _encoder_failed(log: Run) -> bool:
    """Whether the counts ended as no knob ends its turn: from one moment to the next."""
    still_s = 0.8 * EXCITATION_STILL_S
    last = len(log.counts) - 1
    moved = np.flatnonzero(np.diff(log.counts))
    if log.time_s[last] - log.time_s[moved[-1] if len(moved) else 0] < still_s:
        return True  # it left another bound
    if float(np.ptp(log.counts)) < 5.0:
        return True  # a knob that is held gives way as its shaft does
    end = int(moved[-1]) + 1
    begin = int(np.searchsorted(log.time_s, log.time_s[end] - 5e-3))
    speed = (log.angle_rad[end] - log.angle_rad[begin]) / (log.time_s[end] - log.time_s[begin])
    return abs(float(speed)) > 0.5 * SLOW_RAD_S


def _refuse_slow(log: Run) -> None:
    speed = float(np.max(np.abs(np.gradient(log.angle_rad[::8], log.time_s[::8]))))
    raise Refusal(
        _FREE, "held", f"the knob reaches {speed:.0f} rad/s only: it is held, rubs, "
        "or the motor is weaker than motor_torque_max_nm says", speed_rad_s=speed,
    )  # fmt: skip


@dataclass(frozen=True)
class _Rows:
    """Weighted equations: motor = inertia a + coulomb sign + viscous v + offset - cogging."""

    motor_nm: Array
    acceleration: Array
    speed: Array
    angle: Array
    jerk: Array
    motor_curve: Array
    window: Array
    period_s: float


def _rows(log: Run, half_s: float, least_rad_s: float) -> _Rows:
    """Weigh a run where the knob turns one way for the whole of a window."""
    half = max(round(half_s / log.period_s), 4)
    window, first, second = kernel(half, log.period_s)
    angle = log.angle_rad - log.angle_rad[0]
    speed = smooth(angle, first, odd=True)
    _, short, _ = kernel(max(round(6e-3 / log.period_s), 3), log.period_s)
    local = smooth(angle, short, odd=True)
    margin = (len(angle) - len(local)) // 2
    local = np.pad(local, margin, mode="edge")[: len(angle)]
    wide = np.lib.stride_tricks.sliding_window_view(local, len(window))
    same: npt.NDArray[np.bool_] = (wide.min(axis=1) > least_rad_s) | (
        wide.max(axis=1) < -least_rad_s
    )
    fourth = np.convolve(second, np.array([1.0, -2.0, 1.0]) / log.period_s**2)
    jerk = np.pad(np.convolve(angle, fourth[::-1], mode="valid"), 1)
    same[[0, -1]] = False  # where the fourth difference reaches beyond the run
    chosen = np.flatnonzero(same)
    chosen = chosen[:: max(half // 3, 1)]
    return _Rows(
        smooth(log.motor_nm, window)[chosen],
        smooth(angle, second)[chosen],
        speed[chosen],
        smooth(log.angle_rad, window)[chosen] + 0.5 * log.count_rad,
        jerk[chosen],
        smooth(log.motor_nm, second)[chosen],
        window,
        log.period_s,
    )


def _columns(rows: _Rows, periods: tuple[int, ...]) -> Array:
    """Give the equations' columns, cosine and sine of waves of so many periods at their end."""
    columns = [rows.acceleration, np.sign(rows.speed), rows.speed, np.ones_like(rows.speed)]
    since = (np.arange(len(rows.window)) - len(rows.window) // 2) * rows.period_s
    for count in periods:
        # The window takes some of a wave that passes within it.
        left = np.cos(np.outer(count * rows.speed, since)) @ rows.window
        columns += [-left * np.cos(count * rows.angle), -left * np.sin(count * rows.angle)]
    return np.column_stack(columns)


def _joint(slow: _Rows, fast: _Rows, periods: tuple[int, ...]) -> tuple[Solution, Array]:
    """Fit slow and fast turns together, each weighed by what it leaves; the waves come last."""
    flexible = np.column_stack([fast.jerk, -fast.motor_curve])
    slow_part = np.insert(_columns(slow, periods), [4, 4], 0.0, axis=1)
    fast_part = np.column_stack([_columns(fast, ()), flexible])
    waves = np.zeros((len(fast_part), 2 * len(periods)))
    fast_part = np.column_stack([fast_part, waves])
    slow_rms = float(np.std(linear(slow_part, slow.motor_nm).residual)) + 1e-9
    fast_rms = float(np.std(linear(fast_part, fast.motor_nm).residual)) + 1e-9
    weights = np.concatenate(
        [np.full(len(slow_part), 1 / slow_rms), np.full(len(fast_part), 1 / fast_rms)]
    )
    slopes = np.vstack([slow_part, fast_part])
    measured = np.concatenate([slow.motor_nm, fast.motor_nm])
    return linear(slopes * weights[:, None], measured * weights, lags=8), weights


def through_shaft(free: Free, log: Run, flexible_s2: float, knob_inertia_kg_m2: float) -> Free:
    """Estimate the cogging anew from `spin` with what the shaft takes of waves that pass fast.

    Parameters
    ----------
    flexible_s2
        The brake's inertia over the shaft's stiffness.
    knob_inertia_kg_m2
        Inertia of the knob's side alone.
    """
    periods = free.cogging.periods_per_rev
    if not periods:
        return free
    slow = _rows(log.between(0.2, 2 * SLOW_S), 0.02, 0.5)
    # The shaft's torque bends its twist, and with it the brake's inertia. So every torque on the
    # knob counts with its own bend.
    measured = slow.motor_nm + flexible_s2 * (slow.motor_curve - knob_inertia_kg_m2 * slow.jerk)
    measured -= free.inertia.value * slow.acceleration + free.viscous.value * slow.speed
    columns = _columns(slow, periods)[:, [1, 3, *range(4, 4 + 2 * len(periods))]]
    bends = 1.0 - flexible_s2 * np.outer(slow.speed, periods) ** 2
    columns[:, 2:] *= np.repeat(bends, 2, axis=1)
    fit = linear(columns, measured, lags=8)
    cogging = replace(
        free.cogging,
        cosine_nm=fit.value[2::2],
        sine_nm=fit.value[3::2],
        covariance=fit.covariance[2:, 2:],
    )
    # Waves that pass about as fast as the brake's side swings hardly turn the knob.
    first = abs(1.0 - float(bends[:, 0].mean()))
    swings = _THROUGH_SHAFT * first / max(abs(1.0 - first), 0.01)
    amplitude = replace(
        free.amplitude,
        value=float(cogging.amplitudes_nm[0]),
        standard_uncertainty=float(
            np.hypot(cogging.sigmas_nm[0], swings * cogging.amplitudes_nm[0])
        ),
    )
    return replace(free, cogging=cogging, amplitude=amplitude, through_shaft=first)


def _over_the_turn(slow: _Rows, cogging: Cogging, value: Array, unexplained: Array) -> Fit:
    """Give the picture of the cogging: what slow turns need less friction and inertia."""
    waves = slow.motor_nm - _columns(slow, ()) @ value[:4]
    left = unexplained[: len(waves)]
    count = len(cogging.periods_per_rev)
    return Fit(
        f"Cogging over the turn: {count} wave{'s' * (count != 1)}",
        "angle, turns", "torque on the knob, N m",
        np.mod(slow.angle / (2.0 * np.pi), 1.0), -waves, left - waves,
    )  # fmt: skip


def _refuse_if_heavy_or_held(log: Run, slow_s: float) -> None:
    speed = np.gradient(log.angle_rad[::8], log.time_s[::8])
    if float(np.max(np.abs(speed))) >= 0.4 * FAST_RAD_S:
        return
    # A knob that is held or rubs soon reaches its top speed. A heavy one keeps speeding up.
    since_s = log.time_s[::8] - log.time_s[0] - 2 * slow_s
    middle, end = np.interp([0.5 * _FAST_S, _FAST_S], since_s, speed)
    if end > 1.6 * middle > 0 and end > 2 * SLOW_RAD_S:
        raise Refusal(
            _FREE, "inertia", f"the knob speeds up slowly and only reaches {end:.0f} "
            "rad/s: something heavy is on it, or the motor gives far less than "
            "motor_torque_max_nm", speed_rad_s=float(end),
        )  # fmt: skip
    _refuse_slow(log)


def _refuse_what_does_not_fit(value: Array, offset_sigma: float, left: float) -> None:
    inertia, coulomb, _, offset = map(float, value[:4])
    if abs(offset) > 0.2 * abs(coulomb) + 5.0 * offset_sigma:
        raise Refusal(
            _FREE, "pulled", f"a steady torque of {1e3 * offset:+.1f} mN m pulls at the knob: "
            "take off weights and cables, turn the axis upright", offset_nm=offset,
        )  # fmt: skip
    if coulomb <= 0 or inertia <= 0 or left > 0.25 * abs(coulomb) + 1e-3:
        raise Refusal(
            _FREE, "unexplained", f"friction and inertia leave {1e3 * left:.1f} mN m "
            "unexplained: a hand is on the knob, or something is loose", residual_nm=left,
        )  # fmt: skip


def estimate_free(log: Run, *, slow_s: float = SLOW_S) -> Free:
    """Estimate friction, cogging and inertia from `spin`, with the same `slow_s`.

    Raises
    ------
    Refusal
        "held", "inertia", "pulled", "unexplained".
    """
    _refuse_if_heavy_or_held(log, slow_s)
    slow = _rows(log.between(0.2, 2 * slow_s), 0.02, 0.5)
    fast = _rows(log.between(2 * slow_s, 1e9), 0.09, 5.0)
    if len(slow.speed) < 20 or len(fast.speed) < 20:
        raise Refusal(
            _FREE,
            "held",
            "the knob does not turn evenly: it is held, or rubs somewhere in its turn",
        )
    # Less than a turn does not tell cogging from a rough spot.
    whole_turn = slow_s == SLOW_S
    find = partial(find_waves, partial(_columns, slow), slow.motor_nm)
    periods, left_nm = find() if whole_turn else ((), 0.0)
    fit, weights = _joint(slow, fast, periods)
    value = fit.value
    unexplained = fit.residual / weights
    cogging = Cogging(periods, value[6::2], value[7::2], fit.covariance[6:, 6:], left_nm)
    if periods:
        amplitude, amplitude_sigma = cogging.amplitudes_nm[0], cogging.sigmas_nm[0]
    else:
        # Cogging that was not found may be as large as the residual, or larger.
        plain = linear(_columns(slow, ()), slow.motor_nm)
        amplitude, amplitude_sigma = 0.0, 3.0 * float(np.std(plain.residual))
    left = float(np.sqrt(np.mean(unexplained**2)))
    _refuse_what_does_not_fit(value, fit.sigma(3), left)
    slow_fitted = slow.motor_nm - unexplained[: len(slow.speed)]
    fast_fitted = fast.motor_nm - unexplained[len(slow.speed) :]
    return Free(
        Quantity("inertia_kg_m2", float(value[0]), fit.sigma(0), "of all that turns"),
        Quantity(
            "coulomb_nm", float(value[1]), fit.sigma(1), "dry friction, as the brake leaves it"
        ),
        Quantity("viscous_nm_s_per_rad", float(value[2]), fit.sigma(2), "viscous friction"),
        Quantity(
            "cogging_nm", float(amplitude), float(amplitude_sigma),
            "amplitude of the cogging's largest wave",
        ),
        Quantity("offset_nm", float(value[3]), fit.sigma(3), "steady torque on the knob"),
        cogging,
        (
            Fit(
                "Slow turns: friction and cogging", "angle, rad", "motor, N m",
                slow.angle, slow.motor_nm, slow_fitted,
            ),
            Fit(
                "Fast turns: inertia and viscous friction", "speed, rad/s", "motor, N m",
                fast.speed, fast.motor_nm, fast_fitted,
            ),
            *((_over_the_turn(slow, cogging, value, unexplained),) if whole_turn else ()),
        ),
    )  # fmt: skip
