"""Instructions for a tick on each board's processor, and the firmware's sizes, as JSON lines.

``./dev bench mcu`` prints a line for each scene: a number of walls, or one effect of a kind. The
Cortex-M33 of ``pico2`` is counted by QEMU, the Cortex-M0+ of ``pico`` by the emulated RP2040; both
count instructions, not cycles. ``control law`` is the same without the device round it.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent.parent))

from tests.mcu import mcu
from tools import firmware_report

if __name__ == "__main__":
    for board in ("pico2", "pico"):
        sizes = firmware_report.sizes(mcu.FIRMWARE / f"torsio-{board}.elf")
        for cost in mcu.costs(board):
            line = {
                "board": board,
                "scene": cost.scene,
                "effects": cost.effects,
                "instructions_per_tick": cost.instructions,
                "flash_bytes": sizes.flash,
                "ram_bytes": sizes.ram,
            }
            print(json.dumps(line))
