"""New firmware for a knob: look into a file, put it on the knob, and see that it runs.

>>> import torsio.firmware
>>> torsio.firmware.update("torsio-pico2.uf2")  # doctest: +SKIP

A board that waits for firmware is a drive with a file INFO_UF2.TXT; what is copied there runs.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from torsio import checks, config_cli, protocol, uf2
from torsio._torsio import start_bootloader as _start_bootloader
from torsio.boot_drives import Drive, Say, copy, drive_in, find_drives, wait_for_drive
from torsio.errors import (
    DeviceBusy,
    DeviceNotFound,
    Error,
    InvalidArgument,
    ProtocolMismatch,
    Timeout,
)
from torsio.opening import list_devices, open
from torsio.records import DeviceInfo, ListedDevice

__all__ = [
    "Drive",
    "FirmwareFile",
    "Plan",
    "Updated",
    "carry_out",
    "find_drives",
    "prepare",
    "read",
    "start_bootloader",
    "update",
]

_LOOK_EVERY_S = 0.2


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
    """Of the report layouts, as in `DeviceInfo`."""
    size: int
    """In flash, in bytes."""


@dataclass(frozen=True)
class Plan:
    """What an update would do: made by `prepare`, done by `carry_out`."""

    file: FirmwareFile
    device: ListedDevice | None
    """None: a board that waits in its boot loader already."""
    before: DeviceInfo | None
    """None if it cannot be asked: it is of another release, or waits already."""
    configuration: dict[str, Any] | None
    """As `torsio config dump` has it; None likewise."""
    drive: Path | None
    """Where the boot loader's drive was said to be."""

    @property
    def loses_configuration(self) -> bool:
        """The knob is of another release, whose configuration the new firmware cannot read."""
        return self.device is not None and self.before is None

    def __str__(self) -> str:
        """Say what it would do."""
        who = "the board that waits in its boot loader"
        if self.device is not None:
            who = f"the knob {self.device.serial or self.device.path}"
        now = "whose firmware is of another release" if self.device else "whatever it has"
        if self.before is not None:
            now = f"board {self.before.board}, firmware {self.before.firmware_version}"
        return f"{who} ({now}) gets firmware {self.file.version} for board {self.file.board}"


@dataclass(frozen=True)
class Updated:
    """What an update has done."""

    file: FirmwareFile
    before: DeviceInfo | None
    after: DeviceInfo
    kept: bool | None
    """The configuration is the one of before, which what was not saved does not outlive; None if
    that could not be asked."""
    configuration: dict[str, Any] | None
    """The one of before, for `torsio config load`."""


def start_bootloader(selector: str = "") -> None:
    """Disarm a device and have it wait for new firmware, as a drive of its boot loader.

    It stays there until a file was copied onto the drive or it was unplugged. Devices of other
    releases understand this too, which `torsio.open` refuses.

    Raises
    ------
    Refused
        It has no boot loader, as an emulated one.
    DeviceNotFound, PermissionDenied, DeviceBusy, Timeout
    """
    _start_bootloader(checks.text("selector", selector))


def read(path: str | Path) -> FirmwareFile:
    """Look into a file.

    Raises
    ------
    InvalidArgument
        Says in a sentence why no knob could run it.
    OSError
        It cannot be read.
    """
    path = Path(path)
    try:
        image = uf2.read(path.read_bytes())
        label = uf2.find_label(image)
    except uf2.FormatError as error:
        raise InvalidArgument(f"{path}: {error}") from None
    size = len(image.data)
    return FirmwareFile(path, image.chip, label.board, label.version, label.fingerprint, size)


def _real_devices() -> list[ListedDevice]:
    return [device for device in list_devices() if device.transport != "emulated"]


def _meant(selector: str, devices: list[ListedDevice]) -> ListedDevice | None:
    meant = [
        device for device in devices if not selector or selector in (device.path, device.serial)
    ]
    if len(meant) > 1:
        raise DeviceNotFound(
            "more than one knob is meant; name one: " + ", ".join(device.path for device in meant)
        )
    if selector and not meant:
        raise DeviceNotFound(f"there is no knob with path or serial number {selector!r}")
    return meant[0] if meant else None


def _examine(device: ListedDevice) -> tuple[DeviceInfo | None, dict[str, Any] | None]:
    try:
        with open(device.path) as knob:
            if knob.health().owner == "game":
                raise DeviceBusy("a game has the knob: end it first; nothing was changed")
            return knob.info, config_cli.dump(knob)
    except ProtocolMismatch:
        return None, None


