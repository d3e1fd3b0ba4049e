"""Parts of the plant against an integration of their own equations by SciPy.

Nothing is shared with the emulator: absolute angles in place of twists, DOP853 in place of matrix
exponentials, friction as modes that events change, the equations from docs/emulator.md. Springs
and cogging have corners, at which SciPy loses its order: its steps are short for them. What
is left of 3e-10 is its own error; it was 1e-8 with steps of twice the length.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import solve_ivp

from torsio import Belt, BrakeHysteresis, Cogging, PlantParams, ShaftHardening
from torsio.emulator import Plant

Array = npt.NDArray[np.float64]
PERIOD_S = 1e-3
MOTOR_LAG_S, BRAKE_LAG_S = 0.1e-3, 60e-3


@dataclass
class Rows:
    """Plants' rows by themselves: shafts in a row, friction on the first and the last one."""

    params: PlantParams

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
        self.shafts = len(self.inertia)
        self.rubbing = [0] if self.shafts == 1 else [0, self.shafts - 1]
        self.state = np.zeros(2 * self.shafts + 2)  # angles, speeds, motor, brake
        self.slips = [0] * len(self.rubbing)
        self.target_nm = 0.0

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
        corners = len(cogging.torque_nm)
        along = angle / (2 * math.pi / cogging.periods_per_rev) * corners
        corner, rest = math.floor(along), along - math.floor(along)
        here, there = (cogging.torque_nm[(corner + i) % corners] for i in (0, 1))
        return here * (1 - rest) + there * rest

    def torques(self, y: Array) -> list[float]:
        """On each shaft, Coulomb friction apart."""
        p, n = self.params, self.shafts
        angle, speed = y[:n], y[n : 2 * n]
        torque = [-b * w for b, w in zip(self.viscous, speed, strict=True)]
        torque[0] += y[2 * n] + self.cogging_nm(angle[0])
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
        return [p.knob_coulomb_nm, float(y[-1]) + p.brake_drag_nm]

    def advance(self, motor_nm: float, brake_nm: float) -> None:
        n, time_s = self.shafts, 0.0
        self.target_nm = brake_nm if self.params.brake_hysteresis is None else self.play(brake_nm)
        while time_s < PERIOD_S - 1e-16:
            self.let_go()
            slips = tuple(self.slips)

            def rates(_: float, y: Array, slips: tuple[int, ...] = slips) -> Array:
                torque, friction = self.torques(y), self.frictions(y)
                rate = np.empty_like(y)
                rate[:n] = y[n : 2 * n]
                rate[n : 2 * n] = np.asarray(torque) / self.inertia
                for slip, limit, shaft in zip(slips, friction, self.rubbing, strict=True):
                    net = (torque[shaft] - slip * limit) / self.inertia[shaft]
                    rate[n + shaft] = net if slip else 0.0
                rate[2 * n] = (motor_nm - y[2 * n]) / MOTOR_LAG_S
                rate[2 * n + 1] = (self.target_nm - y[2 * n + 1]) / BRAKE_LAG_S
                return rate

            watched = [self.room(i, slip) for i, slip in enumerate(slips)]
            step: Any = solve_ivp(
                rates,
                (time_s, PERIOD_S),
                self.state,
                method="DOP853",
                rtol=1e-11,
                atol=1e-14,
                max_step=5e-5,
                first_step=min(1e-6, PERIOD_S - time_s),
                events=watched,
            )
            self.state, time_s = step.y[:, -1].copy(), float(step.t[-1])
            for i, shaft in enumerate(self.rubbing):
                if not step.t_events[i].size:
                    continue
                if slips[i]:
                    self.slips[i] = 0
                    self.state[n + shaft] = 0.0
                else:
                    self.slips[i] = 1 if self.torques(self.state)[shaft] > 0 else -1

    def let_go(self) -> None:
        torque, friction = self.torques(self.state), self.frictions(self.state)
        for i, shaft in enumerate(self.rubbing):
            if self.slips[i] == 0 and abs(torque[shaft]) > friction[i] * (1 + 1e-12):
                self.slips[i] = 1 if torque[shaft] > 0 else -1

    def play(self, brake_nm: float) -> float:
        assert self.params.brake_hysteresis is not None
        half = self.params.brake_hysteresis.half_width_nm
        return max(0.0, min(max(self.target_nm, brake_nm - half), brake_nm + half))

    def room(self, i: int, slip: int) -> Callable[[float, Array], float]:
        """Give what is left until friction catches or lets go, for SciPy's events."""
        shaft = self.rubbing[i]

        def left(_: float, y: Array) -> float:
            if slip:
                return float(slip * y[self.shafts + shaft])
            return float(self.frictions(y)[i] - abs(self.torques(y)[shaft]))

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


HARD = ShaftHardening(knee_rad=0.008, stiffness_factor=2.5)
SOFT = ShaftHardening(knee_rad=0.008, stiffness_factor=0.5)
COGGING = Cogging.sine(periods_per_rev=12, amplitude_nm=3e-3, points=8)
PLANTS = {
    "rigid": PlantParams(spring_and_brake=False),
    "hardening": PlantParams(shaft_hardening=HARD),
    "hysteresis": PlantParams(brake_hysteresis=BrakeHysteresis()),
    "cogging": PlantParams(cogging=COGGING),
    "belt": PlantParams(belt=Belt()),
    "all": PlantParams(
        belt=Belt(), shaft_hardening=SOFT, brake_hysteresis=BrakeHysteresis(), cogging=COGGING
    ),
}


@pytest.mark.parametrize("name", PLANTS)
def test_part_moves_as_its_equations_say(name: str) -> None:
    params, ticks = PLANTS[name], 80
    random = np.random.default_rng(5)
    motor = np.repeat(random.uniform(-0.07, 0.07, ticks // 8), 8)
    brake = np.repeat(random.uniform(0.0, 0.06, ticks // 8), 8)
    plant = Plant(params)
    rows = plant.record(motor, brake)
    got = {
        key: np.append(rows[key][1:], plant.state[key]) for key in ("angle_rad", "spring_torque_nm")
    }
    truth, seen = Rows(params), []
    for command in zip(motor, brake, strict=True):
        truth.advance(*map(float, command))
        seen.append(truth.seen())
    angles, torques = np.asarray(seen).T
    assert np.abs(got["angle_rad"] - angles).max() <= 1e-8 * np.abs(angles).max()
    assert np.abs(got["spring_torque_nm"] - torques).max() <= 1e-8 * np.abs(torques).max()
