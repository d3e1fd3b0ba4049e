"""Let each thing fail once, and look whether the torque goes off and what is kept.

``./dev faults`` runs all parts, ``./dev faults close files`` one call and a part. With
``--every N`` each N-th place fails instead of each. At the end a table says how many there were, by
call and kind, and how many left something wrong.

calls         an exception at each line that runs in a call of a knob, in virtual and in paced time
calibration   the same in a calibration, whose configuration must be put back
update        the same in a firmware update
thread        the same in the thread that writes a recording's file
transport     each write and each read of a transport fails, is cut short, or gives nonsense
files         each operation on a file fails: recordings, configurations, reports, firmware
allocations   each allocation of the example program in C fails
"""

from __future__ import annotations

import argparse
import faulthandler
import gc
import itertools
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from tests.faults import cables, calls
from tests.faults.lines import RAISED, Injection

TREE = Path(__file__).parents[2]
# So long nothing of it takes: it hangs. All files are one step.
HANGS_S = 1200.0

Outcome = tuple[str, str, str, str]
"""Call, kind, what is wrong or "", and where."""


def of_calls(every: int, names: Iterable[str] = tuple(calls.CALLS)) -> Iterator[Outcome]:
    """Raise at each line of each call."""
    for call in names:
        for paced in (False, True):
            for recorded in (False, True):
                lines = calls.lines_of(call, paced=paced, recorded=recorded)
                for kind in calls.kinds_of(call):
                    for at in range(0, lines, every):
                        wrong, injection = calls.trial(
                            call, at, kind, paced=paced, recorded=recorded
                        )
                        time = "paced" if paced else "virtual"
                        yield call, kind.__name__, wrong, f"{time}: {injection.where}"


def of_calibration(every: int) -> Iterator[Outcome]:
    """Raise at lines of a calibration."""
    _, counted = calls.interrupt_calibration(None, KeyboardInterrupt)
    # Each line where it configures the knob and restores it, some of the lines between.
    places = [*range(150), *range(150, counted.lines - 150, 200)]
    places += range(counted.lines - 150, counted.lines)
    for kind in RAISED:
        for at in places[::every]:
            wrong, injection = calls.interrupt_calibration(at, kind)
            yield "calibrate", kind.__name__, wrong, str(injection.where)


def of_update(every: int) -> Iterator[Outcome]:
    """Raise at each line of a firmware update."""
    return _each_line("update_firmware", calls.interrupt_update, RAISED, every)


def of_thread(every: int) -> Iterator[Outcome]:
    """Raise at each line of the thread that writes a recording's file."""
    return _each_line("recording's thread", calls.interrupt_thread, RAISED[1:], every)


def _each_line(
    what: str,
    trial: Callable[[int, type[BaseException]], tuple[str, Injection]],
    kinds: Iterable[type[BaseException]],
    every: int,
) -> Iterator[Outcome]:
    for kind in kinds:
        for at in itertools.count(0, every):
            wrong, injection = trial(at, kind)
            if injection.where is None:
                break
            yield what, kind.__name__, wrong, injection.where


def _library(folder: Path) -> Path:
    library = folder / "failing.so"
    options = ("-std=gnu11", "-Wall", "-Wextra", "-Werror", "-O1", "-shared", "-fPIC")
    source = TREE / "tests/faults/failing.c"
    subprocess.run(["gcc", *options, source, "-o", library, "-ldl"], check=True)
    return library


