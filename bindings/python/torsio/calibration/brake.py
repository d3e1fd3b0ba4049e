"""Steps against the slipping brake: torque over command, hysteresis, and the lags both ways."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from torsio.calibration.brake_curve import BrakeCurve, curve_of
from torsio.calibration.free import Free
from torsio.calibration.numeric import Solution, gauss_newton, kernel, linear, play_of, smooth
from torsio.calibration.play import Player, Run
from torsio.calibration.quantity import Array, Fit, Quantity, Refusal

__all__ = ["STAIRS", "STAIRS_RAD_S", "Brake", "estimate_brake", "hold_and_let_go", "slip"]

_STEP = "brake"
STAIRS = (0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0, 1.0, 0.0, 1.0, 0.0)
_LOOP_EXPLAINS = 0.8  # share of the squares left without a loop; otherwise there is no loop
_WIDEST = 0.4  # half a loop of the highest stair; less of the stairs is left to measure it
_DWELL_S, _BEGIN_S = 0.5, 0.8
STAIRS_RAD_S = 4.0
# Longer than a slow brake takes, and than a board waits before it demagnetises one.
_HOLD_S, _LET_GO_S = 0.6, 1.0


@dataclass(frozen=True)
class Brake:
    """The brake as found; lags from command to torque.

    Attributes
    ----------
    left
        Torque that it holds without current, beyond its drag, once it has held and let go.
    top_nm
        The highest stair.
    """

    gain: Quantity
    hysteresis: Quantity
    rise: Quantity
    release: Quantity
    left: Quantity
    top_nm: float
    curve: BrakeCurve
    fits: tuple[Fit, ...]


def hold_and_let_go(player: Player, brake_nm: float, step: str = _STEP) -> None:
    """Hold the brake and let go of it, so that it leaves what it always leaves.

    A brake with hysteresis keeps torque from an earlier use: nothing when it is new, and afterwards
    half the width of its loop, or the rest after a board demagnetised it.

    Raises
    ------
    Refusal
        Why the device disarmed.
    """
    log = player.chain(
        [(_HOLD_S, {"brake_command_nm": brake_nm}), (_LET_GO_S, {"brake_command_nm": 0.0})],
        travel_rad=60.0,
        speed_limit_rad_s=60.0,
        torque_limit_nm=0.0,
    )
    # The other steps notice a knob that turns meanwhile.
    if log.stopped != "excitation_stopped":
        log.refuse_if_stopped(step, "", "")


def slip(player: Player, *, motor_nm: float, brake_nm: float, coulomb_nm: float) -> Run:
    """Turn the knob slowly through the brake while its command goes up and down stairs.

    Raises
    ------
    Refusal
        "runs_away", or why the device disarmed.
    """
    top_nm = min(0.7 * motor_nm - coulomb_nm, brake_nm)
    servo = {
        "stiffness_nm_per_rad": 0.5,
        "damping_nm_s_per_rad": 6e-3,
        "servo_rad_s": STAIRS_RAD_S,
    }
    stairs = [(_DWELL_S, {**servo, "brake_command_nm": share * top_nm}) for share in STAIRS]
    log = player.chain(
        [(_BEGIN_S, {**servo, "brake_command_nm": 0.0}), *stairs],
        travel_rad=60.0,
        speed_limit_rad_s=60.0,
        torque_limit_nm=motor_nm,
    )
    log.refuse_if_stopped(
        _STEP, "runs_away", "the device stopped the turn through the brake: the encoder stopped "
        "counting while the motor pulled, or the brake holds more than it is told",
    )  # fmt: skip
    return log


def _left(fit: Solution) -> float:
    return float(np.sum(fit.residual**2))


def _with_width(fit: Solution, sigma: float) -> Solution:
    """Give a fit without a loop the width 0, as uncertain as this."""
    covariance = np.insert(np.insert(fit.covariance, 1, 0.0, axis=0), 1, 0.0, axis=1)
    covariance[1, 1] = sigma**2
    return Solution(np.insert(fit.value, 1, 0.0), covariance, fit.residual)


def _braked(
    time_s: Array,
    begins_s: Array,
    commands: Array,
    width: float,
    first: float,
    lags: tuple[float, float],
) -> Array:
    """Answer of a brake whose coil lags, and whose torque follows the coil with a play.

    `first` is the torque left without current.
    """
    result = np.full(len(time_s), first)
    current, torque = float(commands[0]), first
    ends = np.append(begins_s[1:], time_s[-1] + 1.0)
    for begin, end, command in zip(begins_s, ends, commands, strict=True):
        rises = command > current
        lag = max(lags[0] if rises else lags[1], 1e-4)
        chosen = (time_s >= begin) & (time_s < end)
        left = (current - command) * np.exp(-(time_s[chosen] - begin) / lag)
        follows = command + left - width if rises else command + left + width
        moves = follows > torque if rises else follows < torque
        result[chosen] = np.where(moves, follows, torque)
        current = command + (current - command) * float(np.exp(-(end - begin) / lag))
        torque = max(torque, current - width) if rises else min(torque, current + width)
        torque = 0.0 if command == first == 0.0 else torque  # a board has demagnetised it
    return result


def _targets(commands: Array, half_width_nm: float, left: float) -> Array:
    """Give where a brake of gain 1 goes, command by command; `left` is its torque without."""
    return np.where(commands == 0.0, left, play_of(commands, half_width_nm, left))


def _over_command(curve: BrakeCurve, gain: float, half_width_nm: float, left: float) -> Fit:
    """Give the picture of the brake's torque over its command."""
    command, torque = (
        np.array([getattr(one, name) for one in curve.points])
        for name in ("command_nm", "torque_nm")
    )
    return Fit(
        f"Brake over its command: {curve.in_words()}", "command, N m", "torque, N m",
        command, torque, gain * _targets(command, half_width_nm, left),
    )  # fmt: skip