def prepare(
    path: str | Path,
    selector: str = "",
    *,
    drive: str | Path | None = None,
    root: Path = Path("/"),
) -> Plan:
    """Look at file and knob, and say what an update would do. Changes nothing.

    Parameters
    ----------
    path
        The file, `torsio-BOARD.uf2`.
    selector
        Path or serial number; empty for the only knob, or for a board that waits in its boot
        loader already, as one does that was plugged in with its button held.
    drive
        Folder in which the boot loader's drive will be, where it cannot be found: anywhere but on
        Linux.
    root
        Of the system's files, for tests.

    Raises
    ------
    InvalidArgument
        The file is not whole, not firmware, for another board, or of another release than this
        library, which could not talk to the knob any more.
    DeviceBusy
        Another program or a game has the knob.
    DeviceNotFound, PermissionDenied, Error, OSError
    """
    if selector.split(":")[0] == "emulated":
        raise InvalidArgument("an emulated knob has no firmware of its own: it is the library's")
    file = read(path)
    if file.fingerprint != protocol.fingerprint():
        raise InvalidArgument(
            f"{path}: firmware {file.version} has the protocol fingerprint "
            f"0x{file.fingerprint:08x}, this library 0x{protocol.fingerprint():08x}: it could not "
            "talk to the knob; take firmware and library of the same release"
        )
    folder = Path(drive) if drive is not None else None
    if folder is None and not (root / "proc/mounts").exists():
        raise InvalidArgument("this system does not tell where drives are: give `drive`")
    waiting = [each.folder for each in find_drives(root)]
    device = _meant(selector, _real_devices())
    if device is None:
        if not waiting and not (folder and drive_in(folder)):
            raise DeviceNotFound(
                "no knob is plugged in, and no board waits in its boot loader; hold the board's "
                "BOOTSEL button while you plug it in"
            )
        return Plan(file, None, None, None, folder)
    if waiting and folder is None:
        raise Error(
            f"another board waits in its boot loader already, at {waiting[0]}: unplug it, or name "
            "the drive of the one that is meant"
        )
    before, configuration = _examine(device)
    board = before.board if before else device.board
    if board == "emulated":
        raise InvalidArgument("a virtual knob has no firmware of its own: it is the library's")
    if board and board != file.board:
        raise InvalidArgument(
            f"{path} is firmware for board {file.board}, and the knob is a {board}: take "
            f"torsio-{board}.uf2"
        )
    return Plan(file, device, before, configuration, folder)


def _wait_for_knob(plan: Plan, old: set[str], timeout_s: float) -> ListedDevice:
    end_s = time.monotonic() + timeout_s
    problem = "it has not come back"
    while time.monotonic() < end_s:
        for device in _real_devices():
            is_it = device.serial == plan.device.serial if plan.device else device.serial not in old
            if is_it and not device.problem:
                return device
            if is_it:
                problem = device.problem
        time.sleep(_LOOK_EVERY_S)
    raise Timeout(
        f"the firmware was copied, but no knob runs it after {timeout_s:g} s: {problem}; plug it "
        "in again, or load the firmware once more with the board's BOOTSEL button held"
    )


def carry_out(
    plan: Plan, *, timeout_s: float = 60.0, say: Say = lambda _: None, root: Path = Path("/")
) -> Updated:
    """Do what `prepare` has planned: disarm, boot loader, copy, wait, and look what runs.

    Parameters
    ----------
    timeout_s
        Longest wait for the drive, and again for the knob.
    say
        Is told each step, in words.

    Raises
    ------
    Timeout
        Drive or knob did not come; says what to do.
    Error
        Copying failed, or what runs now is not what was copied.
    Refused, DeviceBusy, Disconnected
        The knob would not go into its boot loader; nothing was changed.
    """
    old = {device.serial for device in _real_devices()}
    if plan.device is not None:
        say("disarming, and starting the boot loader")
        start_bootloader(plan.device.path)
    say("waiting for the boot loader's drive")
    drive = wait_for_drive(plan.file.path, plan.file.chip, plan.drive, root, timeout_s, say)
    say(f"copying {plan.file.size // 1024} KiB to {drive.folder}")
    copy(plan.file.path, drive)
    say("waiting for the knob")
    device = _wait_for_knob(plan, old, timeout_s)
    with open(device.path) as knob:
        after = knob.info
        configuration = config_cli.dump(knob)
    wanted = (plan.file.board, plan.file.version, plan.file.fingerprint)
    runs = (after.board, after.firmware_version, after.fingerprint)
    if runs != wanted:
        raise Error(
            f"the knob runs firmware {after.firmware_version} of board {after.board}, not "
            f"{plan.file.version} of board {plan.file.board}: it was not taken; try again"
        )
    kept = None if plan.configuration is None else configuration == plan.configuration
    return Updated(plan.file, plan.before, after, kept, plan.configuration)


def update(
    path: str | Path,
    selector: str = "",
    *,
    drive: str | Path | None = None,
    timeout_s: float = 60.0,
    say: Say = lambda _: None,
) -> Updated:
    """Put new firmware on a knob, without asking: `prepare` and `carry_out`.

    The configuration that was saved stays, unless the firmware before was of another release with
    other reports: then the board has its defaults and is held low until its parts are confirmed.
    """
    return carry_out(prepare(path, selector, drive=drive), timeout_s=timeout_s, say=say)