def of_files(every: int, *names: str) -> Iterator[Outcome]:
    """Let each operation on a file fail; all of ``files.py`` if none is named."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "LD_PRELOAD": str(_library(Path(folder)))}
        done = subprocess.run(
            [sys.executable, "-m", "tests.faults.files", str(every), *names],
            env=environment, cwd=TREE, capture_output=True, text=True, check=False,
        )  # fmt: skip
        for line in done.stdout.splitlines():
            call, kind, wrong, where = json.loads(line)
            yield call, kind, wrong, where
        if done.returncode != 0:
            yield "files", "the process", done.stderr.strip()[-500:], "its end"


def _example(folder: Path) -> tuple[Path, dict[str, str]]:
    """Build the example program in C against the library as it is installed."""
    build, prefix = TREE / "build/release", folder / "installed"
    subprocess.run(
        ["cmake", "--install", build, "--prefix", prefix, "--component", "c"],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    found = subprocess.run(
        ["pkg-config", "--cflags", "--libs", "torsio-c"],
        env={**os.environ, "PKG_CONFIG_PATH": str(prefix / "lib/pkgconfig")},
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    program = folder / "feel_a_wall"
    source = TREE / "examples/c/feel_a_wall.c"
    subprocess.run(["gcc", source, "-o", program, *found.stdout.split()], check=True)
    return program, {
        **os.environ,
        "LD_LIBRARY_PATH": str(prefix / "lib"),
        "LD_PRELOAD": str(_library(folder)),
        "FAIL_COUNT": str(folder / "count"),
    }


def of_allocations(every: int) -> Iterator[Outcome]:
    """Let each allocation of the example program in C fail."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        program, environment = _example(folder)
        subprocess.run([program], env=environment, check=True, stdout=subprocess.DEVNULL)
        count = int((folder / "count").read_text())
        for at in range(0, count, every):
            done = subprocess.run(
                [program],
                env={**environment, "FAIL_ALLOCATION": str(at)},
                capture_output=True, text=True, timeout=HANGS_S, check=False,
            )  # fmt: skip
            wrong = "" if done.returncode in (0, 1) else f"ended with {done.returncode}"
            if done.returncode == 1 and not done.stderr.strip():
                wrong = "failed without a word"
            yield "example in C", "no memory", wrong, f"allocation {at}: {done.stderr.strip()}"


PARTS: dict[str, Callable[[int], Iterator[Outcome]]] = {
    "calls": of_calls,
    "calibration": of_calibration,
    "update": of_update,
    "thread": of_thread,
    "transport": cables.trials,
    "files": of_files,
    "allocations": of_allocations,
}


def run(part: str, every: int) -> tuple[Counter[tuple[str, str]], list[Outcome]]:
    """Run a part; give how many injections there were by call and kind, and those that failed."""
    counts: Counter[tuple[str, str]] = Counter()
    failed: list[Outcome] = []
    faulthandler.dump_traceback_later(HANGS_S, exit=True)
    outcomes = PARTS[part](every) if part in PARTS else of_calls(every, [part])
    for outcome in outcomes:
        faulthandler.dump_traceback_later(HANGS_S, exit=True)
        counts[outcome[:2]] += 1
        if counts.total() % 100 == 0:
            gc.collect()  # exceptions may still hold knobs
        if outcome[2]:
            failed.append(outcome)
    faulthandler.cancel_dump_traceback_later()
    return counts, failed


def table(counts: Counter[tuple[str, str]], failed: list[Outcome]) -> str:
    """Give a row for each call and kind."""
    bad = Counter(outcome[:2] for outcome in failed)
    rows = [("call", "kind", "injections", "failed")]
    rows += [(*key, f"{counts[key]:,}", f"{bad[key]:,}") for key in counts]
    rows.append(("all", "", f"{counts.total():,}", f"{len(failed):,}"))
    widths = [max(len(row[column]) for row in rows) for column in range(4)]
    return "\n".join(
        f"{call:<{widths[0]}}  {kind:<{widths[1]}}  {n:>{widths[2]}}  {m:>{widths[3]}}"
        for call, kind, n, m in rows
    )


def main() -> int:
    """Run what the command line says."""
    parser = argparse.ArgumentParser(
        prog="./dev faults", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("parts", metavar="PART", nargs="*", choices=[*PARTS, *calls.CALLS, []])
    parser.add_argument("--every", metavar="N", type=int, default=1)
    options = parser.parse_args()
    counts: Counter[tuple[str, str]] = Counter()
    failed: list[Outcome] = []
    for part in options.parts or PARTS:
        of_part, wrong = run(part, max(options.every, 1))
        counts += of_part
        failed += wrong
    for call, kind, wrong_how, where in failed:
        print(f"{call}, {kind}: {wrong_how} ({where})")
    print(table(counts, failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
