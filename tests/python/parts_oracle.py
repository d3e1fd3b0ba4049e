"""An independent simulation of the plant with its parts, as an oracle for the emulator's.

Nothing is shared with the emulator: absolute angles in place of twists, DOP853 in place of matrix
exponentials, friction as modes that events change, the equations from docs/explanation/emulator.md.
Springs and cogging have corners, at which SciPy loses its order: its steps are short for them. What
is left is its own error; it was 4e-8 with steps of twice the length.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from torsio import PlantParams

Array = npt.NDArray[np.float64]
PERIOD_S = 1e-3
MOTOR_LAG_S, BRAKE_LAG_S = 44e-6, 60e-3


@dataclass
class Rows:
    """Plants' rows by themselves: shafts in a row, friction on the first and the last one.

    Attributes
    ----------
    hand_nm
        Torque of the hand on the knob by time (s), angle and speed; its inertia is `hand_kg_m2`.
    max_step_s
        Of SciPy; short for the corners of springs and cogging.
    """

    params: PlantParams
    hand_nm: Callable[[float, float, float], float] = lambda *_: 0.0
    hand_kg_m2: float = 0.0
    max_step_s: float = 2.5e-5
    time_s: float = 0.0

    def __post_init__(self) -> None:
        p = self.params
        if not p.spring_and_brake:
            self.inertia = [p.knob_inertia_kg_m2 + p.brake_inertia_kg_m2]
            self.viscous = [p.knob_viscous_nm_s_per_rad + p.brake_viscous_nm_s_per_rad]
        elif p.belt is None:
            self.inertia = [p.knob_inertia_kg_m2, p.brake_inertia_kg_m2]
            self.viscous = [p.knob_viscous_nm_s_per_rad, p.brake_viscous_nm_s_per_rad]
        else:
            before = p.belt.pulley_inertia_kg_m2
            self.inertia = [p.knob_inertia_kg_m2, before, p.brake_inertia_kg_m2 - before]
            self.viscous = [p.knob_viscous_nm_s_per_rad, 0.0, p.brake_viscous_nm_s_per_rad]
        self.inertia[0] += self.hand_kg_m2
        self.shafts = len(self.inertia)
        self.rubbing = [0] if self.shafts == 1 else [0, self.shafts - 1]
        self.state = np.zeros(2 * self.shafts + 2)  # angles, speeds, motor, coil
        self.slips = [0] * len(self.rubbing)
        self.held_nm = 0.0  # by the brake at the last change of its command

    def spring_nm(self, twist: float) -> float:
        stiffness, hard = self.params.shaft_stiffness_nm_per_rad, self.params.shaft_hardening
        if hard is None or abs(twist) <= hard.knee_rad:
            return stiffness * twist
        beyond = hard.stiffness_factor * (abs(twist) - hard.knee_rad)
        return math.copysign(stiffness * (hard.knee_rad + beyond), twist)

    def cogging_nm(self, angle: float) -> float:
        cogging = self.params.cogging
        if cogging is None:
            return 0.0
        table = tuple(cogging.torque_nm)
        corners = len(table)
        along = angle / (2 * math.pi / cogging.periods_per_rev) * corners
        corner, rest = math.floor(along), along - math.floor(along)
        here, there = (table[(corner + i) % corners] for i in (0, 1))
        return here * (1 - rest) + there * rest

    def torques(self, time_s: float, y: Array) -> list[float]:
        """On each shaft, Coulomb friction apart."""
        p, n = self.params, self.shafts
        angle, speed = y[:n], y[n : 2 * n]
        torque = [-b * w for b, w in zip(self.viscous, speed, strict=True)]
        torque[0] += y[2 * n] + self.cogging_nm(angle[0])
        torque[0] += self.hand_nm(time_s, angle[0], speed[0])
        if n > 1:
            twisting = self.spring_nm(angle[0] - angle[1])
            twisting += p.shaft_damping_nm_s_per_rad * (speed[0] - speed[1])
            torque[0] -= twisting
            torque[1] += twisting
        if n > 2 and p.belt is not None:
            twisting = p.belt.stiffness_nm_per_rad * (angle[1] - angle[2])
            twisting += p.belt.damping_nm_s_per_rad * (speed[1] - speed[2])
            torque[1] -= twisting
            torque[2] += twisting
        return torque

    def frictions(self, y: Array) -> list[float]:
        p = self.params
        if self.shafts == 1:
            return [p.knob_coulomb_nm + p.brake_drag_nm]
        return [p.knob_coulomb_nm, self.play(float(y[-1])) + p.brake_drag_nm]

    def advance(self, motor_nm: float, brake_nm: float) -> None:
        n, end_s = self.shafts, self.time_s + PERIOD_S
        self.held_nm = self.play(float(self.state[-1]))
        while self.time_s < end_s - 1e-15:
            self.let_go()
            slips = tuple(self.slips)

            def rates(time_s: float, y: Array, slips: tuple[int, ...] = slips) -> Array:
                torque, friction = self.torques(time_s, y), self.frictions(y)
                rate = np.empty_like(y)
                rate[:n] = y[n : 2 * n]
                rate[n : 2 * n] = np.asarray(torque) / self.inertia
                for slip, limit, shaft in zip(slips, friction, self.rubbing, strict=True):
                    net = (torque[shaft] - slip * limit) / self.inertia[shaft]
                    rate[n + shaft] = net if slip else 0.0
                rate[2 * n] = (motor_nm - y[2 * n]) / MOTOR_LAG_S
                rate[2 * n + 1] = (brake_nm - y[2 * n + 1]) / BRAKE_LAG_S
                return rate

            watched = [self.room(i, slip) for i, slip in enumerate(slips)]
            step: Any = solve_ivp(
                rates,
                (self.time_s, end_s),
                self.state,
                method="DOP853",
                rtol=1e-11,
                atol=1e-14,
                max_step=self.max_step_s,
                first_step=min(1e-6, end_s - self.time_s),
                events=watched,
            )
            self.state, self.time_s = step.y[:, -1].copy(), float(step.t[-1])
            for i, shaft in enumerate(self.rubbing):
                if not step.t_events[i].size:
                    continue
                if slips[i]:
                    self.slips[i] = 0
                    self.state[n + shaft] = 0.0
                else:
                    torque = self.torques(self.time_s, self.state)
                    self.slips[i] = 1 if torque[shaft] > 0 else -1
        self.time_s = end_s

    def let_go(self) -> None:
        torque, friction = self.torques(self.time_s, self.state), self.frictions(self.state)
        for i, shaft in enumerate(self.rubbing):
            if self.slips[i] == 0 and abs(torque[shaft]) > friction[i] * (1 + 1e-12):
                self.slips[i] = 1 if torque[shaft] > 0 else -1

    def play(self, coil_nm: float) -> float:
        """Give what the brake holds; its current goes one way between changes of the command."""
        if self.params.brake_hysteresis is None:
            return coil_nm
        half = self.params.brake_hysteresis.half_width_nm
        return min(max(self.held_nm, coil_nm - half), coil_nm + half)

    def room(self, i: int, slip: int) -> Callable[[float, Array], float]:
        """Give what is left until friction catches or lets go, for SciPy's events."""
        shaft = self.rubbing[i]

        def left(time_s: float, y: Array) -> float:
            if slip:
                return float(slip * y[self.shafts + shaft])
            return float(self.frictions(y)[i] - abs(self.torques(time_s, y)[shaft]))

        left.terminal, left.direction = True, -1  # type: ignore[attr-defined]
        return left

    def seen(self) -> tuple[float, float]:
        """Give the knob's angle and the shaft's torque on it."""
        n, y = self.shafts, self.state
        if n == 1:
            return float(y[0]), 0.0
        twisting = self.spring_nm(y[0] - y[1])
        twisting += self.params.shaft_damping_nm_s_per_rad * (y[n] - y[n + 1])
        return float(y[0]), -float(twisting)
