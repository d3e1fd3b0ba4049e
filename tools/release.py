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
from collections.abc import Sequence
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


def components(sdk: Path) -> list[tuple[str, str, str, str]]:
    """Return what others have made and is inside: name, version, licence, in which files.

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
    listed = [
        ("hidapi", hidapi[1] if hidapi else "", "BSD-3-Clause", "wheels"),
        ("pybind11", pins.get("pybind11", ""), "BSD-3-Clause", "wheels"),
        ("libc++ and compiler-rt, of ziglang", zig, "Apache-2.0 WITH LLVM-exception", "wheels"),
        ("mingw-w64's runtime, of ziglang", zig, "ZPL-2.1", "wheels for Windows"),
        ("TinyUSB", tinyusb, "MIT", "wheels and firmware"),
        ("pico-sdk", pico, "BSD-3-Clause", "firmware"),
        ("libgcc and newlib, of arm-none-eabi-gcc", gcc,
         "GPL-3.0-or-later WITH GCC-exception-3.1 AND BSD-3-Clause", "firmware"),
        ("furo", pins.get("furo", ""), "MIT", "site"),
        ("uplot", lock["packages"]["node_modules/uplot"]["version"], "MIT", "site"),
        ("wasi-libc and libc++, of ziglang", zig,
         "MIT AND Apache-2.0 WITH LLVM-exception", "site"),
    ]  # fmt: skip
    for name, number, *_ in listed:
        if not number:
            raise RuntimeError(f"the version of {name} cannot be found out")
    return listed


def bill_of_materials(sdk: Path) -> dict[str, Any]:
    """Return the list of parts, as CycloneDX has it."""
    made = datetime.fromtimestamp(int(sdist.epoch()), timezone.utc)
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {
            "timestamp": made.strftime("%Y-%m-%dT%H:%M:%SZ"),
            "component": {
                "type": "library", "name": "torsio", "version": version(),
                "licenses": [{"expression": "MIT"}],
            },
        },
        "components": [
            {
                "type": "library", "name": name, "version": number,
                "licenses": [{"expression": licence}],
                "properties": [{"name": "torsio:inside", "value": where}],
            }
            for name, number, licence, where in components(sdk)
        ],
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


def collect(sdk: Path) -> list[str]:
    """Fill ``out/release``, and return what is not there.

    Raises
    ------
    RuntimeError
        If something cannot be made.
    """
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    missing = []
    found = sorted(wheels.OUT.glob(f"torsio-{version()}-*.whl"))
    for architecture in wheels.ARCHITECTURES:
        for python in wheel_pythons.MAVEN:
            tag = f"-cp{python.replace('.', '')}-"
            if not any(tag in wheel.name and architecture in wheel.name for wheel in found):
                command = f"./dev wheels --arch {architecture} --python {python}"
                missing.append(f"no wheel for Python {python} on {architecture}: {command}")
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
