"""Find or fetch Raspberry Pi's SDK and TinyUSB, which the firmware is built with.

`locate` gives the SDK's folder. In this order it takes

1. ``PICO_SDK_PATH``, if that is set: a checkout of version 2.1.1 or newer with its submodule
   ``lib/tinyusb``;
2. the packages ``pico-sdk-source`` and ``tinyusb-source``, if they are installed;
3. the same packages, downloaded and unpacked into a folder. Distributions that are older than the
   packages get them from a newer release; see ``tools/apt.py``.

Only the standard library is used: this runs before there is an environment.
"""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

from tools import apt

PACKAGES = ("pico-sdk-source", "tinyusb-source")
NEWER = {"debian": ("trixie", "forky", "sid"), "ubuntu": ("plucky", "questing", "resolute")}
SDK = Path("usr/src/pico-sdk")
# The first that knows the RP2040's 200 MHz and the core voltage that belongs to them.
OLDEST = (2, 1, 1)
HINT = "set PICO_SDK_PATH to pico-sdk 2.1.1 or newer with its submodule lib/tinyusb"


def what_is_wrong(folder: Path) -> str:
    """Return why a folder cannot be used; nothing if it holds a recent SDK with TinyUSB."""
    tinyusb = folder / "lib/tinyusb/src/portable/raspberrypi/rp2040/dcd_rp2040.c"
    version_file = folder / "pico_sdk_version.cmake"
    if not (folder / "pico_sdk_init.cmake").exists() or not version_file.exists():
        return "is not Raspberry Pi's SDK"
    if not tinyusb.exists():
        return "has no lib/tinyusb"
    text = version_file.read_text(encoding="utf-8")
    parts = dict(re.findall(r"^set\(PICO_SDK_VERSION_(\w+) (\d+)\)", text, re.MULTILINE))
    version = tuple(int(parts.get(name, 0)) for name in ("MAJOR", "MINOR", "REVISION"))
    if version >= OLDEST:
        return ""
    return f"is version {'.'.join(map(str, version))}, and {'.'.join(map(str, OLDEST))} is needed"


def fetch(folder: Path) -> Path:
    """Download and unpack both packages; return the SDK's folder.

    Raises
    ------
    RuntimeError
        If no release of the system's distribution could give them.
    """
    name = apt.os_release("ID")
    components = "universe" if name == "ubuntu" else "main"
    archive = apt.system_archive()
    complaints = []
    for suite in NEWER.get(name, ()):
        shutil.rmtree(folder, ignore_errors=True)
        try:
            packages = apt.PrivateApt(folder / "apt", [(archive, suite, components)])
            for package in packages.download(PACKAGES):
                apt.run(["dpkg-deb", "-x", str(package), str(folder.resolve())], folder)
        except RuntimeError as error:
            complaints.append(f"{suite}: {error}")
            continue
        shutil.rmtree(folder / "apt")
        if not (complaint := what_is_wrong(folder / SDK)):
            return folder / SDK
        complaints.append(f"{suite}: the package {complaint}")
    raise RuntimeError("\n".join(complaints) or f"no known release of {name or 'this system'}")


def locate(folder: Path) -> Path:
    """Return the SDK's folder, fetching it into ``folder`` if there is no other.

    Raises
    ------
    RuntimeError
        If ``PICO_SDK_PATH`` is no SDK or an old one, or nothing could be fetched.
    """
    if chosen := os.environ.get("PICO_SDK_PATH"):
        if complaint := what_is_wrong(Path(chosen)):
            raise RuntimeError(f"PICO_SDK_PATH={chosen} {complaint}")
        return Path(chosen).resolve()
    for candidate in ("/" / SDK, folder / SDK):
        if not what_is_wrong(candidate):
            return candidate.resolve()
    return fetch(folder).resolve()
