"""The plant's motion from its equations alone, as the truth for the study `fidelity`.

It shares nothing with the emulator's C++ code: SciPy's DOP853 at tight tolerances over the absolute
angles of both shafts, with friction by explicit switching of modes at located events, and the lags
of motor and brake in closed form. It is some 10,000 times slower than the emulator.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Literal, cast

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from torsio.printed.hands import Hand, ImpedanceHand, TorqueHand
from torsio.printed.plant import PlantParams

Array = npt.NDArray[np.float64]
Lag = Callable[[float], float]

PLANT: Final = PlantParams()
"""The plant of the study."""

RTOL: Final = 1e-11
Method = Literal["RK45", "DOP853", "LSODA"]


@dataclass(frozen=True)
class HandTorque:
    """Torque of a hand on the knob: force(t) - stiffness angle - damping speed.

    The force is linear between `corners_s`, where it or its slope may jump.
    """

    corners_s: Array
    values: Array
    stiffness_nm_per_rad: float = 0.0
    damping_nm_s_per_rad: float = 0.0
    inertia_kg_m2: float = 0.0

    def piece(self, time_s: float) -> tuple[float, float, float]:
        """Give the force at a time, its slope from there on, and when that piece ends."""
        after = int(np.searchsorted(self.corners_s, time_s, side="right"))
        times, values = self.corners_s, self.values
        if after == 0:
            value, slope = float(values[0]), 0.0
        elif after == len(times):
            value, slope = float(values[-1]), 0.0
        else:
            slope = float((values[after] - values[after - 1]) / (times[after] - times[after - 1]))
            value = float(values[after - 1]) + slope * (time_s - float(times[after - 1]))
        end = float(times[after]) if after < len(times) else math.inf
        k, c = self.stiffness_nm_per_rad, self.damping_nm_s_per_rad
        if k == 0.0 and c == 0.0:
            return value, slope, end
        return k * value + c * slope, k * slope, end


def hand_torque(hand: Hand) -> HandTorque:
    """Put a hand into the form that the truth and other simulators take."""
    if isinstance(hand, TorqueHand):
        knots = np.asarray(hand.torque_nm, float)
        return HandTorque(knots[:, 0], knots[:, 1])
    if isinstance(hand, ImpedanceHand):
        knots = np.asarray(hand.intended_angle_rad, float)
        return HandTorque(
            knots[:, 0],
            knots[:, 1],
            hand.stiffness_nm_per_rad,
            hand.damping_nm_s_per_rad,
            hand.inertia_kg_m2,
        )
    raise TypeError(f"no truth for a hand of type {type(hand).__name__}")


@dataclass
class Truth:
    """Where the knob and the brake are at the end of each control period, each of shape (n,)."""

    angle_rad: Array
    brake_angle_rad: Array
    friction_events: int


def _approaching(begin: float, begin_nm: float, end_nm: float, time_constant_s: float) -> Lag:
    return lambda t: end_nm + (begin_nm - end_nm) * math.exp(-(t - begin) / time_constant_s)


@dataclass(frozen=True)
class _Piece:
    """The torques of a step: commands are held, and the hand's torque is a line."""

    plant: PlantParams
    hand: HandTorque
    start: float
    force: float
    slope: float
    motor: Lag
    brake: Lag

    def demands(self, t: float, y: Array) -> tuple[float, float]:
        """Return the torque on each shaft without its friction."""
        p, hand = self.plant, self.hand
        spring = p.shaft_stiffness_nm_per_rad * (y[0] - y[1])
        spring += p.shaft_damping_nm_s_per_rad * (y[2] - y[3])
        push = self.force + self.slope * (t - self.start) - hand.stiffness_nm_per_rad * y[0]
        push -= hand.damping_nm_s_per_rad * y[2]
        knob = push + self.motor(t) - spring - p.knob_viscous_nm_s_per_rad * y[2]
        return knob, spring - p.brake_viscous_nm_s_per_rad * y[3]

    def capacity(self, shaft: int, t: float) -> float:
        """Return what a shaft's friction holds."""
        if shaft:
            return self.brake(t) + self.plant.brake_drag_nm
        return self.plant.knob_coulomb_nm

    def rates(self, mode: Sequence[int]) -> Callable[[float, Array], list[float]]:
        """Return the derivative for shafts that rest (0) or slip in a direction."""
        p = self.plant
        inertia = (p.knob_inertia_kg_m2 + self.hand.inertia_kg_m2, p.brake_inertia_kg_m2)

        def of(t: float, y: Array) -> list[float]:
            torque = self.demands(t, y)
            speedup = [
                (torque[i] - mode[i] * self.capacity(i, t)) / inertia[i] if mode[i] else 0.0
                for i in (0, 1)
            ]
            return [y[2], y[3], *speedup]

        return of

    def room(self, shaft: int, direction: int) -> Callable[[float, Array], float]:
        """Return what falls to zero where a shaft stops, or where one at rest begins to slip."""

        def slipping(_t: float, y: Array) -> float:
            return float(direction * y[2 + shaft])

        def held(t: float, y: Array) -> float:
            return self.capacity(shaft, t) - abs(self.demands(t, y)[shaft])

        event: Any = slipping if direction else held
        event.terminal = True
        event.direction = -1
        return cast(Callable[[float, Array], float], event)


