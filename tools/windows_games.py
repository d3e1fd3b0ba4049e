"""Makes what the guests need to play as a Windows game does: a program, and Wine's own folder."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

TREE = Path(__file__).parent.parent
FOLDER = TREE / "build/games"
SOURCE = TREE / "tests/vm/guest/dinput/effects.cpp"
COMPILER = "x86_64-w64-mingw32-g++-posix"
_FLAGS = ("-std=c++20", "-O1", "-Wall", "-Wextra", "-Werror", "-static")
_LIBRARIES = ("-ldinput8", "-ldxguid", "-lole32")
_SERVICE = r"HKLM\System\CurrentControlSet\Services\winebus"
# Reads devices over hidraw alone, and finds them without udev's database.
_BUS_OPTIONS = {"Enable SDL": 0, "DisableHidraw": 0, "DisableInput": 1, "DisableUdevd": 1}
# Says nothing of what it lacks, and asks for neither .NET nor a browser.
QUIET = {"WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree,mshtml=", "DISPLAY": ""}


def make() -> None:
    """Compile the program and make ``build/games/prefix``, unless they are there.

    Raises
    ------
    subprocess.CalledProcessError
        If a compiler or Wine fails.
    """
    FOLDER.mkdir(parents=True, exist_ok=True)
    program, prefix = FOLDER / "effects.exe", FOLDER / "prefix"
    if not program.exists() or program.stat().st_mtime < SOURCE.stat().st_mtime:
        subprocess.run([COMPILER, *_FLAGS, SOURCE, "-o", program, *_LIBRARIES], check=True)
    if (prefix / "complete").exists():
        return
    shutil.rmtree(prefix, ignore_errors=True)
    environment = {**os.environ, **QUIET, "WINEPREFIX": str(prefix)}
    # Seconds here, minutes in a machine whose processor is emulated.
    commands = [["wineboot", "--init"]]
    for name, value in _BUS_OPTIONS.items():
        commands.append(
            ["reg", "add", _SERVICE, "/v", name, "/t", "REG_DWORD", "/d", str(value), "/f"]
        )
    for command in commands:
        subprocess.run(
            ["wine", *command], env=environment, stdin=subprocess.DEVNULL, check=True, timeout=600
        )
    subprocess.run(["wineserver", "--wait"], env=environment, check=True, timeout=600)
    (prefix / "complete").touch()


if __name__ == "__main__":
    make()
