"""Find or fetch Raspberry Pi's SDK and TinyUSB, which the firmware is built with.

``python -m tools.firmware_sources FOLDER`` prints the SDK's folder. In this order it takes

1. ``PICO_SDK_PATH``, if that is set: a checkout with its submodule ``lib/tinyusb``;
2. the packages ``pico-sdk-source`` and ``tinyusb-source``, if they are installed;
3. the same packages, downloaded and unpacked into FOLDER. Distributions that are older than the
   packages get them from a newer release; see ``tools/apt.py``.

Only the standard library is used: this runs before there is an environment.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from tools import apt

PACKAGES = ("pico-sdk-source", "tinyusb-source")
NEWER = {"debian": ("trixie", "forky", "sid"), "ubuntu": ("plucky", "questing", "resolute")}
SDK = Path("usr/src/pico-sdk")


def is_sdk(folder: Path) -> bool:
    """Tell whether a folder holds the SDK with TinyUSB."""
    tinyusb = folder / "lib/tinyusb/src/portable/raspberrypi/rp2040/dcd_rp2040.c"
    return (folder / "pico_sdk_init.cmake").exists() and tinyusb.exists()


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
        if is_sdk(folder / SDK):
            return folder / SDK
    raise RuntimeError("\n".join(complaints) or f"no known release of {name or 'this system'}")


def locate(folder: Path) -> Path:
    """Return the SDK's folder, fetching it into ``folder`` if there is no other.

    Raises
    ------
    RuntimeError
        If ``PICO_SDK_PATH`` is not an SDK, or nothing could be fetched.
    """
    if chosen := os.environ.get("PICO_SDK_PATH"):
        if not is_sdk(Path(chosen)):
            raise RuntimeError(f"PICO_SDK_PATH={chosen} is not Raspberry Pi's SDK with lib/tinyusb")
        return Path(chosen).resolve()
    for candidate in ("/" / SDK, folder / SDK):
        if is_sdk(candidate):
            return candidate.resolve()
    return fetch(folder).resolve()


def main(arguments: list[str]) -> int:
    """Print the SDK's folder, or say on standard error why there is none."""
    try:
        print(locate(Path(arguments[0])))
    except RuntimeError as error:
        hint = "set PICO_SDK_PATH to a checkout of pico-sdk with its submodule lib/tinyusb"
        print(f"{error}\n{hint}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
