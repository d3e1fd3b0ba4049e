"""The host benchmark prints what it promises. No bound on time: the machine may be busy."""

from __future__ import annotations

from tests.python.bench_lines import bench_lines


def test_bench_host_prints_a_line_per_command_and_per_sample() -> None:
    lines = bench_lines("host", "--commands", "50", "--seconds", "0.5", "--repeats", "2")
    assert [line["what"] for line in lines] == ["command", "telemetry_sample"]
    for line in lines:
        assert line["cpp_ns"] > 0
        assert line["python_ns"] > 0
        assert 0.01 < line["ratio"] < 1000
