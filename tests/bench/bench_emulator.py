"""The cost of the emulated device in CPU time of one core: one JSON line each.

The whole device in closed loop at 1 and 10 kHz with a wall, a hand and telemetry; plant and law
alone in a loop, where each waits for the other; its parts alone, fed with what they were fed there,
for which nothing waits; the plant with and without the parts that a scene may name; and a command,
`play` of a wall in Python. Lines with an aim have it as `goal_...`.
The numbers are the least of several repeats, in turns.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import timeit
from pathlib import Path
from typing import Any

import torsio

TREE = Path(__file__).parents[2]
GOAL_REALTIME_FACTOR = 2000  # the whole device at 10 kHz
GOAL_PLAY_US = 3.0
_PLAYS = 300


def measure(program: Path, seconds: float, repeats: int) -> list[dict[str, Any]]:
    """Run the C++ half; one dict a measurement."""
    result = subprocess.run(
        [program, str(seconds), str(repeats)], capture_output=True, text=True, check=True
    )
    return [json.loads(line) for line in result.stdout.splitlines()]


def summarise(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Put each control rate's measurements into one line, and savings into another."""
    lines: list[dict[str, Any]] = []
    for rate_hz in sorted({row["control_rate_hz"] for row in rows}):
        at_rate = [row for row in rows if row["control_rate_hz"] == rate_hz]

        def ns(kind: str, name: str, at_rate: list[dict[str, Any]] = at_rate) -> float:
            return next(
                float(row["ns_per_tick"])
                for row in at_rate
                if row["kind"] == kind and row["name"] == name
            )

        total = ns("device", "all")
        control = ns("part", "control")
        protocol = max(0.0, ns("part", "control_and_protocol") - control)
        plant, encoder = ns("part", "plant"), ns("part", "encoder")
        line = {
            "benchmark": "emulator",
            "what": "device",
            "control_rate_hz": rate_hz,
            "realtime_factor": round(1e9 / rate_hz / total),
            "ns_per_tick": round(total, 1),
            "ns_per_tick_of_plant_and_law_in_a_loop": ns("loop", "plant_and_law"),
            "ns_per_tick_by_part": {
                "plant": round(plant, 1),
                "control": round(control, 1),
                "protocol": round(protocol, 1),
                "encoder": round(encoder, 1),
                "clock_cable_and_host": round(total - plant - control - protocol - encoder, 1),
            },
        }
        if rate_hz == 10_000:
            line["goal_realtime_factor"] = GOAL_REALTIME_FACTOR
        lines.append(line)
        everything = ns("plant", "all_parts")
        for row in at_rate:
            if row["kind"] == "plant":
                lines.append(
                    {
                        "benchmark": "emulator",
                        "what": "plant",
                        "parts": row["name"],
                        "control_rate_hz": rate_hz,
                        "states": row["states"],
                        "ns_per_tick": row["ns_per_tick"],
                        "saved_of_all_parts": round(1.0 - row["ns_per_tick"] / everything, 3),
                    }
                )
    return lines


def play_us(repeats: int) -> float:
    """Give the time that a program waits for `play` of a wall."""
    wall = torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=1.0)
    with torsio.open("emulated") as knob:
        least_s = min(timeit.repeat(lambda: knob.play(wall), number=_PLAYS, repeat=5 * repeats))
    return round(1e6 * least_s / _PLAYS, 2)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=8.0, help="simulated seconds of a repeat")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument(
        "--program", type=Path, default=TREE / "build/release/tests/bench/bench_emulator"
    )
    arguments = parser.parse_args()
    for line in summarise(measure(arguments.program, arguments.seconds, arguments.repeats)):
        print(json.dumps(line))
    play = {"benchmark": "emulator", "what": "play", "us": play_us(arguments.repeats)}
    print(json.dumps({**play, "goal_us": GOAL_PLAY_US}))


if __name__ == "__main__":
    main()
