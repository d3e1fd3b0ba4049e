from typing import Any, Final

import numpy as np
import numpy.typing as npt

from torsio.printed.hands import ImpedanceHand, NoHand, TorqueHand

TRIAL_DTYPE: Final[np.dtype[Any]]
ACTUATORS: Final[tuple[str, ...]]

def actuator_parts() -> dict[str, float]: ...
def run_actuator(
    actuator: str,
    *,
    hand: NoHand | TorqueHand | ImpedanceHand,
    duration_ns: int,
    parts: dict[str, float] = ...,
    stiffness_nm_per_rad: float = 0.0,
    angle_rad: float = 0.0,
    both_ways: bool = False,
    initial_speed_rad_s: float = 0.0,
    counts_per_rev: int = ...,
    period_ns: int = ...,
    step_ns: int = ...,
) -> npt.NDArray[np.void]: ...
def drive_foreign(
    *,
    step: int,
    model: int,
    data: int,
    torque: int,
    friction: int,
    angles: int,
    torque_nm: npt.ArrayLike,
    friction_nm: npt.ArrayLike,
    steps_per_row: int,
) -> npt.NDArray[np.float64]: ...
def stepper(name: str) -> object: ...
def replay_wide(
    reports: list[bytes],
    *,
    control_period_ns: int,
    first_tick: int,
    counts: npt.NDArray[np.uint32],
) -> npt.NDArray[np.uint8]: ...
