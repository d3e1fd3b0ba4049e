"""The benchmarks: which there are, and what each needs to be built."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from typing import NoReturn

from tools.dev import building, environment
from tools.dev.environment import PYTHON
from tools.dev.running import TREE, UsageError, become, lock, say


def benchmarks() -> dict[str, str]:
    """Return the benchmarks' modules by their names."""
    files = [*TREE.glob("tests/bench/bench_*.py"), *TREE.glob("tests/studies/bench_*.py")]
    names = {file.stem.removeprefix("bench_"): f"tests.{file.parent.name}" for file in files}
    return {name: f"{names[name]}.bench_{name}" for name in sorted(names)}


def bench(arguments: Sequence[str]) -> int:
    """Run a benchmark, or list them."""
    if not arguments or not arguments[0]:
        say("benchmarks, each run with ./dev bench NAME:")
        print(*(f"  {name}" for name in benchmarks()), sep="\n")
        return 0
    return _bench(*arguments)


def _bench(name: str, *rest: str) -> NoReturn:
    if name not in benchmarks():
        raise UsageError(f"no benchmark '{name}'")
    # Without a knob to measure it takes a virtual one, in a virtual machine.
    with_machines = name == "usb" and "--device" not in rest
    on_boards = name in ("binary", "calibration", "guards", "mcu")
    groups = ["tests"]
    groups += ["firmware"] if on_boards else []
    groups += ["machines"] if with_machines else []
    # Only the benchmark's own lines go to standard output, so that they can be piped.
    with redirect_stdout(sys.stderr), lock():
        sources = building.FirmwareSources()
        kernels = building.begin_fetching_kernels() if with_machines else None
        environment.set_up(*groups)
        if on_boards:
            board = building.begin_npm("tests/board")
            building.build_firmware(sources.require())
            if name == "guards":
                building.build_unguarded(sources.sdk)
            building.build_emulated()
            board.result()
        elif with_machines:
            sources.require()
        if name not in ("mcu", "change"):
            tinyusb = sources.offer()
            if not on_boards:
                building.build_preset("release", tinyusb)
            building.build_packages(tinyusb)
        if kernels is not None:
            kernels.result()
    become(PYTHON, "-m", benchmarks()[name], *rest)
