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


@pytest.mark.parametrize(
    "command",
    [
        (str(PROGRAMS / "bench_usb_raw"), "/dev/hidraw250", "1", "1"),
        (str(PROGRAMS / "bench_usb"), "trips", "/dev/hidraw250", "1", "1"),
        (str(PROGRAMS / "bench_usb"), "telemetry", "/dev/hidraw250", "4000", "1"),
        (sys.executable, "tests/bench/bench_usb.py", "--device", "/dev/hidraw250"),
    ],
)
def test_device_that_is_not_there_is_one_sentence_and_status_1(command: tuple[str, ...]) -> None:
    result = subprocess.run(command, cwd=TREE, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert result.stdout == ""
    assert len(result.stderr.splitlines()) == 1
    assert "/dev/hidraw250" in result.stderr
