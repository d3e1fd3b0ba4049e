"""Instructions for a tick of the device on a Cortex-M33, and the firmware's sizes, as JSON lines.

``./dev bench mcu`` prints a line for each scene: a number of walls, or one effect of a kind.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent.parent))

from tests.mcu import mcu

if __name__ == "__main__":
    sizes = mcu.sizes(mcu.FIRMWARE / "torsio-pico2.elf")
    for cost in mcu.costs():
        line = {
            "board": "pico2",
            "scene": cost.scene,
            "effects": cost.effects,
            "instructions_per_tick": cost.instructions,
            "flash_bytes": sizes.flash,
            "ram_bytes": sizes.ram,
        }
        print(json.dumps(line))
