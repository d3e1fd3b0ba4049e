from collections.abc import Callable
from typing import Any, Final, Literal

import numpy as np
import numpy.typing as npt

from torsio.closed_loop import InitialState, LoopOptions
from torsio.config import PlantParams
from torsio.hands import Hand
from torsio.hands import Profile as _Knots

PLANT_DTYPE: Final[np.dtype[Any]]

_Method = Literal["exact", "trapezoid", "semi_implicit", "regularised"]

def usb_report_descriptor(interface: int) -> bytes: ...

class Plant:
    def __init__(
        self,
        params: PlantParams | None = None,
        hand: Hand | None = None,
        *,
        method: _Method | None = None,
        step_ns: int | None = None,
        tolerance: float | None = None,
        regularisation_rad_s: float | None = None,
    ) -> None: ...
    def set_command(
        self, *, motor_torque_nm: float = 0.0, brake_torque_nm: float = 0.0
    ) -> None: ...
    def set_hand(self, hand: Hand) -> None: ...
    def advance(self, duration_ns: int) -> None: ...
    @property
    def time_ns(self) -> int: ...
    @property
    def state(self) -> dict[str, Any]: ...
    def record(
        self,
        motor_torque_nm: npt.ArrayLike,
        brake_torque_nm: npt.ArrayLike,
        *,
        period_ns: int = 1_000_000,
    ) -> npt.NDArray[np.void]: ...
    def drive(
        self,
        motor_torque_nm: npt.ArrayLike,
        brake_torque_nm: npt.ArrayLike,
        *,
        period_ns: int = 1_000_000,
    ) -> npt.NDArray[np.float64]: ...
    def set_state(self, state: InitialState) -> None: ...
    def restart(self) -> None: ...
    @property
    def fidelity(self) -> dict[str, Any]: ...

class Profile:
    def __init__(self, knots: _Knots) -> None: ...
    def value(self, time_ns: int) -> float: ...
    def slope_per_s(self, time_ns: int) -> float: ...

class Encoder:
    def __init__(
        self,
        *,
        counts_per_rev: int = 8192,
        rounding: Literal["floor", "nearest"] = "floor",
        direction: int = 1,
        phase_counts: float = 0.0,
        noise_counts: float = 0.0,
        seed: int = 0,
    ) -> None: ...
    def sample(self, angle_rad: float) -> int: ...
    def sample_record(self, angle_rad: npt.ArrayLike) -> npt.NDArray[np.uint32]: ...

class EmulatedDevice:
    def __init__(
        self,
        *,
        seed: int = 0,
        control_period_ns: int = 1_000_000,
        plant: PlantParams | None = None,
        hand: Hand | None = None,
        serial: str = "EMULATED",
    ) -> None: ...
    def advance(self, duration_ns: int) -> None: ...
    @property
    def time_ns(self) -> int: ...
    @property
    def connected(self) -> bool: ...
    @property
    def plant_state(self) -> dict[str, Any]: ...
    def write(self, report: bytes) -> bool: ...
    def read(self) -> bytes | None: ...
    def set_feature(self, report: bytes) -> tuple[int, int]: ...
    def get_feature(self, report_id: int) -> bytes | None: ...
    def set_hand(self, hand: Hand) -> None: ...
    def set_plugged(self, plugged: bool) -> None: ...
    def set_powered(self, powered: bool) -> None: ...
    def set_emergency_stop(self, pressed: bool) -> None: ...

LOOP_DTYPE: Final[np.dtype[Any]]

class ClosedLoop:
    def __init__(self, options: LoopOptions) -> None: ...
    def run(self, ticks: int, every: int) -> npt.NDArray[np.void]: ...
    def hold_command(self, motor_torque_nm: float, brake_torque_nm: float) -> None: ...
    def release_command(self) -> None: ...
    def set_hand(self, hand: Hand) -> None: ...
    @property
    def fidelity(self) -> dict[str, Any]: ...

def simulate_many(
    options: list[LoopOptions],
    ticks: list[int],
    every: int,
    threads: int,
    on_progress: Callable[[int], None] | None,
) -> list[npt.NDArray[np.void]]: ...
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

REPLAY_DTYPE: Final[np.dtype[Any]]

def replay(
    options: LoopOptions, counts: npt.NDArray[np.uint32], wide: bool
) -> npt.NDArray[np.void]: ...

TRIAL_DTYPE: Final[np.dtype[Any]]
ACTUATORS: Final[tuple[str, ...]]

def actuator_parts() -> dict[str, float]: ...
def run_actuator(
    actuator: str,
    *,
    hand: Hand,
    duration_ns: int,
    parts: dict[str, float] = ...,
    stiffness_nm_per_rad: float = 0.0,
    angle_rad: float = 0.0,
    both_ways: bool = False,
    initial_speed_rad_s: float = 0.0,
    counts_per_rev: int = 8192,
    period_ns: int = 1_000_000,
    step_ns: int = 20_000,
) -> npt.NDArray[np.void]: ...
