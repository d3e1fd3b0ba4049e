"""Steps with the brake held: the shaft's stiffness, curve and backlash; swing.py has the rest."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from torsio.calibration.left_out import LEFT_OUT
from torsio.calibration.numeric import Solution, crossings, gauss_newton, linear
from torsio.calibration.play import Player, Run
from torsio.calibration.quantity import Array, Fit, Quantity, Refusal
from torsio.calibration.swing import estimate_swing, swing_rad_s

__all__ = ["Shaft", "estimate_shaft", "hold_and_push", "pull_of"]

_STEP = "shaft"
_SETTLE_S, _SWEEP_S, _SWEEPS = 0.8, 0.9, 4
_REST_S = 0.35
_STEP_S, _STEPS, _STEP_RAMP_S = 0.11, 12, 6e-3
_TRAVEL_RAD = 0.4
# The motor's lag is believed to so much; it shifts all that is read off at a border of counts.
_LAG_S = 0.06e-3
# Backlash so many standard uncertainties from nothing is there.
_SURE = 4.0
# Means of so many neighbouring residuals vary by so much more than means of noise, if the residuals
# have a shape. Noise has 1.
_NEIGHBOURS, _NEIGHBOURS_RAD, _SHAPELY = 8, 6e-3, 2.5
_SHAPE_TILTS = 1.5  # a shape's part of the stiffness, in its amplitude over the reach


@dataclass(frozen=True)
class Shaft:
    """The shaft between knob and brake, as found.

    Attributes
    ----------
    knee, factor
        Twist where the stiffness changes, and by which factor; None if the shaft is straight.
    curve
        Twist in rad and torque in N m of its corners, shape (n, 2), from zero.
    knob_coulomb, knob_inertia, damping
        Values of the knob's side alone; the last two are None after a look for drift.
    shape_nm
        Amplitude of a shape that the curve leaves, such as of cogging that nobody found; 0 if it
        leaves noise.
    """

    stiffness: Quantity
    backlash: Quantity
    knee: Quantity | None
    factor: Quantity | None
    curve: Array
    knob_coulomb: Quantity
    knob_inertia: Quantity | None
    damping: Quantity | None
    shape_nm: float
    fits: tuple[Fit, ...]


def pull_of(motor_nm: float, brake_nm: float) -> float:
    """Give the torque in N m that pulls at a brake which holds so much."""
    return min(0.9 * motor_nm, 0.8 * brake_nm)


def hold_and_push(
    player: Player,
    *,
    motor_nm: float,
    brake_nm: float,
    coulomb_nm: float,
    drift: bool = False,
    shake: Sequence[tuple[float, dict[str, Any]]] | None = None,
) -> tuple[Run, Run]:
    """Hold the brake; pull slowly both ways, then in steps. Gives the two runs.

    `drift` pulls once each way, and leaves the steps out; `shake` is played in their place.

    Raises
    ------
    Refusal
        "does_not_hold", or why the device disarmed.
    """
    pull_nm = pull_of(motor_nm, brake_nm)
    sweeps = [
        (
            _SWEEP_S,
            {"motor_command_nm": pull_nm if sweep % 2 == 0 else -pull_nm, "ramp_s": _SWEEP_S},
        )
        for sweep in range(2 if drift else _SWEEPS)
    ]
    step_nm = min(coulomb_nm + 0.16 * motor_nm, 0.4 * motor_nm)
    steps = shake or [
        (
            _STEP_S * (1.0 + 0.3 * (step % 3)),
            # Not a jump: whose moment telemetry does not tell to a tick.
            {"motor_command_nm": step_nm if step % 2 == 0 else -step_nm, "ramp_s": _STEP_RAMP_S},
        )
        for step in range(0 if drift else _STEPS)
    ]
    settle = [
        (_SETTLE_S, {"motor_command_nm": 0.0}),
        (0.3, {"motor_command_nm": -pull_nm, "ramp_s": 0.3}),
    ]
    # The steps' fit begins with a knob at rest: it waits until the last pull has died away.
    rest = [(_REST_S, {"motor_command_nm": 0.0, "ramp_s": 0.2})]
    log = player.chain(
        [*settle, *sweeps, *rest, *steps],
        brake_command_nm=brake_nm,
        travel_rad=_TRAVEL_RAD,
        speed_limit_rad_s=60.0,
        torque_limit_nm=motor_nm,
    )
    slipped = abs(float(log.motor_nm[-3])) if len(log.motor_nm) > 3 else 0.0
    log.refuse_if_stopped(
        _STEP, "does_not_hold", f"the knob came loose at {1e3 * slipped:.0f} mN m, though the "
        f"brake should hold {1e3 * brake_nm:.0f}: brake or its wires are dead, it is weaker than "
        "brake_torque_max_nm, or a coupling slips", slipped_at_nm=slipped,
    )  # fmt: skip
    begin = _SETTLE_S + 0.3
    middle = begin + len(sweeps) * _SWEEP_S
    return log.between(begin, middle), log.between(middle + _REST_S - 0.05, 1e9)


@dataclass(frozen=True)
class _Edges:
    """Where the slow pulls crossed the borders of counts.

    Attributes
    ----------
    side
        On which the shaft is twisted, for a fit that lets it have backlash; None for one that does
        not.
    """

    angle_rad: Array
    torque_nm: Array
    way: Array
    side: Array | None = None


def _edges(log: Run, cogging_nm: Callable[[Array], Array]) -> _Edges:
    angles, torques, ways = [], [], []
    for sweep in range(round((log.time_s[-1] - log.time_s[0]) / _SWEEP_S)):
        part = log.between(sweep * _SWEEP_S + 0.01, (sweep + 1) * _SWEEP_S - 0.01)
        borders, torque = crossings(part.counts, part.motor_nm)
        way = 1.0 if sweep % 2 == 0 else -1.0
        # Noise toggles the counts where the knob still sticks.
        ahead = way * (part.motor_nm[-1] - torque) < way * (part.motor_nm[-1] - part.motor_nm[0])
        angles.append(borders[ahead] * part.count_rad)
        torques.append(torque[ahead])
        ways.append(np.full(int(ahead.sum()), way))
    angle = np.concatenate(angles)
    return _Edges(angle, np.concatenate(torques) + cogging_nm(angle), np.concatenate(ways))


def _spring(twist: Array, stiffness: float, knee: float, extra: float) -> Array:
    """Torque that twists a shaft: `stiffness` up to the knee, `stiffness + extra` beyond."""
    beyond = np.sign(twist) * np.maximum(np.abs(twist) - knee, 0.0)
    result: Array = stiffness * twist + extra * beyond
    return result


def _straight(edges: _Edges) -> Solution:
    """Fit stiffness, offset, friction and, with sides, what backlash takes off the torque."""
    columns = [edges.angle_rad, np.ones_like(edges.way), edges.way]
    if edges.side is not None:
        columns.append(edges.side)
    return linear(np.column_stack(columns), edges.torque_nm, lags=3)


def _bent(edges: _Edges, start: Solution) -> Solution:
    """Fit stiffness, rest angle, friction, knee, stiffness beyond it and half the backlash."""
    stiffness, offset, coulomb = start.value[:3]
    rest = -offset / stiffness
    best: Solution | None = None
    reach = float(np.max(np.abs(edges.angle_rad - rest)))

    def model(value: Array) -> Array:
        lost = 0.0 if edges.side is None else value[5] * edges.side
        twist = edges.angle_rad - value[1] - lost
        spring = _spring(twist, value[0], abs(value[3]), value[4])
        result: Array = spring + value[2] * edges.way
        return result

    for share in (0.25, 0.45, 0.65, 0.85):
        begin = [stiffness, rest, coulomb, share * reach, 0.1 * stiffness]
        scale = [1e-4 * stiffness, 1e-6, 1e-6, 2e-5, 1e-4 * stiffness]
        if edges.side is not None:
            begin, scale = [*begin, -float(start.value[3]) / stiffness], [*scale, 1e-6]
        trial = gauss_newton(model, edges.torque_nm, np.array(begin), scale=np.array(scale), lags=3)
        if best is None or np.sum(trial.residual**2) < np.sum(best.residual**2):
            best = trial
    assert best is not None
    return best


def _is_bent(straight: Solution, bent: Solution, reach: float) -> bool:
    before, after = (float(np.sum(fit.residual**2)) for fit in (straight, bent))
    known = abs(bent.value[4]) > 4.0 * bent.sigma(4) and bent.sigma(3) < 0.3 * reach
    inside = 0.05 * reach < abs(bent.value[3]) < 0.95 * reach
    return after < 0.7 * before and known and inside and bent.value[0] + bent.value[4] > 0


@dataclass(frozen=True)
class _Curve:
    """A shaft's fitted curve, bent or straight, with the friction of the knob's side."""

    fit: Solution
    is_bent: bool

    @property
    def stiffness(self) -> float:
        return float(self.fit.value[0])

    @property
    def rest(self) -> float:
        second = float(self.fit.value[1])
        return second if self.is_bent else -second / self.stiffness

    @property
    def coulomb(self) -> float:
        return float(self.fit.value[2])

    @property
    def knee(self) -> float:
        return abs(float(self.fit.value[3])) if self.is_bent else 1e9

    @property
    def extra(self) -> float:
        return float(self.fit.value[4]) if self.is_bent else 0.0

    @property
    def backlash(self) -> tuple[float, float]:
        """Backlash and its uncertainty, from a fit that allows it."""
        if self.is_bent:
            value, sigma = 2.0 * float(self.fit.value[5]), 2.0 * self.fit.sigma(5)
        else:
            value = -2.0 * float(self.fit.value[3]) / self.stiffness
            sigma = 2.0 * self.fit.sigma(3) / self.stiffness
        if value < 0.0:  # a shaft whose first knee was not seen, and that has none
            sigma = math.hypot(sigma, value)
        if self.is_bent:  # the knee's error is in the backlash too
            sigma = math.hypot(sigma, LEFT_OUT["knee_rad"][0] * self.knee)
        return value, sigma

    def corners(self, reach: float) -> Array:
        """Give twist and torque of the corners up to a twist."""
        ends = [0.0, self.knee, reach] if self.is_bent else [0.0, reach]
        twist = np.array(ends)
        return np.column_stack([twist, _spring(twist, self.stiffness, self.knee, self.extra)])

    def bend(self) -> tuple[Quantity | None, Quantity | None]:
        """Give the knee, and the factor by which the stiffness changes there, if there is one."""
        if not self.is_bent:
            return None, None
        stiffness, extra = self.stiffness, self.extra
        slope = np.array([-extra / stiffness**2, 1.0 / stiffness])
        among = self.fit.covariance[np.ix_([0, 4], [0, 4])]
        return (
            Quantity("knee_rad", self.knee, self.fit.sigma(3), "the shaft is linear up to here"),
            Quantity(
                "stiffness_factor", (stiffness + extra) / stiffness,
                float(np.sqrt(slope @ among @ slope)), "stiffness beyond it",
            ),
        )  # fmt: skip


def _curve(edges: _Edges) -> _Curve:
    straight = _straight(edges)
    if straight.value[0] <= 0:
        raise Refusal(
            _STEP,
            "unexplained",
            "the knob turns against the torque while the brake is held; a hand turns it, "
            "or the encoder or the motor is reversed",
        )
    bent = _bent(edges, straight)
    reach = float(np.ptp(edges.angle_rad)) / 2
    is_bent = _is_bent(straight, bent, reach)
    return _Curve(bent if is_bent else straight, is_bent)


def _with_sides(edges: _Edges, coulomb: float) -> _Edges:
    """Give those where the shaft is clearly twisted, and on which side."""
    held = edges.torque_nm - coulomb * edges.way
    clear = np.abs(held) > 0.05 * np.max(np.abs(held))
    return _Edges(
        edges.angle_rad[clear], edges.torque_nm[clear], edges.way[clear], np.sign(held[clear])
    )


@dataclass(frozen=True)
class _Swing:
    """The swings of the knob on the shaft, None where there were no steps."""

    inertia: Quantity | None = None
    damping: Quantity | None = None
    fits: tuple[Fit, ...] = ()


def _swing(
    steps: Run, curve: _Curve, cogging_nm: Callable[[Array], Array], inertia_kg_m2: float
) -> _Swing:
    # Without steps there is only the end of the rest before them.
    if len(steps.time_s) == 0 or steps.time_s[-1] - steps.time_s[0] <= _STEP_S:
        return _Swing()
    shape = curve.stiffness, curve.knee, curve.extra
    ring, angle = estimate_swing(steps, shape, curve.rest, curve.coulomb, cogging_nm, inertia_kg_m2)
    sigma = math.hypot(ring.sigma(1), curve.fit.sigma(2) / swing_rad_s(angle, steps))
    picture = Fit(
        "Brake held, steps: the knob rings on the shaft", "time, s", "twist, rad",
        steps.time_s - steps.time_s[0],
        steps.angle_rad + 0.5 * steps.count_rad - curve.rest, angle - curve.rest,
    )  # fmt: skip
    return _Swing(
        Quantity("knob_inertia_kg_m2", float(ring.value[0]), ring.sigma(0), "of motor and knob"),
        Quantity("shaft_damping_nm_s_per_rad", float(ring.value[1]), sigma, "of shaft and knob"),
        (picture,),
    )


def _of_sweeps(sweeps: Run, cogging_nm: Callable[[Array], Array]) -> tuple[_Edges, _Curve]:
    """Give where the knob turned at the slow pulls, and the curve through it."""
    edges = _edges(sweeps, cogging_nm)
    if len(edges.angle_rad) < 12:
        raise Refusal(
            _STEP, "rigid", f"the shaft twists by {np.ptp(sweeps.angle_rad) * 1e3:.1f} mrad only, "
            "too little for this encoder: the shaft is locked, the knob is held, or the encoder "
            "stopped counting",
        )  # fmt: skip
    return edges, _curve(edges)


def estimate_shaft(
    sweeps: Run, steps: Run, cogging_nm: Callable[[Array], Array], inertia_kg_m2: float
) -> Shaft:
    """Estimate the shaft and the knob's side from `hold_and_push`.

    Parameters
    ----------
    cogging_nm
        Torque on the knob over the angle.
    inertia_kg_m2
        Inertia of all that turns: the search begins there.

    Raises
    ------
    Refusal
        "rigid", "unexplained".
    """
    edges, curve = _of_sweeps(sweeps, cogging_nm)
    sides = _with_sides(edges, curve.coulomb)
    loose = _curve(sides)
    backlash, backlash_sigma = loose.backlash
    # A backlash that may be zero stays out of the fit: it would make the stiffness less certain.
    if backlash > _SURE * backlash_sigma:
        edges, curve = sides, loose
    fit, stiffness = curve.fit, curve.stiffness
    _refuse_if_it_strays(fit, edges)
    reach = float(np.ptp(edges.angle_rad)) / 2
    shape_nm = _shape_nm(fit.residual, edges.angle_rad)
    swing = _swing(steps, curve, cogging_nm, inertia_kg_m2)
    rate_nm_s = float(np.ptp(sweeps.motor_nm)) / _SWEEP_S
    coulomb = curve.coulomb
    if swing.damping is not None:  # slow as the pulls are, they feel a little of it
        coulomb -= max(swing.damping.value, 0.0) * rate_nm_s / stiffness
    picture = Fit(
        "Brake held, slow pulls: the shaft's curve", "twist, rad", "motor, N m",
        edges.angle_rad - curve.rest, edges.torque_nm, edges.torque_nm - fit.residual,
    )  # fmt: skip
    return Shaft(
        Quantity(
            "stiffness_nm_per_rad", stiffness,
            math.hypot(fit.sigma(0), _SHAPE_TILTS * shape_nm / reach), "of the shaft",
        ),
        Quantity(
            "backlash_rad", backlash, math.hypot(backlash_sigma, shape_nm / stiffness),
            "angle lost where the torque turns",
        ),
        *curve.bend(),
        curve.corners(reach),
        Quantity(
            "knob_coulomb_nm", coulomb, math.hypot(fit.sigma(2), rate_nm_s * _LAG_S),
            "dry friction of the knob's side",
        ),
        swing.inertia,
        swing.damping,
        shape_nm,
        (picture, *swing.fits),
    )  # fmt: skip


def _refuse_if_it_strays(fit: Solution, edges: _Edges) -> None:
    left = float(np.sqrt(np.mean(fit.residual**2)))
    if left > 0.04 * float(np.max(np.abs(edges.torque_nm))):
        raise Refusal(
            _STEP, "unexplained", f"the shaft's torque strays by {1e3 * left:.1f} mN m from its "
            "curve: the brake creeps or has a wide loop, a coupling slips, or a hand turns it",
            residual_nm=left,
        )  # fmt: skip


def _shape_nm(residual: Array, angle_rad: Array) -> float:
    """Give the amplitude of the residuals that neighbours share: they are no noise.

    Neighbours lie within an angle: a fine encoder also sees the knob ring on its shaft.
    """
    many = max(_NEIGHBOURS, round(_NEIGHBOURS_RAD / float(np.median(np.abs(np.diff(angle_rad))))))
    means = residual[: len(residual) // many * many].reshape(-1, many).mean(1)
    shape, noise = float(np.mean(means**2)), float(np.mean(residual**2)) / many
    return math.sqrt(2.0 * (shape - noise)) if shape > _SHAPELY * noise else 0.0
