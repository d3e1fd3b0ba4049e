"""Runs the programs of this folder on their processors."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from tools import boards
from tools.dev.groups import BOARDS_VARIABLE

TREE = Path(__file__).parent.parent.parent
PROGRAMS = TREE / "build" / "mcu"
FIRMWARE = TREE / "build" / "firmware"
# Boards that take part, and their chips.
TESTED = os.environ.get(BOARDS_VARIABLE, "").split()
CHIPS = {board: chip for board, chip in boards.chips().items() if board in TESTED or not TESTED}
# The cross compiler of the documents' figures, and the margin for another: GCC 14's code takes 7 %
# more on a Cortex-M33, and 4 % on a Cortex-M0+.
DOCUMENTED_GCC = 12
_OTHER_GCC = 0.2


def gcc_major() -> int:
    """Return the major version of the cross compiler."""
    return int(_output(["arm-none-eabi-g++", "-dumpversion"]).split(".")[0])


def as_documented(share: float) -> float:
    """Return how far a figure may be from that in the documents, which say `share`."""
    return share if gcc_major() == DOCUMENTED_GCC else _OTHER_GCC


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
    """The cost of a tick with a scene: of the whole device, or of the control law alone."""

    scene: str
    effects: int
    instructions: float


def costs(board: str) -> list[Cost]:
    """Measure every scene on a board's processor."""
    run = {"pico": on_m0plus, "pico2": on_m33}[board]
    found = []
    for line in "".join(map(run, ("bench", "bench_core", "bench_shaft"))).splitlines():
        scene, effects, hundredths = line.rsplit(" ", 2)
        found.append(Cost(scene, int(effects), int(hundredths) / 100))
    return found
