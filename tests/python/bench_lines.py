"""What the benchmarks with a C++ half print."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

TREE = Path(__file__).parents[2]


def bench_lines(name: str, *arguments: str) -> list[dict[str, Any]]:
    """Run a benchmark of the release build and give the lines that it prints."""
    program = TREE / "build" / "release" / "tests" / "bench" / f"bench_{name}"
    result = subprocess.run(
        [
            *(sys.executable, f"tests/bench/bench_{name}.py", "--program", str(program)),
            *arguments,
        ],
        cwd=TREE,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    return [json.loads(line) for line in result.stdout.splitlines()]
