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

from torsio import _torsio, core, emulator, protocol, scenes, telemetry
from torsio.angles import deg
from torsio.config import (
    ActuatorConfig,
    BoardConfig,
    CalibrationConfig,
    ControlConfig,
    GameConfig,
    ShaftConfig,
)
from torsio.config_file import dump_config, load_config
from torsio.emulated_knob import Emulator
from torsio.emulator_options import DeviceInput, EmulatorOptions, LinkFaults
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
from torsio.firmware import (
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
from torsio.game_port import GamePort
from torsio.hands import FeedbackHand, Hand, ImpedanceHand, NoHand, PrescribedMotion, TorqueHand
from torsio.hotplug import DeviceEvent, DeviceWatch, watch
from torsio.knob import Knob
from torsio.notebook import Telemetry
from torsio.opening import list_devices, open
from torsio.plant import (
    Belt,
    BrakeHysteresis,
    Cogging,
    Electrics,
    ElectricsState,
    PlantParams,
    ShaftHardening,
)
from torsio.recording import Recorded, RecordingFile, load
from torsio.replaying import Replayed, replay
from torsio.scenes import *  # noqa: F403  # every effect
from torsio.steps import Step, Steps
from torsio.telemetry import TELEMETRY_DTYPE, TRUTH_DTYPE
from torsio.told import (
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
from torsio.trading import Trade, trade
from torsio.transport import Transport

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
