"""Zig's compiler, as CMake calls it, for each kind of machine that there are wheels for, and macOS.

It comes from PyPI, brings the C library of 2014 that Linux's wheels are for and Windows's own one,
and its C++ library goes inside what it makes.
"""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from tools.wheel_commands import BUILD, run

GLIBC = "2.17"  # of manylinux2014: every distribution since 2014
UDEV = Path("/usr/include/libudev.h")
# Zig's names for the machines of wheels and other builds.
TARGETS = {
    "x86_64": f"x86_64-linux-gnu.{GLIBC}",
    "aarch64": f"aarch64-linux-gnu.{GLIBC}",
    "win_amd64": "x86_64-windows-gnu",
    "macos_arm64": "aarch64-macos",
    "macos_x86_64": "x86_64-macos",
}
# CMake asks with -v what programs are linked to by themselves, and then names that too. It would be
# files in Zig's cache: others on each machine, and other ones again in its first run on one.
_SILENT = """\
for word; do
  shift
  [ "$word" = -v ] || set -- "$@" "$word"
done
"""
_WORDS = {"clang": "cc", "clang++": "c++", "ar": "ar", "ranlib": "ranlib", "windres": "rc"}


@dataclass(frozen=True)
class Compilers:
    """The compilers for one kind of machine, and what they find there."""

    architecture: str
    folder: Path

    @property
    def is_windows(self) -> bool:
        """These make programs for Windows."""
        return "windows" in TARGETS[self.architecture]

    @property
    def system(self) -> str:
        """CMake's name for the system that the programs are for."""
        known = {"windows": "Windows", "macos": "Darwin", "linux": "Linux"}
        return next(name for word, name in known.items() if word in TARGETS[self.architecture])

    @property
    def variables(self) -> dict[str, str]:
        """Variables for CMake."""
        return {"CC": str(self.folder / "clang"), "CXX": str(self.folder / "clang++")}

    @property
    def settings(self) -> dict[str, str]:
        """CMake's settings."""
        include = f"-I{self.folder}/include -ffile-prefix-map={BUILD}=."
        library = f"-L{self.folder} -Wl,-s"
        settings = {
            "CMAKE_AR": str(self.folder / "ar"),
            "CMAKE_RANLIB": str(self.folder / "ranlib"),
            "CMAKE_SYSTEM_NAME": self.system,
            "CMAKE_SYSTEM_PROCESSOR": TARGETS[self.architecture].split("-")[0],
            "CMAKE_C_FLAGS": include,
            "CMAKE_CXX_FLAGS": include,
            "CMAKE_SHARED_LINKER_FLAGS": library,
            "CMAKE_MODULE_LINKER_FLAGS": library,
            "CMAKE_EXE_LINKER_FLAGS": "-Wl,-s",
        }
        if self.is_windows:
            settings["CMAKE_RC_COMPILER"] = str(self.folder / "windres")
        return settings


def compilers(folder: Path, architecture: str, python: Path) -> Compilers:
    """Write the programs that CMake calls, below a folder, and a libudev to link to.

    The user's libudev does the work; the stub has only the names of its functions.
    """
    (folder / "include").mkdir(parents=True, exist_ok=True)
    target = f"-target {TARGETS[architecture]} -fno-sanitize=all"
    for name, word in _WORDS.items():
        words = f"{word} {target}" if name.startswith("clang") else word
        silent = _SILENT if name.startswith("clang") else ""
        text = f'#!/bin/sh\n{silent}exec "{python}" -m ziglang {words} "$@"\n'
        # A compiler cache takes a file with another date for another compiler.
        if not (folder / name).exists() or (folder / name).read_text() != text:
            (folder / name).write_text(text)
            (folder / name).chmod(0o755)
    made = Compilers(architecture, folder)
    if made.system == "Linux":
        shutil.copy(UDEV, folder / "include")
        functions = sorted(set(re.findall(r"\b(udev_\w+)\(", UDEV.read_text())))
        stub = folder / "udev.c"
        stub.write_text("".join(f"void {name}(void) {{}}\n" for name in functions))
        command = (folder / "clang", "-shared", "-fPIC", "-Wl,-soname,libudev.so.1", stub)
        run("libudev", *command, "-o", folder / "libudev.so")
    return made
