"""Makes what the guests need to play as Windows games do: programs, SDL, Wine's own folder."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

TREE = Path(__file__).parent.parent
FOLDER = TREE / "build/games"
SOURCES = TREE / "tests/vm/guest/dinput"
PROGRAMS = ("effects", "sdl")
# SDL's Windows builds, and the packages for Python that bring them.
SDL = {"SDL2.dll": "pysdl2-dll==2.32.10", "SDL3.dll": "tcod==21.2.2"}
COMPILER = "x86_64-w64-mingw32-g++-posix"
_FLAGS = ("-std=c++20", "-O1", "-Wall", "-Wextra", "-Werror", "-static")
_LIBRARIES = ("-ldinput8", "-ldxguid", "-lole32")
_SERVICE = r"HKLM\System\CurrentControlSet\Services\winebus"
# Reads devices over hidraw alone, and finds them without udev's database.
_BUS_OPTIONS = {"Enable SDL": 0, "DisableHidraw": 0, "DisableInput": 1, "DisableUdevd": 1}
# Says nothing of what it lacks, and asks for neither .NET nor a browser.
QUIET = {"WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree,mshtml=", "DISPLAY": ""}


def _fetch_sdl(library: str, package: str) -> None:
    """Take a library out of a package for Windows, which need not be installed."""
    if (FOLDER / library).exists():
        return
    wheels = FOLDER / "wheels"
    shutil.rmtree(wheels, ignore_errors=True)
    options = ("--disable-pip-version-check", "--no-deps", "--only-binary=:all:", "--retries", "5")
    command = [sys.executable, "-m", "pip", "download", *options, "--platform", "win_amd64"]
    subprocess.run([*command, "--dest", wheels, package], check=True)
    (wheel,) = wheels.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        (name,) = [name for name in archive.namelist() if Path(name).name == library]
        (FOLDER / library).write_bytes(archive.read(name))
    shutil.rmtree(wheels)


def make() -> None:
    """Compile the programs, fetch SDL and make ``build/games/prefix``, unless they are there.

    Raises
    ------
    subprocess.CalledProcessError
        If a compiler, pip or Wine fails.
    """
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in PROGRAMS:
        source, program = SOURCES / f"{name}.cpp", FOLDER / f"{name}.exe"
        if not program.exists() or program.stat().st_mtime < source.stat().st_mtime:
            subprocess.run([COMPILER, *_FLAGS, source, "-o", program, *_LIBRARIES], check=True)
    for library, package in SDL.items():
        _fetch_sdl(library, package)
    prefix = FOLDER / "prefix"
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
