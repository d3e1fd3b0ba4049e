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

from torsio import _torsio, emulator, errors, protocol, telemetry
from torsio.common.angles import deg
from torsio.common.notebook import Telemetry
from torsio.errors import *  # noqa: F403
from torsio.knob import Knob
from torsio.knob.config_file import dump_config, load_config
from torsio.knob.emulated import Emulator
from torsio.knob.firmware import (
    carry_out,
    prepare_update,
    read_firmware,
    start_bootloader,
    update_firmware,
)
from torsio.knob.hotplug import DeviceEvent, DeviceWatch, watch
from torsio.knob.opening import list_devices, open
from torsio.knob.transport import Transport
from torsio.printed import config, scenes
from torsio.printed.config import *  # noqa: F403
from torsio.printed.emulator_options import EmulatorOptions, LinkFaults
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
    PlantParams,
    ShaftHardening,
)
from torsio.printed.scenes import *  # noqa: F403
from torsio.printed.told import Event, ListedDevice
from torsio.recordings.file import RecordingFile
from torsio.recordings.loading import Recorded, load
from torsio.recordings.replaying import replay
from torsio.studio import live
from torsio.telemetry import TELEMETRY_DTYPE
from torsio.trading import trade

__version__ = _torsio.__version__

# A knob, and finding one. Type checkers read no list within a list.
__all__ = [
    "DeviceEvent",
    "DeviceWatch",
    "Event",
    "Knob",
    "ListedDevice",
    "Transport",
    "list_devices",
    "open",
    "watch",
]
# Scenes.
__all__ += scenes.__all__
__all__ += ["deg", "trade"]
# Configurations.
__all__ += config.__all__
__all__ += ["dump_config", "load_config"]
# Telemetry and recordings.
__all__ += ["TELEMETRY_DTYPE", "Recorded", "RecordingFile", "Telemetry", "live", "load", "replay"]
# An emulated knob and its hand.
__all__ += [
    "Belt",
    "BrakeHysteresis",
    "Cogging",
    "Electrics",
    "Emulator",
    "EmulatorOptions",
    "FeedbackHand",
    "Hand",
    "ImpedanceHand",
    "LinkFaults",
    "NoHand",
    "PlantParams",
    "PrescribedMotion",
    "ShaftHardening",
    "TorqueHand",
]
# New firmware.
__all__ += [
    "carry_out",
    "prepare_update",
    "read_firmware",
    "start_bootloader",
    "update_firmware",
]
# Errors and warnings.
__all__ += errors.__all__
# Modules that are there without an import of their own.
__all__ += ["__version__", "emulator", "protocol", "telemetry"]
