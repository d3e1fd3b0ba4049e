"""The cost of the host side, in C++ and in Python.

Per command: play a wall, that is encode its reports, run the emulated device until it has
answered, decode the answers. Per sample: record telemetry, that is run the emulated device for a
tick, encode, decode and hand over one sample. Both languages do the same work on the same emulated
knob, in turns; the numbers are medians over the repeats. One JSON line each.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import time
from pathlib import Path

import torsio

TREE = Path(__file__).parents[2]


def run_cpp(program: Path, commands: int, duration_s: float) -> tuple[float, float]:
    """Run one repeat in C++; nanoseconds per command and per sample."""
    result = subprocess.run(
        [program, str(commands), str(duration_s)], capture_output=True, text=True, check=True
    )
    command_ns, sample_ns = map(float, result.stdout.split())
    return command_ns, sample_ns


def _command_ns(knob: torsio.Knob, commands: int) -> float:
    begin = time.perf_counter()
    for n in range(commands):
        knob.play(torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.0 + 1e-4 * n))
    return (time.perf_counter() - begin) / commands * 1e9


def run_python(commands: int, duration_s: float) -> tuple[float, float]:
    """Run one repeat in Python; nanoseconds per command and per sample."""
    with torsio.open("emulated") as knob:
        knob.arm()
        _command_ns(knob, 100)  # warm up
        command_ns = _command_ns(knob, commands)
        knob.start_telemetry()
        begin = time.perf_counter()
        log = knob.record(duration_s=duration_s)
        sample_ns = (time.perf_counter() - begin) / len(log) * 1e9
    return command_ns, sample_ns


def main() -> None:
    """Take turns and print the medians."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--commands", type=int, default=2000, help="commands of a repeat")
    parser.add_argument("--seconds", type=float, default=20.0, help="recorded seconds of a repeat")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument(
        "--program", type=Path, default=TREE / "build/release/tests/bench/bench_host"
    )
    arguments = parser.parse_args()

    cpp, python = [], []
    for _ in range(arguments.repeats):
        cpp.append(run_cpp(arguments.program, arguments.commands, arguments.seconds))
        python.append(run_python(arguments.commands, arguments.seconds))
    for what, index in (("command", 0), ("telemetry_sample", 1)):
        cpp_ns = statistics.median(row[index] for row in cpp)
        python_ns = statistics.median(row[index] for row in python)
        line = {
            "benchmark": "host",
            "what": what,
            "cpp_ns": round(cpp_ns, 1),
            "python_ns": round(python_ns, 1),
            "ratio": round(python_ns / cpp_ns, 3),
            "repeats": arguments.repeats,
        }
        print(json.dumps(line))


if __name__ == "__main__":
    main()
