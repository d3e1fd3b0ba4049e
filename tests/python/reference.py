"""The knob, its law and a virtual wall, a second time: from the equations, in 64-bit floats.

Nothing here comes from the product. The plant is integrated with SciPy's adaptive Runge-Kutta
method; sticking and sliding are separate modes, and the switches between them are located as
events. Signs: every torque is the torque on the knob.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Actuator:
    """Parameter set P1."""

    knob_inertia: float = 6e-5
    brake_inertia: float = 4e-5
    knob_coulomb: float = 6e-3
    brake_drag: float = 2e-3
    knob_viscous: float = 2.6e-5
    brake_viscous: float = 2e-6
    shaft_damping: float = 2e-4
    stiffness: float = 2.873
    brake_lag: float = 60e-3
    motor_lag: float = 44e-6
    motor_max: float = 85e-3
    brake_max: float = 110e-3
    brake_floor: float = 3.3e-3
    counts_per_rev: int = 8192


@dataclass(frozen=True)
class Hand:
    """A mass, spring and damper between the knob and where the hand means to be."""

    inertia: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    path: Callable[[float], tuple[float, float]] = lambda _: (0.0, 0.0)
    torque: Callable[[float], float] = lambda _: 0.0

    def on_knob(self, time: float, angle: float, speed: float) -> float:
        """Torque on the knob, the hand's own inertia aside."""
        position, velocity = self.path(time)
        return (
            self.torque(time)
            + self.stiffness * (position - angle)
            + self.damping * (velocity - speed)
        )


class Plant:
    """Two shafts, a spring between them, and friction that truly sticks at both ends."""

    def __init__(self, actuator: Actuator, hand: Hand) -> None:
        self.actuator = actuator
        self.hand = hand
        self.time = 0.0
        # knob angle, knob speed, brake angle, brake speed, motor torque, brake capacity
        self.state: Array = np.zeros(6)
        self.sliding = [0, 0]  # direction in which knob and brake slide, 0 is stuck
        self.command = (0.0, 0.0)

    def spring(self, x: Array) -> float:
        p = self.actuator
        return float(-p.stiffness * (x[0] - x[2]) - p.shaft_damping * (x[1] - x[3]))

    def _demands(self, time: float, x: Array) -> tuple[float, float]:
        """Torque on each shaft without its dry friction."""
        p = self.actuator
        spring = self.spring(x)
        knob = self.hand.on_knob(time, x[0], x[1]) + x[4] + spring - p.knob_viscous * x[1]
        return knob, -spring - p.brake_viscous * x[3]

    def _capacities(self, x: Array) -> tuple[float, float]:
        return self.actuator.knob_coulomb, float(x[5]) + self.actuator.brake_drag

    def _slope(self, time: float, x: Array) -> Array:
        p = self.actuator
        demands, capacities = self._demands(time, x), self._capacities(x)
        inertias = (p.knob_inertia + self.hand.inertia, p.brake_inertia)
        slope = np.zeros(6)
        for shaft in (0, 1):
            if self.sliding[shaft]:
                torque = demands[shaft] - self.sliding[shaft] * capacities[shaft]
                slope[2 * shaft] = x[2 * shaft + 1]
                slope[2 * shaft + 1] = torque / inertias[shaft]
        slope[4] = (self.command[0] - x[4]) / p.motor_lag
        slope[5] = (self.command[1] - x[5]) / p.brake_lag
        return slope

    def _settle(self) -> None:
        """Choose stick or slide for each shaft that is at rest."""
        for shaft in (0, 1):
            if self.sliding[shaft] == 0:
                self.state[2 * shaft + 1] = 0.0
        demands, capacities = (
            self._demands(self.time, self.state),
            self._capacities(self.state),
        )
        for shaft in (0, 1):
            if self.sliding[shaft] == 0 and abs(demands[shaft]) > capacities[shaft]:
                self.sliding[shaft] = 1 if demands[shaft] > 0 else -1

    def _event(self, shaft: int) -> Any:
        direction = self.sliding[shaft]

        def stops(_: float, x: Array) -> float:
            return float(x[2 * shaft + 1] * direction)

        def breaks_away(time: float, x: Array) -> float:
            return self._capacities(x)[shaft] - abs(self._demands(time, x)[shaft])

        event: Any = stops if direction else breaks_away
        event.terminal = True
        event.direction = -1
        return event

    def advance(self, duration: float) -> None:
        """Integrate over one control period, from event to event."""
        end = self.time + duration
        self._settle()
        in_vain = 0
        while end - self.time > 1e-12:
            # At the very edge of sticking, rounding can make a shaft break away and stop again for
            # ever without any time passing. A microsecond without looking leads over that.
            blind = in_vain > 4
            begin = self.time
            solution = solve_ivp(
                self._slope,
                (self.time, min(end, self.time + 1e-6) if blind else end),
                self.state,
                method="DOP853",
                rtol=1e-8,
                atol=1e-12,
                events=None if blind else [self._event(0), self._event(1)],
            )
            assert solution.success, solution.message
            in_vain = in_vain + 1 if solution.t[-1] - begin < 1e-9 else 0
            self.time = float(solution.t[-1])
            self.state = solution.y[:, -1]
            for shaft, times in enumerate(solution.t_events or ()):
                if len(times):
                    if self.sliding[shaft]:
                        self.sliding[shaft] = 0
                        self.state[2 * shaft + 1] = 0.0
                    else:
                        demand = self._demands(self.time, self.state)[shaft]
                        self.sliding[shaft] = 1 if demand > 0 else -1
            self._settle()


