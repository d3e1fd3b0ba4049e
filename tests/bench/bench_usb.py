"""The cost of the USB side, compared with raw hidapi: one JSON line each.

Round trips: a command that changes nothing (`disarm` of a disarmed knob) and its answer, by hidapi
in C, by the SDK in C++ and by the Python package, in turns. Telemetry: at 4,000 samples a second,
read in C++ and in Python; samples that are missing, and the CPU time of the whole reading process.
Loops of a program's own, with prompt telemetry of each tick: how old the newest sample is.

Without `--device` this boots a virtual machine and measures a virtual knob in its kernel. Time is
counted in instructions there, 1 ns each, so that the figures do not depend on what else the
computer does. With `--device PATH` it measures a knob that is plugged into this computer, by the
clock; `--device virtual` plugs in a virtual one, which needs root and the module vhci_hcd.

Keys: `benchmark` "usb"; `what` "round_trip", "telemetry" or "loop"; `client` "raw", "cpp" or
"python"; `kernel` its release; `time` "instructions" or "clock". A round trip has `median_ms`,
`p99_ms`, `trips`, and, except for raw, `median_ratio` and `p99_ratio` to raw with
`goal_median_ratio`. Telemetry has `rate_hz`, `duration_s`, `samples`, `samples_lost` (missing
between those that were read), `samples_dropped` (by the knob, also between the last read and the
end of the stream), `reader_cpu_s`, `reader_cpu_share` (CPU seconds a second) and
`goal_samples_lost`. A loop has `rate_hz` of its samples, `period_ms` of its steps, `steps`,
`late_steps`, `age_median_ms`, `age_p99_ms`, `goal_age_p99_ms` (a frame and a tick), and
`age_error_ms`, how far off the two clocks may be.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import platform
import shlex
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import torsio
from tests.vm import guests
from tests.vm.guest.virtual_bus import VirtualKnob
from tests.vm.machine import GuestFailed, Machine

TREE = Path(__file__).parents[2]

KERNEL = "6.12"
LIMIT_S = 3600.0  # a busy host may take its time
GOAL_MEDIAN_RATIO = {"cpp": 1.05, "python": 1.3}
WARM_UP = 20
# At 1 kHz all steps lie at one moment of their frames; the other goes through all.
LOOP_PERIODS_S = (0.001, 0.00101)


def _run(*command: object) -> str:
    result = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, text=True)
    if result.returncode != 0:
        sys.exit(result.returncode)  # it has said why
    return result.stdout


def raw_trips_s(programs: Path, path: str, trips: int) -> list[float]:
    """Time round trips in C, without the SDK."""
    return [float(word) for word in _run(programs / "bench_usb_raw", path, WARM_UP, trips).split()]


def cpp_trips_s(programs: Path, path: str, trips: int) -> list[float]:
    """Time round trips in C++."""
    return [
        float(word) for word in _run(programs / "bench_usb", "trips", path, WARM_UP, trips).split()
    ]


def python_trips_s(_: Path, path: str, trips: int) -> list[float]:
    """Time round trips in Python."""
    times_s = []
    with torsio.open(path, command_timeout_s=5.0) as knob:
        for _n in range(WARM_UP + trips):
            begin = time.perf_counter()
            knob.disarm()
            times_s.append(time.perf_counter() - begin)
    return times_s[WARM_UP:]


def cpp_telemetry(
    programs: Path, path: str, rate_hz: float, duration_s: float
) -> tuple[int, int, float, float]:
    """Read telemetry in C++: samples, samples missing, seconds, CPU seconds."""
    words = _run(programs / "bench_usb", "telemetry", path, rate_hz, duration_s).split()
    return int(words[0]), int(words[1]), float(words[2]), float(words[3])


def python_telemetry(
    _: Path, path: str, rate_hz: float, duration_s: float
) -> tuple[int, int, float, float]:
    """Read telemetry in Python, as `cpp_telemetry`."""
    ticks: list[Any] = []
    with torsio.open(path, command_timeout_s=5.0) as knob:
        step = round(knob.info.control_rate_hz / knob.start_telemetry(rate_hz=rate_hz))
        cpu_begin, begin = time.process_time(), time.monotonic()
        while time.monotonic() - begin < duration_s:
            ticks.append(knob.read()["tick"].copy())
        elapsed_s, cpu_s = time.monotonic() - begin, time.process_time() - cpu_begin
        knob.stop_telemetry()  # samples from here on are not lost
    all_ticks = np.concatenate(ticks)
    missing = int(np.sum(np.diff(all_ticks.astype(np.int64)) // step - 1))
    return len(all_ticks), missing, elapsed_s, cpu_s


@dataclass(frozen=True)
class Ages:
    """How old the newest sample was in each step of a loop.

    Attributes
    ----------
    ages_s
        By this computer's clock.
    error_s
        How far off that may be: the device has a clock of its own.
    late_steps
        That were left out.
    """

    ages_s: list[float]
    error_s: float
    late_steps: int


def cpp_loop(programs: Path, path: str, rate_hz: float, period_s: float, steps: int) -> Ages:
    """Run a loop in C++."""
    words = _run(programs / "bench_usb", "loop", path, rate_hz, period_s, steps).split()
    error_s, late, *ages = words
    return Ages([float(age) for age in ages], float(error_s), int(late))


def _offset(knob: torsio.Knob) -> tuple[float, float]:
    """How far off the other may be, and seconds of this clock less the device's; as in C++."""
    found = []
    for _ in range(50):
        before = time.perf_counter()
        device_s = knob.clock().time_s
        error_s = 0.5 * (time.perf_counter() - before)
        found.append((error_s, before + error_s - device_s))
    return min(found, key=sum)


