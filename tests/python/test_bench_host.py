"""The host benchmark prints what it promises. No bound on time: the machine may be busy."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

TREE = Path(__file__).parents[2]


def test_bench_host_prints_a_line_per_command_and_per_sample() -> None:
    # The test suite builds the dev preset; `./dev bench` takes the release build.
    program = TREE / "build" / "release" / "tests" / "bench" / "bench_host"
    result = subprocess.run(
        [
            *(sys.executable, "tests/bench/bench_host.py", "--program", str(program)),
            *("--commands", "50", "--seconds", "0.5", "--repeats", "2"),
        ],
        cwd=TREE,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    assert [line["what"] for line in lines] == ["command", "telemetry_sample"]
    for line in lines:
        assert line["cpp_ns"] > 0
        assert line["python_ns"] > 0
        assert 0.01 < line["ratio"] < 1000
