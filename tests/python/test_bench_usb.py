"""The USB benchmark without a knob: how it counts, and that it fails in one sentence."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.bench import bench_usb

TREE = Path(__file__).parents[2]
# `./dev bench` and the test suite both build the release preset.
PROGRAMS = TREE / "build" / "release" / "tests" / "bench"


def test_round_trips_are_compared_with_raw_hidapi() -> None:
    # 1 ... 101 ms raw; a tenth more in C++, twice as much in Python.
    raw_s = [n * 1e-3 for n in range(1, 102)]
    lines = bench_usb.round_trip_lines(
        {
            "raw": raw_s,
            "cpp": [1.1 * time_s for time_s in raw_s],
            "python": [2.0 * time_s for time_s in raw_s],
        }
    )
    raw, cpp, python = lines
    assert raw == {
        "benchmark": "usb",
        "what": "round_trip",
        "client": "raw",
        "median_ms": 51.0,
        "p99_ms": 100.0,
        "trips": 101,
    }
    assert (cpp["median_ratio"], cpp["p99_ratio"], cpp["goal_median_ratio"]) == (1.1, 1.1, 1.05)
    assert (python["median_ratio"], python["goal_median_ratio"]) == (2.0, 1.3)


def test_loop_is_held_to_a_frame_and_the_distance_of_two_samples() -> None:
    ages = bench_usb.Ages([n * 1e-5 for n in range(101)], error_s=2e-4, late_steps=3)
    line = bench_usb.loop_line("cpp", 2000.0, 0.001, ages)
    assert (line["age_median_ms"], line["age_p99_ms"], line["goal_age_p99_ms"]) == (0.5, 0.99, 1.5)
    assert (line["steps"], line["late_steps"], line["age_error_ms"]) == (101, 3, 0.2)


@pytest.mark.parametrize(
    "command",
    [
        (str(PROGRAMS / "bench_usb_raw"), "/dev/hidraw250", "1", "1"),
        (str(PROGRAMS / "bench_usb"), "trips", "/dev/hidraw250", "1", "1"),
        (str(PROGRAMS / "bench_usb"), "telemetry", "/dev/hidraw250", "4000", "1"),
        (str(PROGRAMS / "bench_usb"), "loop", "/dev/hidraw250", "1000", "0.001", "1"),
        (sys.executable, "tests/bench/bench_usb.py", "--device", "/dev/hidraw250"),
    ],
)
def test_device_that_is_not_there_is_one_sentence_and_status_1(command: tuple[str, ...]) -> None:
    result = subprocess.run(command, cwd=TREE, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert result.stdout == ""
    assert len(result.stderr.splitlines()) == 1
    assert "/dev/hidraw250" in result.stderr
