"""Instructions for a tick on each board's processor, and the firmware's sizes, as JSON lines.

``./dev bench mcu`` prints a line for each scene: a number of walls, or one effect of a kind. The
Cortex-M33 of ``pico2`` is counted by QEMU, the Cortex-M0+ of ``pico`` by the emulated RP2040; both
count instructions, not cycles. ``control law`` is the same without the device round it.

These counts leave out the board's own work (encoder, current loop, PWM). It is in the
last lines of each board: there the real binary runs in the emulated chip, inside damped walls, and
tells in its health report how long its newest tick took, and its longest since it started, in which
it takes a scene while it is armed; null if it does not get done with so many. The RP2350's cycles
are estimates there.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median_low

from tests.board.pico import MODELS, choose, enumerated
from tests.mcu import mcu
from tools import firmware_report

OVERRUN = 1 << 4
WALLS = (0, 1, 4, 6, 7, 16)


@dataclass(frozen=True)
class TickTime:
    """How long the ticks of a board's binary take, as its health report has it."""

    usual_ns: int
    """In the middle of five that were looked at."""
    most_ns: int
    """Since the board started, with the one in which it takes them anew while it is armed."""


def tick_times(counts: Sequence[int] = WALLS) -> dict[int, TickTime | None]:
    """Tell of the chosen board inside so many damped walls; None: it cannot (``overrun``)."""
    found: dict[int, TickTime | None] = {}
    with enumerated() as pico:
        pico.set("control_config", passive_ramp_s=0.0)
        pico.turn(60)
        for walls in counts:
            damped = {"stiffness_nm_per_rad": 0.1, "damping_nm_s_per_rad": 1e-4}
            pico.arm_at_wall(walls, **damped)
            seen_ns = []
            for _ in range(5):
                pico.run(1)
                health = pico.get("health")
                seen_ns.append(health["tick_time_ns"])
            if health["state"] == "armed":
                pico.play_walls(walls, **damped)
                most_ns = pico.get("health")["tick_time_max_ns"]
                found[walls] = TickTime(median_low(seen_ns), most_ns)
                assert pico.command("disarm") == "ok"
            else:
                assert health["faults"] == OVERRUN
                found[walls] = None
                assert pico.command("clear_fault") == "ok"
    return found


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
        for walls, times in tick_times().items():
            line = {
                "board": board,
                "scene": "walls",
                "effects": walls,
                "instructions_per_tick": instructions.get(walls),
                "flash_bytes": sizes.flash,
                "ram_bytes": sizes.ram,
                "tick_time_ns": None if times is None else times.usual_ns,
                "tick_time_max_ns": None if times is None else times.most_ns,
            }
            print(json.dumps(line))
