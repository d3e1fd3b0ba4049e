"""The drive that a board shows while it waits for firmware, with a file INFO_UF2.TXT."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from torsio.errors import Error, InvalidArgument, Timeout

__all__ = ["Drive", "copy", "drive_in", "find_drives", "wait_for_drive"]

# What the boot loader calls itself in INFO_UF2.TXT; its drive's label is the same.
_BOARD_IDS = {"rp2040": "RPI-RP2", "rp2350": "RP2350"}
_INFO = "INFO_UF2.TXT"
_LOOK_EVERY_S = 0.2
# Desktops mount a drive by themselves within a second or two.
_PATIENCE_S = 4.0

Say = Callable[[str], object]


@dataclass(frozen=True)
class Drive:
    """The drive of a boot loader."""

    folder: Path
    board_id: str
    """"RPI-RP2" or "RP2350"."""


def _mounts(root: Path) -> list[tuple[str, Path]]:
    """Give devices and where they are mounted."""
    try:
        lines = (root / "proc/mounts").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []
    # A blank in a name stands there as \040.
    pairs = [
        [re.sub(r"\\([0-7]{3})", lambda octal: chr(int(octal[1], 8)), word) for word in words[:2]]
        for words in map(str.split, lines)
        if len(words) >= 2
    ]
    return [(device, root / folder.lstrip("/")) for device, folder in pairs]


def drive_in(folder: Path) -> Drive | None:
    """Give the drive that is mounted in a folder, if it is a boot loader's."""
    try:
        text = (folder / _INFO).read_text(encoding="ascii", errors="replace")
    except OSError:
        return None
    board_id = re.search(r"^Board-ID:\s*(\S+)", text, re.MULTILINE)
    return Drive(folder, board_id[1]) if board_id else None


def find_drives(root: Path = Path("/")) -> list[Drive]:
    """Find the drives of boot loaders that are mounted, below another root if told."""
    drives = [drive_in(folder) for device, folder in _mounts(root) if device.startswith("/dev/")]
    return [drive for drive in drives if drive and drive.board_id in _BOARD_IDS.values()]


def _hint(board_id: str, root: Path) -> str:
    """Say how a drive that is there but not mounted is mounted; empty if there is none."""
    link = root / "dev/disk/by-label" / board_id
    if not link.is_symlink() and not link.exists():
        return ""
    node = f"/dev/disk/by-label/{board_id}"
    return (
        f"the boot loader's drive {node} is there but not mounted; mount it with "
        f"`udisksctl mount -b {node}`, or `sudo mount -o umask=0 {node} /mnt`"
    )


def wait_for_drive(
    path: Path, chip: str, folder: Path | None, root: Path, timeout_s: float, say: Say
) -> Drive:
    """Wait for the drive that a file belongs on; in one folder, if it is given."""
    board_id = _BOARD_IDS[chip]
    begin_s = time.monotonic()
    hinted = False
    while True:
        found = [drive_in(folder)] if folder else find_drives(root)
        drives = [drive for drive in found if drive]
        wrong = [drive.board_id for drive in drives if drive.board_id != board_id]
        if folder and wrong:
            raise InvalidArgument(
                f"{folder} is the drive of an {wrong[0]}, and {path} is for an "
                f"{board_id}: nothing was copied"
            )
        right = [drive for drive in drives if drive.board_id == board_id]
        if len(right) > 1:
            raise Error(
                "more than one board waits in its boot loader: "
                + ", ".join(str(drive.folder) for drive in right)
                + "; name the drive that is meant, nothing was copied"
            )
        if right:
            return right[0]
        waited_s = time.monotonic() - begin_s
        hint = "" if folder else _hint(board_id, root)
        if waited_s > timeout_s:
            where = str(folder) if folder else f"a drive {board_id}"
            raise Timeout(
                hint
                or f"{where} with {_INFO} did not appear within {timeout_s:g} s; the board waits "
                "for firmware: copy the file onto its drive, or unplug it and plug it in again, "
                "which leaves the old one"
            )
        if hint and not hinted and waited_s > min(_PATIENCE_S, timeout_s / 2):
            hinted = True
            say(hint)
        time.sleep(_LOOK_EVERY_S)


def copy(path: Path, drive: Drive) -> None:
    """Copy a file to where it runs as soon as it is whole."""
    content = path.read_bytes()
    target = drive.folder / "torsio.uf2"
    written = 0
    try:
        with target.open("wb", buffering=0) as stream:
            while written < len(content):
                written += stream.write(content[written : written + 65536]) or 0
            os.fsync(stream.fileno())
    except OSError as error:
        # The board starts anew at the last block, and takes its drive away.
        if written < len(content):
            raise Error(
                f"copying to {drive.folder} failed ({error.strerror or error}); the board still "
                f"waits: copy {path} there by hand, or try again"
            ) from None
