"""The benchmark of many knobs prints what it promises. No bound on time: machines are busy."""

from __future__ import annotations

import json
import subprocess
import sys

from tests.python.bench_lines import TREE


def test_bench_batch_prints_a_line_for_each_measurement() -> None:
    program = [sys.executable, str(TREE / "tests/bench/bench_batch.py")]
    little = ["--knobs", "8", "--ticks", "20", "--repeats", "1"]
    result = subprocess.run(program + little, capture_output=True, text=True, check=True, cwd=TREE)
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    assert {line["benchmark"] for line in lines} == {"batch"}
    what = [line["what"] for line in lines]
    assert what[:5] == [
        "ticks, one loop by itself",
        "ticks, same plant",
        "ticks, a plant of their own",
        "steps of 1 ms with an action",
        "steps of 1 ms of RenderWall in Gymnasium",
    ]
    assert set(what[5:]) <= {"ticks, threads, long steps", "ticks, threads, steps of one tick"}
    assert all(min(line["scaling"], line["processor_scaling"]) > 0 for line in lines[5:])
    assert all(line["per_s"] > 0 for line in lines)
