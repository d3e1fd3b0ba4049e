"""Puts a release together: ``out/release/`` with all its files, their checksums, a list of parts.

``python -m tools.release --sdk FOLDER --tinyusb FOLDER`` takes what ``./dev wheels``,
``./dev firmware`` and ``./dev site`` have made, makes the wheels that are not there, and an sdist.
Nothing in it depends on when or where it was made: ``--compare FOLDER`` tells whether another
clone's files are the same.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import io
import json
import re
import shutil
import subprocess
import sys
import tarfile
import uuid
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from tools import boards, hidapi_source, sdist, wheel_pythons, wheels
from tools import site as documents

TREE = Path(__file__).parent.parent
OUT = TREE / "out/release"


def version() -> str:
    """Return the project's version."""
    text = (TREE / "CMakeLists.txt").read_text(encoding="utf-8")
    found = re.search(r"project\(torsio VERSION ([0-9.]+)", text)
    assert found
    return found[1]


@dataclass(frozen=True)
class Part:
    """What others have made and is inside."""

    name: str
    version: str
    licence: str
    where: str
    """In which files of a release."""
    package: str
    """A package URL up to the number of its version: so tools find what is known of it."""


def components(sdk: Path) -> list[Part]:
    """Return what others have made and is inside.

    Raises
    ------
    RuntimeError
        If a version cannot be found out.
    """
    pins = dict(
        re.findall(r'"([\w-]+)==([^";]+)"', (TREE / "pyproject.toml").read_text(encoding="utf-8"))
    )
    lock = json.loads((TREE / "studio/package-lock.json").read_text(encoding="utf-8"))
    zig = dict(tool.split("==") for tool in wheels.TOOLS)["ziglang"]
    option = (sdk / "lib/tinyusb/src/tusb_option.h").read_text(encoding="utf-8")
    tinyusb = ".".join(re.findall(r"#define TUSB_VERSION_(?:MAJOR|MINOR|REVISION)\s+(\d+)", option))
    known = (sdk / "pico_sdk_version.cmake").read_text(encoding="utf-8")
    parts = dict(re.findall(r"^set\(PICO_SDK_VERSION_(\w+) (\d+)\)", known, re.M))
    pico = ".".join(parts.get(name, "") for name in ("MAJOR", "MINOR", "REVISION"))
    hidapi = re.search(r"([\d.]+)$", str(hidapi_source.locate(TREE / "build/hidapi")))
    gcc = subprocess.run(
        ["arm-none-eabi-g++", "-dumpfullversion"], capture_output=True, text=True, check=False
    ).stdout.strip()
    apache = "Apache-2.0 WITH LLVM-exception"
    gcc_licence = "GPL-3.0-or-later WITH GCC-exception-3.1 AND BSD-3-Clause"
    listed = [
        Part("hidapi", hidapi[1] if hidapi else "", "BSD-3-Clause", "wheels",
             "github/libusb/hidapi@hidapi-"),
        Part("pybind11", pins.get("pybind11", ""), "BSD-3-Clause", "wheels", "pypi/pybind11@"),
        Part("libc++ and compiler-rt, of ziglang", zig, apache, "wheels", "pypi/ziglang@"),
        Part("mingw-w64's runtime, of ziglang", zig, "ZPL-2.1", "wheels for Windows",
             "pypi/ziglang@"),
        Part("TinyUSB", tinyusb, "MIT", "wheels and firmware", "github/hathach/tinyusb@"),
        Part("pico-sdk", pico, "BSD-3-Clause", "firmware", "github/raspberrypi/pico-sdk@"),
        Part("libgcc and newlib, of arm-none-eabi-gcc", gcc, gcc_licence, "firmware",
             "generic/arm-none-eabi-gcc@"),
        Part("furo", pins.get("furo", ""), "MIT", "site", "pypi/furo@"),
        Part("sphinx", pins.get("sphinx", ""), "BSD-2-Clause", "site", "pypi/sphinx@"),
        Part("uplot", lock["packages"]["node_modules/uplot"]["version"], "MIT", "site",
             "npm/uplot@"),
        Part("wasi-libc and libc++, of ziglang", zig, f"MIT AND BSD-2-Clause AND {apache}", "site",
             "pypi/ziglang@"),
    ]  # fmt: skip
    for part in listed:
        if not part.version:
            raise RuntimeError(f"the version of {part.name} cannot be found out")
    return listed


