from collections.abc import Iterable
from typing import Any, overload

import numpy as np
import numpy.typing as npt

_Floats = npt.NDArray[np.float32]
_Numbers = npt.NDArray[np.number[Any]]
_Law = str

class MotionParams:
    def __init__(
        self,
        *,
        counts_per_rev: int = ...,
        period_ns: int = ...,
        counter_bits: int = ...,
        reversed: bool = False,
        speed_bandwidth_hz: float = ...,
    ) -> None: ...

class MotionState:
    position_counts: int
    def __init__(self) -> None: ...

class Motion:
    @property
    def position_counts(self) -> int: ...
    @property
    def delta_counts(self) -> int: ...
    @property
    def delta_rad(self) -> float: ...
    @property
    def speed_rad_s(self) -> float: ...
    @property
    def acceleration_rad_s2(self) -> float: ...

@overload
def track_motion(state: MotionState, params: MotionParams, encoder_count: int) -> Motion: ...
@overload
def track_motion(
    state: MotionState, params: MotionParams, encoder_count: _Numbers
) -> npt.NDArray[np.void]: ...

class BrakeParams:
    def __init__(
        self,
        *,
        time_constant_s: float = ...,
        period_s: float = ...,
        floor_nm: float = ...,
        drag_nm: float = 0.0,
    ) -> None: ...
    @property
    def decay(self) -> float: ...
    @property
    def floor_nm(self) -> float: ...
    @property
    def drag_nm(self) -> float: ...

class BrakeState:
    capacity_nm: float
    def __init__(self, *, capacity_nm: float = 0.0) -> None: ...

@overload
def model_brake(state: BrakeState, params: BrakeParams, held_command_nm: float) -> float: ...
@overload
def model_brake(state: BrakeState, params: BrakeParams, held_command_nm: _Numbers) -> _Floats: ...

class SoftSensorState:
    spring_torque_nm: float
    def __init__(self, *, spring_torque_nm: float = 0.0) -> None: ...

@overload
def sense_spring(
    state: SoftSensorState,
    delta_rad: float,
    capacity_nm: float,
    *,
    stiffness_nm_per_rad: float = ...,
) -> float: ...
@overload
def sense_spring(
    state: SoftSensorState,
    delta_rad: _Numbers,
    capacity_nm: _Numbers | float,
    *,
    stiffness_nm_per_rad: float = ...,
) -> _Floats: ...

class PartitionParams:
    def __init__(
        self,
        *,
        law: _Law = ...,
        beta: float = ...,
        motor_torque_max_nm: float = ...,
        brake_torque_max_nm: float = ...,
    ) -> None: ...
    @property
    def law(self) -> _Law: ...
    @property
    def brakes(self) -> bool: ...
    @property
    def bounds(self) -> bool: ...
    @property
    def beta(self) -> float: ...
    @property
    def motor_torque_max_nm(self) -> float: ...
    @property
    def brake_torque_max_nm(self) -> float: ...

class Shares:
    @property
    def motor_command_nm(self) -> float: ...
    @property
    def brake_command_nm(self) -> float: ...
    @property
    def motor_saturated(self) -> bool: ...
    @property
    def brake_saturated(self) -> bool: ...

@overload
def partition(params: PartitionParams, desired_nm: float, spring_nm: float) -> Shares: ...
@overload
def partition(
    params: PartitionParams, desired_nm: _Numbers, spring_nm: _Numbers | float
) -> npt.NDArray[np.void]: ...

class Scene:
    def __init__(
        self,
        reports: Iterable[bytes],
        *,
        counts_per_rev: int = ...,
        period_ns: int = ...,
    ) -> None: ...
    @property
    def active(self) -> int: ...

class SceneState:
    def __init__(self) -> None: ...

def evaluate_scene(scene: Scene, state: SceneState, motion: Motion, tick: int) -> float: ...
def evaluate_scene_record(
    scene: Scene,
    state: SceneState,
    motion_params: MotionParams,
    motion_state: MotionState,
    encoder_count: npt.ArrayLike,
    *,
    first_tick: int = 0,
) -> _Floats: ...
