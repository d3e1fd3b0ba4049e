"""Makes what the guests play: games of Windows and of OIS, the library, Wine's own folder."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from tools import hidapi_source

TREE = Path(__file__).parent.parent
FOLDER = TREE / "build/games"
SOURCE = TREE / "tests/vm/guest/dinput/effects.cpp"
PROGRAM = FOLDER / "effects.exe"
OIS = TREE / "tests/vm/guest/ois.cpp"
COMPILER = "x86_64-w64-mingw32-g++-posix"
C_COMPILER = "x86_64-w64-mingw32-gcc-posix"
# A program with the library, whose hidapi is the wheels', and what Wine 8 lacks for that.
LIBRARY = FOLDER / "library"
PLUGGED = TREE / "tests/vm/guest/windows/plugged.c"
WINE_LACKS = TREE / "tools/wine"
_FLAGS = ("-std=c++20", "-O1", "-Wall", "-Wextra", "-Werror", "-static")
_LIBRARIES = ("-ldinput8", "-ldxguid", "-lole32")
_SERVICE = r"HKLM\System\CurrentControlSet\Services\winebus"
# Reads devices over hidraw alone, and finds them without udev's database.
_BUS_OPTIONS = {"Enable SDL": 0, "DisableHidraw": 0, "DisableInput": 1, "DisableUdevd": 1}
# Reports no missing parts, and asks for neither .NET nor a browser.
QUIET = {"WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree,mshtml=", "DISPLAY": ""}


def _make_library() -> None:
    """Compile the C interface without the emulated knob, the program, and hidapi's way to Wine."""
    settings = {
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_CXX_FLAGS_RELEASE": "-O1",
        "CMAKE_TOOLCHAIN_FILE": TREE / "cmake/Mingw.cmake",
        "CMAKE_UNITY_BUILD": "ON",
        "TORSIO_BUILD_EXAMPLES": "OFF",
        "TORSIO_BUILD_TESTS": "OFF",
        "TORSIO_HIDAPI_SOURCE": hidapi_source.locate(TREE / "build/hidapi"),
        "TORSIO_INSTALL": "OFF",
        "TORSIO_WITH_EMULATOR": "OFF",
    }
    build = LIBRARY / "cmake"
    defines = [f"-D{name}={value}" for name, value in settings.items()]
    subprocess.run(["cmake", "-S", TREE, "-B", build, "-G", "Ninja", *defines], check=True)
    subprocess.run(["cmake", "--build", build, "--target", "torsio_c"], check=True)
    shutil.copy(build / "sdk/c/torsio.dll", LIBRARY)
    flags = ("-std=c11", "-O1", "-Wall", "-Wextra", "-Werror")
    parts = (WINE_LACKS / "cfgmgr32.c", WINE_LACKS / "cfgmgr32.def", "-lsetupapi")
    shim = (*parts, "-shared", "-o", LIBRARY / "cfgmgr32.dll")
    subprocess.run([C_COMPILER, *flags, *shim], check=True)
    include = f"-I{TREE / 'sdk/c/include'}"
    program = (PLUGGED, build / "sdk/c/libtorsio.dll.a", "-o", LIBRARY / "plugged.exe")
    subprocess.run([C_COMPILER, *flags, include, *program], check=True)


def make() -> None:
    """Compile the programs and the library, and make ``build/games/prefix``.

    Existing files are not made again.

    Raises
    ------
    subprocess.CalledProcessError
        If a compiler, pip or Wine fails.
    """
    FOLDER.mkdir(parents=True, exist_ok=True)
    if not PROGRAM.exists() or PROGRAM.stat().st_mtime < SOURCE.stat().st_mtime:
        subprocess.run([COMPILER, *_FLAGS, SOURCE, "-o", PROGRAM, *_LIBRARIES], check=True)
    subprocess.run(["c++", *_FLAGS[:4], OIS, "-o", FOLDER / "ois", "-lOIS"], check=True)
    _make_library()
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
