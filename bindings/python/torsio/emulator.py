"""The emulated device and its parts, each on its own, for study.

`torsio.open("emulated")` puts them together; here are the plant, hands' profiles, the encoder, and
the whole device at the level of report bytes.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt

from torsio import _torsio, checks
from torsio._torsio.emulator import PLANT_DTYPE, EmulatedDevice, Encoder, Profile
from torsio.closed_loop import (
    LOOP_DTYPE,
    REPLAY_DTYPE,
    ClosedLoop,
    InitialState,
    LoopOptions,
    SpinUp,
    replay,
    simulate,
    simulate_many,
)
from torsio.config import PlantParams, check_plant
from torsio.hands import Hand
from torsio.telemetry import Record

__all__ = [
    "LOOP_DTYPE",
    "PLANT_DTYPE",
    "REPLAY_DTYPE",
    "ClosedLoop",
    "EmulatedDevice",
    "Encoder",
    "InitialState",
    "LoopOptions",
    "Plant",
    "Profile",
    "SpinUp",
    "replay",
    "simulate",
    "simulate_many",
]

_LONGEST_NS = 2**62


class Plant(_torsio.emulator.Plant):
    """Motor, knob, shaft spring, brake and hand under a virtual clock.

    Parameters
    ----------
    method, step_ns
        How it is stepped: "exact", "trapezoid", "semi_implicit" or "regularised"; 1 ms.
    tolerance
        Relative error that is good enough, at least 1e-9, whatever `method` says; see `fidelity`.
    regularisation_rad_s
        Speed over which "regularised" smooths friction, > 0.

    Raises
    ------
    TypeError, ValueError
        If an argument is of the wrong kind or out of its range; the message names it.
    """

    def __init__(
        self,
        params: PlantParams | None = None,
        hand: Hand | None = None,
        *,
        method: Literal["exact", "trapezoid", "semi_implicit", "regularised"] | None = None,
        step_ns: int | None = None,
        tolerance: float | None = None,
        regularisation_rad_s: float | None = None,
    ) -> None:
        """Put it at rest at angle 0."""
        if params is not None:
            check_plant("params", params)
        if method is not None:
            checks.text("method", method)
        if step_ns is not None:
            step_ns = checks.whole("step_ns", step_ns, 1, _LONGEST_NS)
        if tolerance is not None:
            tolerance = checks.number("tolerance", tolerance)
        if regularisation_rad_s is not None:
            regularisation_rad_s = checks.positive("regularisation_rad_s", regularisation_rad_s)
        super().__init__(
            params,
            hand,
            method=method,
            step_ns=step_ns,
            tolerance=tolerance,
            regularisation_rad_s=regularisation_rad_s,
        )

    def set_command(self, *, motor_torque_nm: float = 0.0, brake_torque_nm: float = 0.0) -> None:
        """Set what is held from now on."""
        super().set_command(
            motor_torque_nm=checks.finite("motor_torque_nm", motor_torque_nm),
            brake_torque_nm=checks.finite("brake_torque_nm", brake_torque_nm),
        )

    def advance(self, duration_ns: int) -> None:
        """Let time pass."""
        super().advance(checks.whole("duration_ns", duration_ns, 0, _LONGEST_NS))

    def record(
        self,
        motor_torque_nm: npt.ArrayLike,
        brake_torque_nm: npt.ArrayLike,
        *,
        period_ns: int = 1_000_000,
    ) -> Record:
        """Hold each pair of commands for a period; PLANT_DTYPE rows at the periods' begins."""
        period_ns = checks.whole("period_ns", period_ns, 1, _LONGEST_NS)
        return super().record(motor_torque_nm, brake_torque_nm, period_ns=period_ns)

    def drive(
        self,
        motor_torque_nm: npt.ArrayLike,
        brake_torque_nm: npt.ArrayLike,
        *,
        period_ns: int = 1_000_000,
    ) -> npt.NDArray[np.float64]:
        """As record, for timing: angles of knob and brake at the periods' ends, shape (n, 2)."""
        period_ns = checks.whole("period_ns", period_ns, 1, _LONGEST_NS)
        return super().drive(motor_torque_nm, brake_torque_nm, period_ns=period_ns)
