"""Torsio: a USB knob that pushes back.

>>> import torsio
>>> hand = torsio.TorqueHand(torque_nm=[(0.0, 0.0), (0.8, 0.05)])
>>> with torsio.open("emulated", emulator=torsio.EmulatorOptions(hand=hand)) as knob:
...     knob.play(torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.4))
...     knob.arm()
...     log = knob.record(1.0)
>>> bool(log["desired_torque_nm"].min() < -0.04)
True
"""

from __future__ import annotations

from torsio import _torsio, core, emulator, protocol, telemetry
from torsio.common.angles import deg
from torsio.common.notebook import Telemetry
from torsio.errors import (
    Closed,
    DeviceBusy,
    DeviceNotFound,
    Disarmed,
    DisarmedWarning,
    Disconnected,
    Error,
    HeldLowWarning,
    InvalidArgument,
    MalformedReport,
    NoSpeedLimitWarning,
    PermissionDenied,
    ProtocolMismatch,
    Refused,
    SceneWarning,
    StiffnessWarning,
    Timeout,
)
from torsio.knob import Knob
from torsio.knob.config_file import dump_config, load_config
from torsio.knob.emulated import Emulator
from torsio.knob.firmware import (
    ExaminedKnob,
    FirmwareFile,
    FirmwareHost,
    FirmwarePlan,
    FirmwareUpdate,
    carry_out,
    prepare_update,
    read_firmware,
    start_bootloader,
    update_firmware,
)
from torsio.knob.game_port import GamePort
from torsio.knob.hotplug import DeviceEvent, DeviceWatch, watch
from torsio.knob.opening import list_devices, open
from torsio.knob.steps import Step, Steps
from torsio.knob.transport import Transport
from torsio.printed import scenes
from torsio.printed.config import (
    ActuatorConfig,
    BoardConfig,
    CalibrationConfig,
    ControlConfig,
    GameConfig,
    ShaftConfig,
)
from torsio.printed.emulator_options import DeviceInput, EmulatorOptions, LinkFaults
from torsio.printed.hands import (
    FeedbackHand,
    Hand,
    ImpedanceHand,
    NoHand,
    PrescribedMotion,
    TorqueHand,
)
from torsio.printed.plant import (
    Belt,
    BrakeHysteresis,
    Cogging,
    Electrics,
    ElectricsState,
    PlantParams,
    ShaftHardening,
)
from torsio.printed.scenes import *  # noqa: F403  # every effect
from torsio.printed.told import (
    Clock,
    DeviceInfo,
    Disarm,
    Energies,
    Event,
    GameEffect,
    GameStatus,
    Health,
    Limits,
    LinkStatistics,
    ListedDevice,
    MotorCurrent,
    StableStiffness,
)
from torsio.recordings.loading import Recorded, RecordingFile, load
from torsio.recordings.replaying import Replayed, replay
from torsio.studio import watch as live
from torsio.telemetry import TELEMETRY_DTYPE, TRUTH_DTYPE
from torsio.trading import Trade, trade

__version__ = _torsio.__version__

__all__ = [
    "TELEMETRY_DTYPE",
    "TRUTH_DTYPE",
    "ActuatorConfig",
    "Belt",
    "BoardConfig",
    "BrakeHysteresis",
    "CalibrationConfig",
    "Clock",
    "Closed",
    "Cogging",
    "ControlConfig",
    "DeviceBusy",
    "DeviceEvent",
    "DeviceInfo",
    "DeviceInput",
    "DeviceNotFound",
    "DeviceWatch",
    "Disarm",
    "Disarmed",
    "DisarmedWarning",
    "Disconnected",
    "Electrics",
    "ElectricsState",
    "Emulator",
    "EmulatorOptions",
    "Energies",
    "Error",
    "Event",
    "ExaminedKnob",
    "FeedbackHand",
    "FirmwareFile",
    "FirmwareHost",
    "FirmwarePlan",
    "FirmwareUpdate",
    "GameConfig",
    "GameEffect",
    "GamePort",
    "GameStatus",
    "Hand",
    "Health",
    "HeldLowWarning",
    "ImpedanceHand",
    "InvalidArgument",
    "Knob",
    "Limits",
    "LinkFaults",
    "LinkStatistics",
    "ListedDevice",
    "MalformedReport",
    "MotorCurrent",
    "NoSpeedLimitWarning",
    "NoHand",
    "PermissionDenied",
    "PlantParams",
    "PrescribedMotion",
    "ProtocolMismatch",
    "Recorded",
    "RecordingFile",
    "Refused",
    "Replayed",
    "SceneWarning",
    "ShaftHardening",
    "StableStiffness",
    "ShaftConfig",
    "Step",
    "Steps",
    "StiffnessWarning",
    "Telemetry",
    "Timeout",
    "TorqueHand",
    "Trade",
    "Transport",
    "__version__",
    "carry_out",
    "core",
    "deg",
    "dump_config",
    "emulator",
    "list_devices",
    "live",
    "load",
    "load_config",
    "open",
    "prepare_update",
    "protocol",
    "read_firmware",
    "replay",
    "start_bootloader",
    "telemetry",
    "trade",
    "update_firmware",
    "watch",
    *scenes.__all__,
]
