"""The USB benchmark runs, in short; what it measures here means nothing."""

from __future__ import annotations

import argparse

import pytest

from tests.bench import bench_usb

RATE_HZ = 1000.0


@pytest.mark.whole
@pytest.mark.kernel("6.1")
def test_benchmark_measures_a_virtual_knob() -> None:
    with bench_usb.virtual_knob(RATE_HZ) as path:
        arguments = argparse.Namespace(
            device=path,
            programs=bench_usb.TREE / "build/release/tests/bench",
            rounds=1,
            trips=5,
            rate_hz=RATE_HZ,
            seconds=0.5,
            steps=50,
        )
        lines = list(bench_usb.measure(arguments))
    assert [(line["what"], line["client"]) for line in lines] == [
        ("round_trip", "raw"),
        ("round_trip", "cpp"),
        ("round_trip", "python"),
        ("telemetry", "cpp"),
        ("telemetry", "python"),
        ("loop", "cpp"),
        ("loop", "cpp"),
        ("loop", "python"),
        ("loop", "python"),
    ]
    for line in lines[:3]:
        assert line["trips"] == 5
        # No report moves twice in a frame, so no answer is there in less than one.
        assert line["p99_ms"] > 1.0
    for line in lines[3:5]:
        assert line["samples"] > 0
        assert {"samples_lost", "samples_dropped", "reader_cpu_s"} <= set(line)
    for line in lines[5:]:
        assert line["steps"] == 50
        # No sample is there before it was taken.
        assert line["age_median_ms"] > -line["age_error_ms"]