@dataclass(frozen=True)
class _Stairs:
    """The stairs as they were measured."""

    time_s: Array
    torque_nm: Array  # that brake and friction took, smoothed, shape (n,) like the times
    turning: npt.NDArray[np.bool_]
    chosen: npt.NDArray[np.intp]  # numbers of the rows that a fit uses
    through: Array  # smooths a model like the torque
    begins_s: Array  # of each stair
    commands_nm: Array
    began_sigma_s: float  # by so much a begin may be off
    row_s: float  # between two chosen rows
    demagnetised: bool

    @property
    def top_nm(self) -> float:
        """The highest stair."""
        return float(np.max(self.commands_nm))

    @property
    def measured(self) -> Array:
        """The torque at the chosen rows."""
        return self.torque_nm[self.chosen]

    def model(self, value: Array) -> Array:
        """Give the torque at the chosen rows by gain, half a loop, both lags and friction."""
        gain, width, rise, release, friction = (float(number) for number in value)
        width, lags = abs(width), (abs(rise), abs(release))
        first = 0.0 if self.demagnetised else width
        braked = _braked(self.time_s, self.begins_s, self.commands_nm, width, first, lags)
        padded = np.pad(braked, len(self.through) // 2, mode="edge")
        smoothed = np.convolve(padded, self.through, mode="valid")[: len(self.time_s)]
        return np.asarray(gain * smoothed + friction, dtype=np.float64)[self.chosen]


def _stairs_of(log: Run, free: Free, flexible_s2: float, *, demagnetised: bool) -> _Stairs:
    half = max(round(12e-3 / log.period_s), 3)
    window, first, second = kernel(half, log.period_s)
    time_s = log.time_s[half + 1 : len(log.time_s) - half - 1]
    speed = smooth(log.angle_rad - log.angle_rad[0], first, odd=True)
    acceleration = smooth(log.angle_rad - log.angle_rad[0], second)
    given = log.motor_nm + free.cogging.torque_nm(log.angle_rad)
    motor = np.convolve(given, window, mode="valid").astype(np.float64)[: len(time_s)]
    turning = (speed > 0.3) & (time_s > log.time_s[0] + 0.4)
    changes = np.flatnonzero(np.abs(np.diff(log.brake_nm)) > 1e-6) + 1
    # A sample shows the command at its begin, so of the tick before it. A step may come in any of
    # the ticks since the last sample.
    began_s = log.time_s[changes] - 0.5 * (log.period_s + log.tick_s)
    begins = np.append(log.time_s[0] - 1.0, began_s)
    commands = np.append(log.brake_nm[0], log.brake_nm[changes])
    thin = max(round(2e-3 / log.period_s), 1)
    # When a board demagnetises, and how much of it, no model says.
    told = commands[np.searchsorted(begins, time_s, side="right") - 1]
    known = turning & ~(demagnetised & (told == 0.0))
    return _Stairs(
        time_s,
        motor - free.inertia.value * acceleration - free.viscous.value * speed,
        turning,
        np.flatnonzero(known)[::thin],
        # The brake's inertia on the shaft's spring takes a part of how its torque bends.
        window - flexible_s2 * second,
        begins,
        commands,
        math.sqrt(max(log.period_s**2 - log.tick_s**2, 0.0) / 12.0),
        thin * log.period_s,
        demagnetised,
    )


def _fitted(stairs: _Stairs) -> Solution:
    """Fit gain, half a loop, both lags and friction."""
    measured, top = stairs.measured, stairs.top_nm
    begin = np.array([1.0, 0.0, 0.06, 0.06, float(np.min(measured))])
    scale = np.array([1e-3, 2e-5, 1e-4, 1e-4, 1e-5])
    options: dict[str, int] = {"lags": max(round(0.06 / stairs.row_s), 4), "steps": 15}
    trials = [
        gauss_newton(
            stairs.model, measured, begin + np.array([0.0, width, 0.0, 0.0, 0.0]), scale=scale,
            **options,
        )
        for width in (0.02 * top, 0.15 * top, 0.3 * top, 0.45 * top)
    ]  # fmt: skip
    best = min(trials, key=_left)
    # A narrow loop takes the shaft's winding for its own; without one the lags are right.
    narrow = gauss_newton(
        lambda value: stairs.model(np.insert(value, 1, 0.0)),
        measured, np.delete(begin, 1), scale=np.delete(scale, 1), **options,
    )  # fmt: skip
    if _left(best) > _LOOP_EXPLAINS * _left(narrow):
        return _with_width(narrow, math.hypot(best.value[1], best.sigma(1)))
    return best


def _refuse_odd(fit: Solution, top: float) -> None:
    """Refuse what is no brake up to this torque."""
    gain, width = float(fit.value[0]), float(fit.value[1])
    left = float(np.sqrt(np.mean(fit.residual**2)))
    if gain < 0.1 or abs(width) > _WIDEST * top:
        raise Refusal(
            _STEP, "wide_loop", "the brake's torque hardly follows its command up and down to "
            f"{1e3 * top:.0f} mN m, as much as the motor can turn it through: its loop "
            "(hysteresis) is nearly as wide, or its wires came off", gain=gain,
        )  # fmt: skip
    if gain < 0.3:
        raise Refusal(
            _STEP, "no_brake", f"the brake gives {100 * gain:.0f} % of the commanded torque: "
            "it is dead, its wires are off, or brake_torque_constant_nm_per_a is wrong", gain=gain,
        )  # fmt: skip
    if left > 0.06 * top + 0.5e-3:
        raise Refusal(
            _STEP, "unexplained", f"the brake's torque strays by {1e3 * left:.1f} mN m from a "
            "brake with hysteresis and a lag: the brake is at its limit or sticks, or a hand is on "
            "the knob", residual_nm=left,
        )  # fmt: skip


def _left_behind(stairs: _Stairs, fit: Solution) -> Quantity:
    """Give the torque that the brake keeps, once it has held and let go."""
    gain, width = float(fit.value[0]), abs(float(fit.value[1]))
    value, sigma = gain * width, math.hypot(gain * fit.sigma(1), width * fit.sigma(0))
    if stairs.demagnetised:
        idle = stairs.torque_nm[stairs.turning & (stairs.time_s < stairs.begins_s[1])]
        mean = linear(np.ones((len(idle), 1)), idle, lags=max(len(idle) // 4, 1))
        value, sigma = (
            float(mean.value[0]) - float(fit.value[4]),
            math.hypot(mean.sigma(0), fit.sigma(4)),
        )
    return Quantity("left_nm", value, sigma, "once it has held and let go")


def estimate_brake(log: Run, free: Free, flexible_s2: float, *, demagnetised: bool) -> Brake:
    """Estimate the brake from `slip`, after `hold_and_let_go`.

    Parameters
    ----------
    free
        Friction, cogging and inertia of all that turns, once the brake has held and let go.
    flexible_s2
        The brake's inertia over the shaft's stiffness.
    demagnetised
        True if the board takes away what is left of it a while after it has let go, all or some.

    Raises
    ------
    Refusal
        "wide_loop", "no_brake", "unexplained".
    """
    stairs = _stairs_of(log, free, flexible_s2, demagnetised=demagnetised)
    fit = _fitted(stairs)
    _refuse_odd(fit, stairs.top_nm)
    gain, width, rise, release, friction = (float(number) for number in fit.value)
    width = abs(width)
    time_s, measured = stairs.time_s[stairs.chosen], stairs.measured
    fitted_nm = measured - fit.residual
    left = _left_behind(stairs, fit)
    curve = curve_of(
        time_s, measured, fitted_nm - friction, (stairs.begins_s, stairs.commands_nm),
        gain=gain, half_width_nm=width,
        friction=free.coulomb.less("friction_nm", left, "the loop aside"),
    )  # fmt: skip

    def lag(name: str, value: float, at: int, way: str) -> Quantity:
        sigma = math.hypot(fit.sigma(at), stairs.began_sigma_s)
        return Quantity(name, abs(value), sigma, f"lag on the way {way}")

    picture = Fit(
        "Brake stairs: torque, hysteresis and lags", "time, s", "brake and friction, N m",
        time_s - log.time_s[0], measured, fitted_nm,
    )  # fmt: skip
    return Brake(
        Quantity("brake_gain", gain, fit.sigma(0), "torque over command"),
        Quantity("hysteresis_nm", width, fit.sigma(1), "half the width of its loop"),
        lag("rise_s", rise, 2, "up"),
        lag("release_s", release, 3, "down"),
        left,
        stairs.top_nm,
        curve,
        (picture, _over_command(curve, gain, width, 0.0 if demagnetised else width)),
    )