class PaperLaw:
    """The control law of the paper, one call a tick, in the order of its equations."""

    def __init__(self, actuator: Actuator, *, beta: float, period: float) -> None:
        self.actuator = actuator
        self.beta = beta
        self.decay = math.exp(-period / actuator.brake_lag)
        self.brake_command = 0.0
        self.brake = 0.0
        self.spring = 0.0

    def step(self, delta_angle: float, desired: float) -> tuple[float, float]:
        """Take the knob's motion and the wanted torque; give motor torque and brake command."""
        p = self.actuator
        self.brake = self.brake_command + (self.brake - self.brake_command) * self.decay
        bound = max(self.brake, p.brake_floor)
        self.spring = min(max(self.spring - p.stiffness * delta_angle, -bound), bound)
        helps = desired * self.spring >= 0
        motor = desired - self.spring if helps else desired
        motor = min(max(motor, -p.motor_max), p.motor_max)
        if desired == 0:
            motor = 0.0
        self.brake_command = min(self.beta * abs(desired), p.brake_max) if helps else 0.0
        return motor, self.brake_command


class CalibratedLaw:
    """The law that knows what turns with the brake, its hysteresis and its two lags.

    The brake's side is a mass that slides or sticks, followed in short steps from the knob's angle:
    where the product has one equation for the end of a tick, this goes through the tick.
    """

    step_s = 2.5e-6

    def __init__(
        self,
        actuator: Actuator,
        *,
        beta: float,
        period: float,
        hysteresis: float = 0.0,
        release_lag: float | None = None,
    ) -> None:
        self.actuator = actuator
        self.beta = beta
        self.period = period
        self.hysteresis = hysteresis
        self.release_lag = actuator.brake_lag if release_lag is None else release_lag
        self.brake_command = 0.0
        self.coil = 0.0
        self.brake = 0.0
        self.twist = 0.0
        self.slide = 0.0  # speed of the brake's side
        self.drag = 0.0  # that the motor takes off

    def _follow_brake(self) -> float:
        lag = self.actuator.brake_lag if self.brake_command > self.coil else self.release_lag
        self.coil += (self.brake_command - self.coil) * -math.expm1(-self.period / lag)
        # The iron stays where it is as long as it is within the loop.
        if self.brake < self.coil - self.hysteresis:
            self.brake = self.coil - self.hysteresis
        if self.brake > self.coil + self.hysteresis:
            self.brake = self.coil + self.hysteresis
        return max(self.brake + self.actuator.brake_drag, self.actuator.brake_floor)

    def _follow_spring(self, delta_angle: float, holds: float) -> float:
        steps = math.ceil(self.period / self.step_s)
        p, step = self.actuator, self.period / steps
        for _ in range(steps):
            self.twist += delta_angle / steps
            drive = p.stiffness * self.twist
            if self.slide == 0.0 and abs(drive) <= holds:
                continue
            way = math.copysign(1.0, self.slide if self.slide != 0.0 else drive)
            faster = self.slide + step * (drive - way * holds) / p.brake_inertia
            self.slide = faster if faster * way > 0.0 else 0.0
            self.twist -= step * self.slide
        return -p.stiffness * self.twist

    def step(self, delta_angle: float, desired: float) -> tuple[float, float]:
        """Take the knob's motion and the wanted torque; give motor torque and brake command."""
        p = self.actuator
        holds = self._follow_brake()
        self.spring = self._follow_spring(delta_angle, holds)
        helps = desired * self.spring >= 0
        # The motor may take half of the knob's friction off the inertia.
        most = holds + 0.5 * p.knob_coulomb
        countered = min(max(self.spring, -most), most)
        # What the brake's current holds, and of the drag no more than is wanted; on the way.
        counts = abs(delta_angle) * p.counts_per_rev / (2 * math.pi)
        change = min(1.2 * abs(delta_angle), 0.25 * p.knob_coulomb * counts)
        if abs(desired) > self.drag:
            self.drag = min(self.drag + change, abs(desired))
        else:
            self.drag = max(self.drag - change, abs(desired))
        most = self.coil + self.drag
        motor = desired - min(max(countered, -most), most)
        self.brake_command = min(self.beta * abs(desired), p.brake_max) if helps else 0.0
        return min(max(motor, -p.motor_max), p.motor_max), self.brake_command


