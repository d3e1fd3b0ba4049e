"""The device's control mathematics on their own, for study: the very code of the firmware.

Every function works on an explicit state, once per control tick. Given arrays it goes through them
tick by tick and returns an array. All arithmetic is in 32-bit floats, as on the device. Defaults
are the reference actuator's, or the emulated device's. A `Scene` is given as the reports that carry
its effects, made with `torsio.protocol.encode`.
"""

from __future__ import annotations

from torsio._torsio.core import (
    BrakeParams,
    BrakeState,
    Motion,
    MotionParams,
    MotionState,
    PartitionParams,
    Scene,
    SceneState,
    Shares,
    SoftSensorState,
    evaluate_scene,
    evaluate_scene_record,
    model_brake,
    partition,
    sense_spring,
    track_motion,
)

__all__ = [
    "BrakeParams",
    "BrakeState",
    "Motion",
    "MotionParams",
    "MotionState",
    "PartitionParams",
    "Scene",
    "SceneState",
    "Shares",
    "SoftSensorState",
    "evaluate_scene",
    "evaluate_scene_record",
    "model_brake",
    "partition",
    "sense_spring",
    "track_motion",
]
