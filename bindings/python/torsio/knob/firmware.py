"""New firmware for a knob: look into a file, put it on the knob, and see that it runs.

>>> import torsio
>>> torsio.update_firmware("torsio-pico2.uf2")  # doctest: +SKIP

A board that waits for firmware is a drive with a file INFO_UF2.TXT. It runs the firmware
that is copied there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, Protocol

from torsio import _torsio
from torsio.common import checks
from torsio.printed.told import DeviceInfo, ListedDevice

__all__ = [
    "ExaminedKnob",
    "FirmwareFile",
    "FirmwareHost",
    "FirmwarePlan",
    "FirmwareUpdate",
    "carry_out",
    "prepare_update",
    "read_firmware",
    "start_bootloader",
    "update_firmware",
]

Say = Callable[[str], object]


@dataclass(frozen=True)
class FirmwareFile:
    """A file with firmware that is whole, and what it says of itself."""

    path: Path
    chip: str
    """"rp2040" or "rp2350"."""
    board: str
    version: str
    """"major.minor.patch"."""
    fingerprint: int
    """Fingerprint of the report layouts, as in `DeviceInfo`."""
    size: int
    """In flash, in bytes."""


@dataclass(frozen=True, repr=False)
class ExaminedKnob(checks.ShortRepr):
    """A knob's answers before and after an update."""

    info: DeviceInfo
    owner: Literal["none", "sdk", "game", "dial"]
    configuration: str
    """As `torsio.dump_config` gives it."""


class FirmwareHost(Protocol):
    """Where an update finds knobs and drives, in a test."""

    root: Path
    """The files of this system."""

    def list_devices(self) -> list[ListedDevice]:
        """List the knobs that are plugged in."""

    def examine(self, path: str) -> ExaminedKnob | None:
        """Ask a knob; None if it is of another release."""

    def start_bootloader(self, path: str) -> None:
        """Have a knob wait for firmware."""


@dataclass(frozen=True, repr=False)
class FirmwarePlan(checks.ShortRepr):
    """Plan of an update: made by `prepare_update`, done by `carry_out`."""

    file: FirmwareFile
    device: ListedDevice | None
    """None: a board that waits in its boot loader already."""
    before: DeviceInfo | None
    """None if it cannot be asked: it is of another release, or waits already."""
    configuration: str
    """As `torsio.dump_config` gives it; empty if it could not be read."""
    _plan: _torsio.FirmwarePlan = field(repr=False, compare=False)

    @property
    def loses_configuration(self) -> bool:
        """The knob is of another release, whose configuration the new firmware cannot read."""
        return self._plan.loses_configuration

    def __str__(self) -> str:
        """Say what it would do."""
        return self._plan.text


@dataclass(frozen=True, repr=False)
class FirmwareUpdate(checks.ShortRepr):
    """Result of an update."""

    file: FirmwareFile
    before: DeviceInfo | None
    after: DeviceInfo
    kept: bool | None
    """The saved configuration from before; None if it could not be asked."""
    configuration: str
    """The configuration before, for `torsio.load_config`; empty if it could not be read."""


def start_bootloader(selector: str | None = None) -> None:
    """Disarm a device and have it wait for new firmware, as a drive of its boot loader.

    It stays there until a file was copied onto the drive or it was unplugged. Devices of other
    releases understand this too, which `torsio.open` refuses.

    Raises
    ------
    Refused
        It has no boot loader, as an emulated one.
    DeviceNotFound, PermissionDenied, DeviceBusy, Timeout
    """
    _torsio.start_bootloader(checks.selector(selector))


def read_firmware(path: str | Path) -> FirmwareFile:
    """Look into a file.

    Raises
    ------
    InvalidArgument
        Says in a sentence why no knob could run it.
    Error
        It cannot be read.
    """
    return FirmwareFile(**_torsio.read_firmware(checks.path("path", path)))


def _info(told: dict[str, Any] | None) -> DeviceInfo | None:
    return None if told is None else DeviceInfo(**told)


def _silent(_: str) -> None:
    """Tell nobody."""


def prepare_update(
    path: str | Path,
    selector: str | None = None,
    *,
    drive: str | Path | None = None,
    timeout_s: float = 60.0,
    say: Say = _silent,
    host: FirmwareHost | None = None,
) -> FirmwarePlan:
    """Look at file and knob, and say what an update would do. Changes nothing.

    Parameters
    ----------
    path
        The file, `torsio-BOARD.uf2`.
    selector
        Path or serial number. None means the only knob, or a board that waits in its boot loader,
        as after plugging in with its button held.
    drive
        Folder of the boot loader's drive. Needed except on Linux, where it is found.
    timeout_s
        Longest wait for the drive, and again for the knob.
    say
        Is told each step, in words.
    host
        In place of this computer, for tests.

    Raises
    ------
    InvalidArgument
        The file is not whole, not firmware, or for another board; or its release cannot talk to
        this library.
    DeviceBusy
        Another program or a game has the knob.
    DeviceNotFound, PermissionDenied, Error
    """
    checks.function("say", say)
    plan = _torsio.prepare_update(
        checks.path("path", path),
        checks.selector(selector),
        None if drive is None else checks.path("drive", drive),
        checks.number("timeout_s", timeout_s),
        say,
        host,
    )
    device = None if plan.device is None else ListedDevice(**plan.device)
    file = FirmwareFile(**plan.file)
    return FirmwarePlan(file, device, _info(plan.before), plan.configuration, plan)


def carry_out(plan: FirmwarePlan) -> FirmwareUpdate:
    """Do what `prepare_update` has planned: disarm, boot loader, copy, wait, look what runs.

    Raises
    ------
    Timeout
        Drive or knob did not come; says what to do.
    Error
        Copying failed, or what runs now is not what was copied.
    Refused, DeviceBusy, Disconnected
        The knob would not go into its boot loader; nothing was changed.
    """
    checks.kind("plan", plan, FirmwarePlan, "a plan of torsio.prepare_update")
    done = _torsio.carry_out(plan._plan)
    return FirmwareUpdate(
        plan.file, plan.before, DeviceInfo(**done["after"]), done["kept"], done["configuration"]
    )


def update_firmware(
    path: str | Path,
    selector: str | None = None,
    *,
    drive: str | Path | None = None,
    timeout_s: float = 60.0,
    say: Say = _silent,
    host: FirmwareHost | None = None,
) -> FirmwareUpdate:
    """Put new firmware on a knob, without asking: `prepare_update` and `carry_out`.

    The saved configuration stays, unless the old firmware had other reports. Then the board has its
    defaults, and gives little until its parts are confirmed and their values known.
    """
    return carry_out(
        prepare_update(path, selector, drive=drive, timeout_s=timeout_s, say=say, host=host)
    )
