"""Puts a release together: ``out/release/`` with all its files, their checksums, a list of parts.

``python -m tools.release --sdk FOLDER`` takes what ``./dev wheels``, ``./dev firmware`` and
``./dev site`` have made, and makes an sdist. Nothing in it depends on when or where it was made.
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
    found = sorted(wheels.OUT.glob(f"torsio-{version()}-*.whl"))
    for architecture in wheels.ARCHITECTURES:
        for python in wheel_pythons.MAVEN:
            tag = f"-cp{python.replace('.', '')}-"
            if not any(tag in wheel.name and architecture in wheel.name for wheel in found):
                command = f"./dev wheels --arch {architecture} --python {python}"
                missing.append(f"no wheel for Python {python} on {architecture}: {command}")
    missing += [
        f"{wheel.name} is of another commit: ./dev wheels"
        for wheel in found
        if not is_of_this_commit(wheel)
    ]
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


def main(arguments: Sequence[str]) -> int:
    """Collect and tell; return 1 if anything is missing."""
    parser = argparse.ArgumentParser(prog="./dev release", allow_abbrev=False)
    parser.add_argument("--sdk", required=True, type=Path)
    options = parser.parse_args(arguments)
    try:
        missing = collect(options.sdk)
    except RuntimeError as error:
        print(f"torsio: error: {error}", file=sys.stderr)
        return 1
    print((OUT / "SHA256SUMS").read_text(encoding="utf-8"), end="")
    for line in missing:
        print(f"torsio: error: not complete: {line}", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