def python_loop(_: Path, path: str, rate_hz: float, period_s: float, steps: int) -> Ages:
    """Run a loop in Python."""
    ages_s: list[float] = []
    with torsio.open(path, command_timeout_s=5.0) as knob:
        knob.start_telemetry(rate_hz=rate_hz, prompt=True)
        knob.latest()
        error_s, offset_s = _offset(knob)
        late_steps = 0
        for step in knob.every(period_s):
            late_steps = step.late_steps
            newest_s = float(knob.latest()["time_s"])
            ages_s.append(time.perf_counter() - offset_s - newest_s)
            if len(ages_s) == steps:
                break
        error_s += abs(_offset(knob)[1] - offset_s)
    return Ages(ages_s, error_s, late_steps)


def loop_line(client: str, rate_hz: float, period_s: float, found: Ages) -> dict[str, Any]:
    """Summarise a loop."""
    return {
        "benchmark": "usb",
        "what": "loop",
        "client": client,
        "rate_hz": rate_hz,
        "period_ms": round(1e3 * period_s, 3),
        "steps": len(found.ages_s),
        "late_steps": found.late_steps,
        "age_median_ms": round(1e3 * statistics.median(found.ages_s), 3),
        "age_p99_ms": round(1e3 * float(np.percentile(found.ages_s, 99)), 3),
        "goal_age_p99_ms": round(1.0 + 1e3 / rate_hz, 3),
        "age_error_ms": round(1e3 * found.error_s, 3),
    }


def round_trip_lines(times_s: dict[str, list[float]]) -> Iterator[dict[str, Any]]:
    """Summarise round trips, one line a client; `raw` is what the others are compared with."""
    figures = {
        client: (statistics.median(all_s), float(np.percentile(all_s, 99)))
        for client, all_s in times_s.items()
    }
    raw_median_s, raw_p99_s = figures["raw"]
    for client, (median_s, p99_s) in figures.items():
        line = {
            "benchmark": "usb",
            "what": "round_trip",
            "client": client,
            "median_ms": round(1e3 * median_s, 4),
            "p99_ms": round(1e3 * p99_s, 4),
            "trips": len(times_s[client]),
        }
        if client != "raw":
            line |= {
                "median_ratio": round(median_s / raw_median_s, 3),
                "p99_ratio": round(p99_s / raw_p99_s, 3),
                "goal_median_ratio": GOAL_MEDIAN_RATIO[client],
            }
        yield line