@dataclass
class _Run:
    plant: PlantParams
    hand: HandTorque
    method: Method
    rtol: float
    t: float = 0.0
    #: angle A, angle B, speed A, speed B
    y: Array = field(default_factory=lambda: np.zeros(4))
    mode: list[int] = field(default_factory=lambda: [0, 0])
    motor_nm: float = 0.0
    brake_nm: float = 0.0
    events: int = 0

    def advance(self, end: float, motor_command_nm: float, brake_command_nm: float) -> None:
        """Go on while the commands are held."""
        p = self.plant
        motor = _approaching(self.t, self.motor_nm, motor_command_nm, p.motor_time_constant_s)
        brake = _approaching(self.t, self.brake_nm, brake_command_nm, p.brake_time_constant_s)
        while self.t < end:
            force, slope, piece_end = self.hand.piece(self.t)
            piece = _Piece(p, self.hand, self.t, force, slope, motor, brake)
            # A shaft at rest goes when the torque on it is more than friction holds.
            for shaft, demand in enumerate(piece.demands(self.t, self.y)):
                if not self.mode[shaft] and abs(demand) > piece.capacity(shaft, self.t) * (
                    1 + 1e-13
                ):
                    self._let_go(shaft, demand)
            self._go(piece, min(end, piece_end))
        self.motor_nm, self.brake_nm = motor(end), brake(end)
        self.t = end

    def _go(self, piece: _Piece, until: float) -> None:
        """Go on to the next stop or slip of a shaft."""
        solution = solve_ivp(
            piece.rates(tuple(self.mode)),
            (self.t, until),
            self.y,
            method=self.method,
            rtol=self.rtol,
            atol=1e-3 * self.rtol,
            first_step=min(2e-5, until - self.t),
            events=[piece.room(shaft, self.mode[shaft]) for shaft in (0, 1)],
        )
        if not solution.success:
            raise RuntimeError(f"SciPy gave up: {solution.message}")
        self.y = solution.y[:, -1].copy()
        self.t = float(solution.t[-1])
        for shaft, stops in enumerate(cast(list[Array], solution.t_events)):
            if not stops.size:
                continue
            self.events += 1
            if self.mode[shaft]:
                self.mode[shaft] = 0
                self.y[2 + shaft] = 0.0
            else:
                self._let_go(shaft, piece.demands(self.t, self.y)[shaft])

    def _let_go(self, shaft: int, demand: float) -> None:
        self.mode[shaft] = 1 if demand > 0 else -1


def simulate_truth(
    plant: PlantParams,
    hand: HandTorque,
    motor_nm: Array,
    brake_nm: Array,
    *,
    period_s: float,
    method: Method = "DOP853",
    rtol: float = RTOL,
    on_progress: Callable[[int], None] = lambda _: None,
) -> Truth:
    """Simulate from rest at angle 0 under commands that are held for a period each.

    Parameters
    ----------
    method, rtol
        Of `scipy.integrate.solve_ivp`; the absolute tolerance is a thousandth of the relative one.
    motor_nm, brake_nm
        Commands of shape (n,), within the limits of the actuators.
    on_progress
        Called now and then with the number of periods that are done.
    """
    run = _Run(plant, hand, method, rtol)
    angles = np.empty((len(motor_nm), 2))
    for i, (motor, brake) in enumerate(zip(motor_nm, brake_nm, strict=True)):
        run.advance((i + 1) * period_s, float(motor), float(brake))
        angles[i] = run.y[:2]
        if i % 50 == 0:
            on_progress(i)
    on_progress(len(motor_nm))
    return Truth(angles[:, 0], angles[:, 1], run.events)
