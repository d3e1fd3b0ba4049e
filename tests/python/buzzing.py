"""Knobs thrown or pushed into springs on the boards' own current loops, and whether they rest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from torsio import BoardConfig, ControlConfig, Electrics, ImpedanceHand, NoHand, Spring, Wall
from torsio.closed_loop import InitialState, LoopOptions, simulate
from torsio.perception import vibration_nm
from torsio.printed.hands import Hand
from torsio.printed.plant import PlantParams

__all__ = ["BOARDS", "HANDS", "REST_COUNTS", "SPEEDS_RAD_S", "Trial", "motion"]

BOARDS: Final = {
    # Current loop, control rate, and by how much the board takes its motor to trail.
    "pico2": (Electrics(), 20e3, PlantParams().motor_time_constant_s),
    "pico": (
        Electrics(predictive=False, current_period_s=0.0, output_delay_s=100e-6), 10e3, 0.16e-3,
    ),
}  # fmt: skip
SPEEDS_RAD_S: Final = (0.5, 2.0, 5.0, 10.0, 18.0)
HandName = Literal["off", "stiff", "soft"]
HANDS: Final[tuple[HandName, ...]] = ("off", "stiff", "soft")
REST_COUNTS: Final = 2
"""An encoder at rest may flicker between so many."""
_WAY_RAD, _PUSH_NM = 0.02, 0.04
_AFTER_S, _SILENT_S, _WATCHED_S = 0.7, (0.3, 0.7), 0.2


@dataclass(frozen=True)
class Trial:
    """A knob, a spring, and how they meet.

    `resistance` and `inductance` are of the true winding over what the board takes them for.
    """

    board: str
    stiffness_nm_per_rad: float
    speed_rad_s: float
    hand: HandName = "off"
    two_sided: bool = False
    delay_ticks: int = 0
    counts: int = 32768
    law: Literal["calibrated", "compensated"] = "calibrated"
    resistance: float = 1.0
    inductance: float = 1.0

    def hand_and_contact(self) -> tuple[Hand, float]:
        """Give who holds it, and when it is at the surface or, pushed, at its depth."""
        if self.hand == "off":
            return NoHand(), _WAY_RAD / self.speed_rad_s
        stiff = self.hand == "stiff"
        stiffness = 30.0 if stiff else 0.7
        depth_rad = _WAY_RAD + _PUSH_NM / stiffness
        arrival_s = depth_rad / self.speed_rad_s
        hand = ImpedanceHand(
            stiffness_nm_per_rad=stiffness,
            damping_nm_s_per_rad=0.1 if stiff else 0.005,
            inertia_kg_m2=5e-5 if stiff else 1e-5,
            intended_angle_rad=[(0.0, 0.0), (arrival_s, depth_rad)],
        )
        return hand, arrival_s

    def options(self, hand: Hand) -> LoopOptions:
        electrics, rate_hz, lag_s = BOARDS[self.board]
        true = replace(
            electrics,
            winding_resistance_ohm=self.resistance * electrics.winding_resistance_ohm,
            winding_inductance_h=self.inductance * electrics.winding_inductance_h,
        )
        stiffness = self.stiffness_nm_per_rad
        return LoopOptions(
            scene=Spring(angle_rad=_WAY_RAD, stiffness_nm_per_rad=stiffness, torque_limit_nm=1.0)
            if self.two_sided
            else Wall(angle_rad=_WAY_RAD, stiffness_nm_per_rad=stiffness),
            hand=hand,
            plant=PlantParams(
                counts_per_rev=self.counts, electrics=true, motor_time_constant_s=lag_s
            ),
            board=BoardConfig(),
            control=ControlConfig(law=self.law),
            control_period_ns=round(1e9 / rate_hz),
            delay_ticks=self.delay_ticks,
            initial=InitialState(speed_rad_s=self.speed_rad_s if self.hand == "off" else 0.0),
        )


def _turns(counts: npt.NDArray[np.int64]) -> int:
    """Count how often it turns round by more than an encoder flickers."""
    turns, way, furthest = 0, 0, int(counts[0])
    for place in counts[np.flatnonzero(np.diff(counts)) + 1].tolist():
        if way * (place - furthest) >= 0:
            way, furthest = way or (1 if place > furthest else -1), place
        elif abs(place - furthest) > REST_COUNTS:
            turns, way, furthest = turns + 1, -way, place
    return turns


def motion(trial: Trial) -> tuple[int, int, float]:
    """Tell how the knob moves for 0.2 s from 0.7 s after contact on.

    Returns
    -------
    counts, turns, vibration_nm
        Between which it stays, how often it turns round, and how the motor vibrates 0.3
        or 0.7 s later, whichever is less: a flicker that dies within 0.2 s is not told.
    """
    hand, contact_s = trial.hand_and_contact()
    rest_s = contact_s + _AFTER_S
    options = trial.options(hand)
    rows = simulate(options, duration_s=rest_s + _SILENT_S[-1] + _WATCHED_S)
    since_s = rows["time_s"] - rest_s
    counts = rows["position_counts"][(since_s >= 0.0) & (since_s < _WATCHED_S)]
    late = [(since_s >= begin) & (since_s < begin + _WATCHED_S) for begin in _SILENT_S]
    loud_nm = [
        float(vibration_nm(rows["motor_torque_nm"][window], 1e9 / options.control_period_ns))
        for window in late
    ]
    return int(np.ptp(counts)), _turns(counts), min(loud_nm)
