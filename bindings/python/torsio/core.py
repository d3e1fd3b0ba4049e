"""The device's control mathematics on their own, for study: the very code of the firmware.

Every function works on an explicit state, once per control tick; its ``_record`` twin runs over the
arrays of a whole record and gives the same numbers. All arithmetic is in 32-bit floats, as on the
device. A `Scene` is given as the reports that carry its effects, made with
`torsio.protocol.encode`.
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
    model_brake_record,
    partition,
    partition_record,
    sense_spring,
    sense_spring_record,
    track_motion,
    track_motion_record,
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
    "model_brake_record",
    "partition",
    "partition_record",
    "sense_spring",
    "sense_spring_record",
    "track_motion",
    "track_motion_record",
]
