"""An independent simulation of the plant, as an oracle for the emulator's.

It is written from the equations alone and shares nothing with the C++ code: SciPy's DOP853 at its
tightest tolerance, absolute angles of both shafts as states, and friction by explicit switching of
modes at located events. It is some 10,000 times slower than the emulator's exact stepper.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Function = Callable[[float], float]


@dataclass(frozen=True, kw_only=True)
class OraclePlant:
    """Parameter set P1; the knob's inertia includes the hand's."""

    knob_inertia_kg_m2: float = 6e-5
    knob_viscous_nm_s_per_rad: float = 2.6e-5
    knob_coulomb_nm: float = 6e-3
    brake_inertia_kg_m2: float = 4e-5
    brake_viscous_nm_s_per_rad: float = 2e-6
    brake_drag_nm: float = 2e-3
    shaft_stiffness_nm_per_rad: float = 2.873
    shaft_damping_nm_s_per_rad: float = 2e-4
    brake_time_constant_s: float = 60e-3
    motor_time_constant_s: float = 44e-6
    back_emf_nm_s_per_rad: float = 0.0
    hand_stiffness_nm_per_rad: float = 0.0
    hand_damping_nm_s_per_rad: float = 0.0


@dataclass
class OracleRun:
    """Simulates one interval after the other; commands are held within each."""

    plant: OraclePlant
    hand_torque_nm: Function = lambda _t: 0.0
    hand_angle_rad: Function = lambda _t: 0.0
    hand_speed_rad_s: Function = lambda _t: 0.0
    #: angle A, angle B, speed A, speed B, motor torque, brake capacity
    y: NDArray[np.float64] = field(default_factory=lambda: np.zeros(6))
    t: float = 0.0
    events: int = 0
    mode: list[int] = field(default_factory=lambda: [0, 0])

    def __post_init__(self) -> None:
        self.mode = [int(np.sign(self.y[2])), int(np.sign(self.y[3]))]

    def demands(self, t: float, y: NDArray[np.float64]) -> tuple[float, float]:
        """Torque on either shaft apart from its Coulomb friction."""
        p = self.plant
        twist, twisting = y[0] - y[1], y[2] - y[3]
        spring = p.shaft_stiffness_nm_per_rad * twist + p.shaft_damping_nm_s_per_rad * twisting
        hand = (
            self.hand_torque_nm(t)
            + p.hand_stiffness_nm_per_rad * (self.hand_angle_rad(t) - y[0])
            + p.hand_damping_nm_s_per_rad * (self.hand_speed_rad_s(t) - y[2])
        )
        knob = hand + y[4] - spring - p.knob_viscous_nm_s_per_rad * y[2]
        return knob, spring - p.brake_viscous_nm_s_per_rad * y[3]

    def capacities(self, y: NDArray[np.float64]) -> tuple[float, float]:
        """Friction's limit on either shaft."""
        return self.plant.knob_coulomb_nm, y[5] + self.plant.brake_drag_nm

    def spring_torque_on_knob_nm(self) -> float:
        p, y = self.plant, self.y
        spring = p.shaft_stiffness_nm_per_rad * (y[0] - y[1])
        return float(-spring - p.shaft_damping_nm_s_per_rad * (y[2] - y[3]))

    def _settle_modes(self) -> None:
        """Shafts at rest slip if the torque on them is more than friction holds."""
        demands, capacities = self.demands(self.t, self.y), self.capacities(self.y)
        for shaft in (0, 1):
            if self.mode[shaft] == 0 and abs(demands[shaft]) > capacities[shaft] * (1 + 1e-13):
                self.mode[shaft] = int(np.sign(demands[shaft]))

    def advance(self, duration_s: float, motor_nm: float, brake_nm: float) -> None:
        """Go on by one interval in which nothing jumps."""
        p = self.plant
        end = self.t + duration_s
        inertia = (p.knob_inertia_kg_m2, p.brake_inertia_kg_m2)
        while self.t < end:
            self._settle_modes()
            mode = tuple(self.mode)

            def rates(
                t: float, y: NDArray[np.float64], mode: tuple[int, ...] = mode
            ) -> list[float]:
                demands, capacities = self.demands(t, y), self.capacities(y)
                accelerations = [
                    (demands[i] - mode[i] * capacities[i]) / inertia[i] if mode[i] else 0.0
                    for i in (0, 1)
                ]
                return [
                    y[2],
                    y[3],
                    *accelerations,
                    (motor_nm - p.back_emf_nm_s_per_rad * y[2] - y[4]) / p.motor_time_constant_s,
                    (brake_nm - y[5]) / p.brake_time_constant_s,
                ]

            functions = []
            for shaft in (0, 1):
                if mode[shaft]:
                    functions.append(_stop_event(shaft, mode[shaft]))
                else:
                    functions.append(_breakaway_event(self, shaft))
            solution = solve_ivp(
                rates,
                (self.t, end),
                self.y,
                method="DOP853",
                rtol=1e-12,
                atol=1e-15,
                first_step=min(1e-6, end - self.t),
                events=functions,
            )
            assert solution.success, solution.message
            self.y = solution.y[:, -1].copy()
            self.t = float(solution.t[-1])
            times = solution.t_events or []
            for shaft in (0, 1):
                if times[shaft].size:
                    self.events += 1
                    if mode[shaft]:
                        self.mode[shaft] = 0
                        self.y[2 + shaft] = 0.0
                    else:
                        demand = self.demands(self.t, self.y)[shaft]
                        self.mode[shaft] = int(np.sign(demand))
        self.t = end


def _stop_event(shaft: int, sign: int) -> Callable[[float, NDArray[np.float64]], float]:
    def stop(_t: float, y: NDArray[np.float64]) -> float:
        return float(sign * y[2 + shaft])

    stop.terminal = True  # type: ignore[attr-defined]
    stop.direction = -1  # type: ignore[attr-defined]
    return stop


def _breakaway_event(run: OracleRun, shaft: int) -> Callable[[float, NDArray[np.float64]], float]:
    def breakaway(t: float, y: NDArray[np.float64]) -> float:
        return float(run.capacities(y)[shaft] - abs(run.demands(t, y)[shaft]))

    breakaway.terminal = True  # type: ignore[attr-defined]
    breakaway.direction = -1  # type: ignore[attr-defined]
    return breakaway