def wall_torque(angle: float, *, surface: float, stiffness: float) -> float:
    """Torque of a wall that is solid above its surface."""
    return -stiffness * max(angle - surface, 0.0)


def piecewise(
    points: list[tuple[float, float]],
) -> Callable[[float], tuple[float, float]]:
    """Value and slope of a path through points (time, value), held before and after."""

    def path(time: float) -> tuple[float, float]:
        if time < points[0][0]:
            return points[0][1], 0.0
        for (t0, v0), (t1, v1) in itertools.pairwise(points):
            if t0 <= time < t1:
                slope = (v1 - v0) / (t1 - t0)
                return v0 + slope * (time - t0), slope
        return points[-1][1], 0.0

    return path


def run_wall(
    actuator: Actuator,
    hand: Hand,
    *,
    surface: float,
    stiffness: float,
    beta: float,
    duration: float,
    period: float = 1e-3,
) -> dict[str, Array]:
    """Closed loop of law and plant; one row a tick, taken before the tick's torques act."""
    plant = Plant(actuator, hand)
    law = PaperLaw(actuator, beta=beta, period=period)
    rows = []
    last_count = 0
    resolution = 2 * math.pi / actuator.counts_per_rev
    for tick in range(round(duration / period)):
        count = math.floor(plant.state[0] / resolution)
        desired = wall_torque(count * resolution, surface=surface, stiffness=stiffness)
        motor, brake_command = law.step((count - last_count) * resolution, desired)
        last_count = count
        rows.append(
            (
                *(tick * period, count, plant.state[0], desired, motor, law.spring),
                *(plant.spring(plant.state), brake_command),
            )
        )
        plant.command = (motor, brake_command)
        plant.advance(period)
    names = (
        *("time", "count", "angle", "desired", "motor", "sensed"),
        *("spring", "brake_command"),
    )
    return dict(zip(names, np.array(rows, dtype=np.float64).T, strict=True))
