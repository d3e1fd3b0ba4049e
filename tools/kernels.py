"""Fetch the kernels that the tests in ``tests/vm`` boot.

``python -m tools.kernels FOLDER`` leaves one folder for each kernel, FOLDER/6.1 for example, with
``vmlinuz`` and, in ``modules``, all for a machine with USB. An existing folder is kept, until
other modules are wanted.

Debian has both kernels in the archives of one release, bookworm, which any newer Debian can read.
Another distribution's archive has neither, so there the newest kernel of the running release is
taken, and its folder has the distribution's name.

``--newest`` fetches the newest kernels that Debian has packages of instead, into folders with the
names of their suites: what games meet in a year.

Nothing is installed; see ``tools/apt.py``.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tarfile
from collections.abc import Mapping
from pathlib import Path

from tools import apt

# Set in the environment for ./dev test games: what games there are to try on one kernel, in
# minutes, and all tests of the game interface on kernels that are newer than any in use.
GAMES_VARIABLE = "TORSIO_GAMES_TESTS"
# Set for ./dev test usb: each test on each kernel, unless it has a mark that says otherwise.
# Otherwise one kernel runs the tests without a mark: they test code above the kernel.
EVERY_KERNEL_VARIABLE = "TORSIO_EVERY_KERNEL"
# The generic kernels: those for clouds have no USB.
DEBIAN = {"6.1": "linux-image-amd64", "6.12": "linux-image-6.12-amd64"}
# How the names of the packages begin that a kernel is cut into.
_KERNEL = ("linux-image-", "linux-modules-", "linux-binary-", "linux-base-")
# Suites whose kernel is newer.
NEWEST = ("trixie-backports", "sid")
# An image weighs hundreds of megabytes, most of it drivers for hardware that the machine lacks.
MODULES = (
    "arch/x86/crypto",
    "crypto",
    "drivers/hid",
    "drivers/input",
    "drivers/usb/common",
    "drivers/usb/core",
    "drivers/usb/misc",
    "drivers/usb/usbip",
    "drivers/virtio",
    "fs/9p",
    "fs/fscache",
    "fs/netfs",
    "fs/overlayfs",
    "lib",
    "net/9p",
)
_STAMP = "".join(f"{part}\n" for part in MODULES)


def wanted_kernels() -> dict[str, str]:
    """Return the package of each kernel that this system's archive has."""
    distribution = apt.os_release("ID")
    return DEBIAN if distribution == "debian" else {distribution: "linux-image-generic"}


def _sources(suite: str = "") -> list[tuple[apt.Archive, str, str]]:
    archive = apt.system_archive()
    if suite:
        return [(archive, suite, "main")]
    if apt.os_release("ID") == "debian":
        return [(archive, "bookworm", "main"), (archive.security, "bookworm-security", "main")]
    release = apt.os_release("VERSION_CODENAME")
    return [(archive, suite, "main") for suite in (release, f"{release}-updates")]


def _parts(packages: apt.PrivateApt, meta: str) -> list[str]:
    """Return the packages that hold image and modules of a meta-package's kernel."""
    parts: list[str] = []
    waiting = [meta]
    while waiting:
        for name in packages.dependencies(waiting.pop()):
            if name.startswith(_KERNEL) and name not in parts:
                parts.append(name)
                waiting.append(name)
    return parts


def _is_wanted_module(path: str) -> bool:
    _, found, module = path.partition("/kernel/")
    return found != "" and module.startswith(tuple(f"{part}/" for part in MODULES))


def _unpack(package: Path, folder: Path) -> None:
    """Unpack the image, the wanted modules, and the list of built-in ones."""
    command = ["dpkg-deb", "--fsys-tarfile", str(package)]
    with (
        subprocess.Popen(command, stdout=subprocess.PIPE) as unpacking,
        tarfile.open(fileobj=unpacking.stdout, mode="r|") as archive,
    ):
        for member in archive:
            source = archive.extractfile(member) if member.isfile() else None
            if source is None:
                continue
            path = Path(member.name)
            if path.name == "vmlinuz" or path.name.startswith("vmlinuz-"):
                target = folder / "vmlinuz"
            elif _is_wanted_module(member.name) or path.name == "modules.builtin":
                target = folder / "modules" / path.name
            else:
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(source.read())
    if unpacking.returncode != 0:
        raise RuntimeError(f"{package.name} cannot be unpacked")


def _is_complete(folder: Path) -> bool:
    stamp = folder / "complete"
    return stamp.exists() and stamp.read_text(encoding="utf-8") == _STAMP


def _fetch(folder: Path, kernels: Mapping[str, str], suite: str = "") -> list[Path]:
    missing = [name for name in kernels if not _is_complete(folder / name)]
    if missing:
        packages = apt.PrivateApt(folder / "apt", _sources(suite))
        for name in missing:
            shutil.rmtree(folder / name, ignore_errors=True)
            for part in packages.download(_parts(packages, kernels[name])):
                _unpack(part, folder / name)
                part.unlink()
            if not (folder / name / "vmlinuz").exists():
                raise RuntimeError(f"{kernels[name]} brought no kernel image")
            (folder / name / "complete").write_text(_STAMP, encoding="utf-8")
        shutil.rmtree(packages.folder)
    return [folder / name for name in kernels]


def fetch(folder: Path) -> list[Path]:
    """Make a folder for each kernel that has none yet, and return all of them.

    Raises
    ------
    RuntimeError
        If the archive does not give them.
    """
    return _fetch(folder, wanted_kernels())


def fetch_newest(folder: Path) -> list[Path]:
    """Do so for the newest kernels, which only Debian's archive has.

    Raises
    ------
    RuntimeError
        If this is no Debian, or the archive does not give them.
    """
    if apt.os_release("ID") != "debian":
        raise RuntimeError("only Debian's archive has them under these names")
    found: list[Path] = []
    for suite in NEWEST:
        found += _fetch(folder, {suite: DEBIAN["6.1"]}, suite)
    return found


def main(arguments: list[str]) -> int:
    """Print the kernels' folders, or say on standard error why there are none."""
    try:
        is_newest = arguments[:1] == ["--newest"]
        folders = fetch_newest(Path(arguments[1])) if is_newest else fetch(Path(arguments[0]))
    except (RuntimeError, OSError, tarfile.TarError) as error:
        print(f"the kernels for tests/vm cannot be had: {error}", file=sys.stderr)
        return 1
    print(*folders, sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
