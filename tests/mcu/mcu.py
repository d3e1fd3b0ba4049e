"""Runs the programs of this folder on their processors."""

from __future__ import annotations

import shutil
import struct
import subprocess
from dataclasses import dataclass
from pathlib import Path

TREE = Path(__file__).parent.parent.parent
PROGRAMS = TREE / "build" / "mcu"
FIRMWARE = TREE / "build" / "firmware"


def _output(command: list[str]) -> str:
    result = subprocess.run(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=True,
        timeout=300,
    )
    return result.stdout


def on_host(program: str) -> str:
    """Run a program on this machine."""
    return _output([str(PROGRAMS / "host" / program)])


def on_m33(program: str) -> str:
    """Run a program on a Cortex-M33 whose every instruction takes a nanosecond."""
    machine = ["qemu-system-arm", "-M", "mps2-an505", "-icount", "shift=0"]
    quiet = ["-nographic", "-monitor", "none", "-serial", "none", "-semihosting"]
    return _output([*machine, *quiet, "-kernel", str(PROGRAMS / "m33" / program)])


def on_m0plus(program: str) -> str:
    """Run a program on the Cortex-M0+ of an emulated RP2040."""
    runner = TREE / "tests" / "mcu" / "m0plus.mjs"
    image = PROGRAMS / "m0plus" / f"{program}.bin"
    return _output([shutil.which("node") or "node", str(runner), str(image)])


@dataclass(frozen=True)
class Cost:
    """What a tick of :class:`Device` costs with a scene."""

    scene: str
    effects: int
    instructions: float


def costs() -> list[Cost]:
    """Measure every scene on a Cortex-M33."""
    found = []
    for line in on_m33("bench").splitlines():
        scene, effects, hundredths = line.rsplit(" ", 2)
        found.append(Cost(scene, int(effects), int(hundredths) / 100))
    return found


@dataclass(frozen=True)
class Sizes:
    """Bytes of a firmware."""

    flash: int
    ram: int
    symbols: frozenset[str]


def sizes(elf: Path) -> Sizes:
    """Read an ELF file: what is loaded into the flash, what is taken of the RAM, its symbols."""
    data = elf.read_bytes()
    header = struct.unpack_from("<16sHHIIIIIHHHHHH", data)
    sections = [
        struct.unpack_from("<10I", data, header[6] + n * header[11]) for n in range(header[12])
    ]
    flash = 0
    for n in range(header[10]):
        kind, _, _, _, length, *_ = struct.unpack_from("<8I", data, header[5] + n * header[9])
        flash += length if kind == 1 else 0
    allocated = [s for s in sections if s[2] & 2]
    ram = sum(s[5] for s in allocated if 0x20000000 <= s[3] < 0x20100000)
    names = set()
    for section in sections:
        if section[1] != 2:
            continue
        strings = sections[section[6]][4]
        for at in range(section[4], section[4] + section[5], section[9]):
            (name,) = struct.unpack_from("<I", data, at)
            end = data.index(b"\0", strings + name)
            names.add(data[strings + name : end].decode())
    return Sizes(flash, ram, frozenset(names))
