"""Instructions for a tick on each board's processor, and the firmware's sizes, as JSON lines.

``./dev bench mcu`` prints a line for each scene: a number of walls, or one effect of a kind. The
Cortex-M33 of ``pico2`` is counted by QEMU, the Cortex-M0+ of ``pico`` by the emulated RP2040; both
count instructions, not cycles. ``control law`` is the same without the device round it.

What the board adds to the device (encoder, current loop, PWM) is not in these counts. It is in the
last lines of each board: there the real binary runs in the emulated chip and tells in its health
report how long its ticks take. The RP2350's cycles are estimates there.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent.parent))

from tests.board.pico import MODELS, choose, enumerated
from tests.mcu import mcu
from tools import firmware_report


def tick_time_ns(walls: int) -> int:
    """Return how long a tick of the chosen board's binary takes inside so many damped walls."""
    wall = {"angle_turns_q32": 0, "side": "above", "stiffness_nm_per_rad": 0.1}
    with enumerated() as pico:
        pico.set("control_config", passive_ramp_s=0.0)
        pico.turn(60)
        for slot in range(walls):
            pico.send("wall", slot=slot, damping_nm_s_per_rad=1e-4, **wall)
        pico.send("commit", active=(1 << walls) - 1)
        assert pico.command("arm") == "ok"
        pico.run(5)
        health = pico.get("health")
        assert health["state"] == "armed"
        return int(health["tick_time_ns"])


if __name__ == "__main__":
    for board in MODELS:
        sizes = firmware_report.sizes(mcu.FIRMWARE / f"torsio-{board}.elf")
        instructions = {}
        for cost in mcu.costs(board):
            if cost.scene == "walls":
                instructions[cost.effects] = cost.instructions
            line = {
                "board": board,
                "scene": cost.scene,
                "effects": cost.effects,
                "instructions_per_tick": cost.instructions,
                "flash_bytes": sizes.flash,
                "ram_bytes": sizes.ram,
            }
            print(json.dumps(line))
        # The real binary; the emulated RP2350's cycles are estimates.
        choose(board)
        for walls in (0, 1, 4, 6):
            line = {
                "board": board,
                "scene": "walls",
                "effects": walls,
                "instructions_per_tick": instructions.get(walls),
                "flash_bytes": sizes.flash,
                "ram_bytes": sizes.ram,
                "tick_time_ns": tick_time_ns(walls),
            }
            print(json.dumps(line))