def bill_of_materials(sdk: Path) -> dict[str, Any]:
    """Return the list of parts, as CycloneDX has it."""
    made = datetime.fromtimestamp(int(sdist.epoch()), timezone.utc)
    own = f"pkg:pypi/torsio@{version()}"
    parts = components(sdk)
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        # The same parts at the same time have the same number.
        "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, f'{own} {made} {parts}')}",
        "version": 1,
        "metadata": {
            "timestamp": made.strftime("%Y-%m-%dT%H:%M:%SZ"),
            "component": {
                "type": "library", "bom-ref": own, "name": "torsio", "version": version(),
                "licenses": [{"expression": "MIT"}], "purl": own,
            },
        },
        "components": [
            {
                "type": "library", "bom-ref": part.name, "name": part.name,
                "version": part.version, "licenses": [{"expression": part.licence}],
                "purl": f"pkg:{part.package}{part.version}",
                "properties": [{"name": "torsio:inside", "value": part.where}],
            }
            for part in parts
        ],
        "dependencies": [{"ref": own, "dependsOn": [part.name for part in parts]}],
    }  # fmt: skip


def pack(folder: Path, archive: Path) -> None:
    """Pack a folder, as one that has the archive's name: the same files make the same bytes."""
    top = archive.name.removesuffix(".tar.gz")
    plain = io.BytesIO()
    with tarfile.open(fileobj=plain, mode="w", format=tarfile.PAX_FORMAT) as tar:
        for file in sorted(file for file in folder.rglob("*") if file.is_file()):
            entry = tarfile.TarInfo(f"{top}/{file.relative_to(folder).as_posix()}")
            entry.size = file.stat().st_size
            entry.mtime = int(sdist.epoch())
            with file.open("rb") as content:
                tar.addfile(entry, content)
    archive.write_bytes(gzip.compress(plain.getvalue(), mtime=0))


def checksums(folder: Path) -> str:
    """Return a line for each file, as ``sha256sum --check`` reads them."""
    files = sorted(file for file in folder.iterdir() if file.name != "SHA256SUMS")
    return "".join(
        f"{hashlib.sha256(file.read_bytes()).hexdigest()}  {file.name}\n" for file in files
    )