def measure(arguments: argparse.Namespace) -> Iterator[dict[str, Any]]:
    """Measure a knob that is plugged in."""
    path, programs = arguments.device, arguments.programs
    clients = {"raw": raw_trips_s, "cpp": cpp_trips_s, "python": python_trips_s}
    times_s: dict[str, list[float]] = {client: [] for client in clients}
    for _ in range(arguments.rounds):
        for client, run in clients.items():
            times_s[client] += run(programs, path, arguments.trips)
    where = {"kernel": platform.release(), "time": "clock"}
    for line in round_trip_lines(times_s):
        yield line | where

    for client, read in (("cpp", cpp_telemetry), ("python", python_telemetry)):
        dropped = _dropped(path)
        samples, lost, duration_s, cpu_s = read(
            programs, path, arguments.rate_hz, arguments.seconds
        )
        yield {
            "benchmark": "usb",
            "what": "telemetry",
            "client": client,
            "rate_hz": arguments.rate_hz,
            "duration_s": round(duration_s, 3),
            "samples": samples,
            "samples_lost": lost,
            "samples_dropped": _dropped(path) - dropped,
            "reader_cpu_s": round(cpu_s, 4),
            "reader_cpu_share": round(cpu_s / duration_s, 4),
            "goal_samples_lost": 0,
            **where,
        }
    with torsio.open(path) as knob:
        control_rate_hz = knob.info.control_rate_hz
    for client, loop in (("cpp", cpp_loop), ("python", python_loop)):
        for period_s in LOOP_PERIODS_S:
            found = loop(programs, path, control_rate_hz, period_s, arguments.steps)
            yield loop_line(client, control_rate_hz, period_s, found) | where


def _dropped(path: str) -> int:
    with torsio.open(path) as knob:
        return knob.health().samples_dropped


@contextlib.contextmanager
def virtual_knob(rate_hz: float) -> Iterator[str]:
    """Plug a virtual knob into this computer, and give its path."""
    knob = VirtualKnob("BENCH", round(rate_hz), "free")
    try:
        knob.plug()
        yield str(knob.hidraw)
    finally:
        knob.end()


def measure_in_virtual_machine(words: list[str]) -> Iterator[dict[str, Any]]:
    """Measure in a virtual machine, with these words on the command line."""
    share = guests.share("bench")
    share.mkdir(parents=True, exist_ok=True)
    run = shlex.join([sys.executable, "-m", "tests.bench.bench_usb", *words])
    machine = Machine(guests.KERNELS / KERNEL, share, emulated=True)
    machine.run(
        f"""\
export HOME=/tmp PATH=/usr/sbin:/usr/bin:/sbin:/bin
export LD_LIBRARY_PATH={shlex.quote(os.environ.get("LD_LIBRARY_PATH", ""))}
cd {shlex.quote(str(TREE))} && {run} >/torsio-share/lines
""",
        limit_s=LIMIT_S,
    )
    for line in (share / "lines").read_text().splitlines():
        yield json.loads(line) | {"time": "instructions"}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--device", help="path of a knob, see `torsio list`, or `virtual`")
    parser.add_argument("--rounds", type=int, default=5, help="turns of the three clients")
    parser.add_argument("--trips", type=int, default=400, help="round trips of a client in a turn")
    parser.add_argument("--rate-hz", type=float, default=4000.0, help="samples a second")
    parser.add_argument("--seconds", type=float, default=60.0, help="length of the telemetry")
    parser.add_argument("--steps", type=int, default=5000, help="steps of a loop")
    parser.add_argument("--programs", type=Path, default=TREE / "build/release/tests/bench")
    arguments = parser.parse_args()
    if arguments.device is None:
        try:
            for line in measure_in_virtual_machine(["--device", "virtual", *sys.argv[1:]]):
                print(json.dumps(line), flush=True)
        except GuestFailed as failure:
            sys.exit(f"bench_usb: {failure}")
        return
    with contextlib.ExitStack() as stack:
        if arguments.device == "virtual":
            arguments.device = stack.enter_context(virtual_knob(arguments.rate_hz))
        for line in measure(arguments):
            print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