def is_of_this_commit(wheel: Path) -> bool:
    """Tell whether a wheel has the last commit's date; a zip counts pairs of seconds."""
    made = datetime.fromtimestamp(int(sdist.epoch()) // 2 * 2, timezone.utc)
    with zipfile.ZipFile(wheel) as files:
        return all(entry.date_time == made.timetuple()[:6] for entry in files.infolist())


def uncommitted(tree: Path) -> list[str]:
    """Return what is to be said of changes in no commit, which the sources would bring along."""
    command = ("git", "status", "--porcelain")
    changed = subprocess.run(command, cwd=tree, capture_output=True, check=True).stdout
    return ["the tree has changes that are in no commit: git status"] if changed else []


def wheels_there() -> list[Path]:
    """Return the wheels of this version."""
    return sorted(wheels.OUT.glob(f"torsio-{version()}-*.whl"))


def missing_wheels() -> list[tuple[str, str]]:
    """Return machine and Python of each wheel that is not there, or is of another commit."""
    names = [wheel.name for wheel in wheels_there() if is_of_this_commit(wheel)]
    return [
        (architecture, python)
        for architecture in wheels.ARCHITECTURES
        for python in wheel_pythons.MAVEN
        if not any(f"-cp{python.replace('.', '')}-" in name and architecture in name
                   for name in names)
    ]  # fmt: skip


def make_wheels(tinyusb: str, chosen: Sequence[str], machines: Sequence[str], *more: str) -> None:
    """Make the wheels that are not there, of these Pythons and for these machines.

    Raises
    ------
    RuntimeError
        If one cannot be made, or does not work.
    """
    for machine in machines:
        pythons = [python for name, python in missing_wheels() if name == machine]
        pythons = [python for python in pythons if python in chosen]
        words = [word for python in pythons for word in ("--python", python)]
        if words and wheels.main(["--tinyusb", tinyusb, "--arch", machine, *words, *more]):
            raise RuntimeError(f"the wheels for {machine} cannot be made")


def differences(one: str, other: str) -> list[str]:
    """Return a line for each file that is not the same in two lists of checksums."""
    sums = [
        {name: digest for digest, name in (line.split("  ", 1) for line in text.splitlines())}
        for text in (one, other)
    ]
    return [
        f"{name} "
        + ("has other bytes" if name in sums[0] and name in sums[1] else "is in one only")
        for name in sorted({*sums[0], *sums[1]})
        if sums[0].get(name) != sums[1].get(name)
    ]


def collect(sdk: Path) -> list[str]:
    """Fill ``out/release``, and return what is not there.

    Raises
    ------
    RuntimeError
        If something cannot be made.
    """
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    missing = uncommitted(TREE)
    missing += [
        f"no wheel for Python {python} on {architecture}: ./dev wheels --arch {architecture} "
        f"--python {python}"
        for architecture, python in missing_wheels()
    ]
    found = [wheel for wheel in wheels_there() if is_of_this_commit(wheel)]
    firmware = [
        TREE / "build/firmware" / f"torsio-{board}.{kind}"
        for board in boards.chips()
        for kind in ("uf2", "elf")
    ]
    missing += [f"no {file.name}: ./dev firmware" for file in firmware if not file.exists()]
    for file in (*found, *(file for file in firmware if file.exists())):
        shutil.copy(file, OUT)
    sdist.make(OUT)
    if documents.HTML.is_dir():
        pack(documents.HTML, OUT / f"torsio-{version()}-site.tar.gz")
    else:
        missing.append("no site: ./dev site")
    bill = json.dumps(bill_of_materials(sdk), indent=2) + "\n"
    (OUT / f"torsio-{version()}.cdx.json").write_text(bill, encoding="utf-8")
    shutil.copy(TREE / "NOTICES.md", OUT)
    (OUT / "SHA256SUMS").write_text(checksums(OUT), encoding="utf-8")
    return missing


def compare(other: Path) -> int:
    """Tell whether the same files are in another folder; return 1 if not."""
    sums = [(folder / "SHA256SUMS").read_text(encoding="utf-8") for folder in (OUT, other)]
    # The files themselves, not what was written down of them.
    for folder, text in zip((OUT, other), sums, strict=True):
        if text != checksums(folder):
            raise RuntimeError(f"{folder} does not have the files of its SHA256SUMS")
    for line in (differing := differences(*sums)):
        print(f"torsio: error: made twice: {line}", file=sys.stderr)
    if not differing:
        print(f"torsio: made twice, {len(sums[0].splitlines())} files have the same bytes")
    return 1 if differing else 0


def main(arguments: Sequence[str]) -> int:
    """Make what is missing, collect and tell; return 1 if anything is still missing."""
    parser = argparse.ArgumentParser(prog="./dev release", allow_abbrev=False)
    parser.add_argument("--sdk", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--tinyusb", help=argparse.SUPPRESS)
    parser.add_argument("--compare", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--arch", action="append", choices=wheels.ARCHITECTURES)
    parser.add_argument("--python", action="append", choices=wheel_pythons.MAVEN)
    parser.add_argument("--no-try", action="store_true", help="do not install wheels")
    options = parser.parse_args(arguments)
    try:
        if options.compare is not None:
            return compare(options.compare)
        make_wheels(
            options.tinyusb,
            options.python or [*wheel_pythons.MAVEN],
            options.arch or wheels.ARCHITECTURES,
            *(["--no-try"] if options.no_try else []),
        )
        missing = collect(options.sdk)
    except (RuntimeError, OSError) as error:
        print(f"torsio: error: {error}", file=sys.stderr)
        return 1
    print((OUT / "SHA256SUMS").read_text(encoding="utf-8"), end="")
    for line in missing:
        print(f"torsio: error: not complete: {line}", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
