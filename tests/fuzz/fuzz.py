"""Fuzz targets for as long as one likes, and which of the project's own code they reach.

``./dev fuzz [TARGET...] [SECONDS]`` runs the targets of this folder, guided by the code that they
reach. An input that reaches new code is kept in ``build/fuzz-corpus`` and used again. ``--keep``
adds the fewest inputs that reach all of it to ``tests/fuzz/corpus``. An input that fails is in
``build/fuzz_last_input_...``, and the program that is named runs it again.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

TREE = Path(__file__).parent.parent.parent
HERE = Path(__file__).parent
PROGRAMS = TREE / "build/fuzz/tests/fuzz"
FOUND = TREE / "build/fuzz-corpus"
OWN = ("firmware/", "emulator/", "sdk/")
TRACE = "__sanitizer_cov_trace_pc"
STEP = 4  # places are told to so many bytes; see driver.cpp


def targets() -> list[str]:
    """Return the names of all targets."""
    return sorted(path.stem.removeprefix("fuzz_") for path in HERE.glob("fuzz_*.cpp"))


@dataclass
class Result:
    """The result of one target."""

    target: str
    status: int
    summary: str
    lines: dict[str, dict[str, set[int]]] = field(default_factory=dict)  # all and reached, by file


def run_target(target: str, seconds: float, seed: int) -> Result:
    """Run one target, and look at what it reached."""
    program = PROGRAMS / f"fuzz_{target}"
    found = FOUND / target
    found.mkdir(parents=True, exist_ok=True)
    corpus = FOUND / f"{target}.all"
    shutil.rmtree(corpus, ignore_errors=True)
    shutil.copytree(HERE / "corpus" / target, corpus)
    for path in found.iterdir():
        shutil.copy2(path, corpus)
    reached = FOUND / f"{target}.reached"
    command: list[str | Path] = [program, corpus, "--seconds", str(seconds), "--seed", str(seed)]
    command += ["--keep", found, "--reached", reached]
    ended = subprocess.run(command, cwd=TREE / "build", capture_output=True, text=True, check=False)
    shutil.rmtree(corpus)
    summary = ended.stdout.strip() if ended.returncode == 0 else ended.stderr.strip()
    result = Result(target, ended.returncode, summary)
    if ended.returncode == 0:
        places = {int(line, 16) for line in reached.read_text().split()}
        result.lines = lines_of(program, places)
    return result


def lines_of(program: Path, reached: set[int]) -> dict[str, dict[str, set[int]]]:
    """Return the lines of own code that begin a block, by file: all of them, and those reached."""
    listing = subprocess.run(
        ["objdump", "-d", "--no-show-raw-insn", program], capture_output=True, text=True, check=True
    ).stdout
    places: list[int] = []
    behind = False
    for line in listing.splitlines():
        if match := re.match(r"\s+([0-9a-f]+):\t(.*)", line):
            if behind:
                places.append(int(match[1], 16))
            behind = TRACE in match[2] and match[2].startswith("call")
    names = subprocess.run(
        ["addr2line", "-e", program],
        # The call itself, not the place that it returns to.
        input="\n".join(hex(place - 1) for place in places),
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    files: dict[str, dict[str, set[int]]] = {}
    for place, name in zip(places, names, strict=True):
        path, _, number = name.partition(":")
        digits = re.match(r"\d+", number)
        path = os.path.normpath(path)
        if digits is None or not path.startswith(f"{TREE}/"):
            continue
        own = path.removeprefix(f"{TREE}/")
        if not own.startswith(OWN):
            continue
        entry = files.setdefault(own, {"all": set(), "reached": set()})
        entry["all"].add(int(digits[0]))
        if place - place % STEP in reached:
            entry["reached"].add(int(digits[0]))
    return files


def coverage(results: Iterable[Result]) -> list[str]:
    """Return lines that say, by folder, how much of the own code all targets reach together."""
    every: dict[str, set[tuple[str, int]]] = {}
    reached: dict[str, set[tuple[str, int]]] = {}
    for result in results:
        for file, lines in result.lines.items():
            folder = str(Path(file).parent)
            every.setdefault(folder, set()).update((file, line) for line in lines["all"])
            reached.setdefault(folder, set()).update((file, line) for line in lines["reached"])
    return [
        f"{len(reached[folder]):6} of {len(every[folder]):6} lines with a block, "
        f"{100 * len(reached[folder]) / len(every[folder]):3.0f} %  {folder}"
        for folder in sorted(every)
    ]


def keep(target: str) -> int:
    """Add to the kept corpus what reaches more than it does; return how many inputs were added."""
    corpus = FOUND / f"{target}.all"
    fewest = FOUND / f"{target}.fewest"
    for folder in (corpus, fewest):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    for path in (FOUND / target).glob("*"):
        shutil.copy2(path, corpus)
    if not any(corpus.iterdir()):
        return 0
    program = PROGRAMS / f"fuzz_{target}"
    subprocess.run([program, corpus, "--keep", fewest], cwd=TREE / "build", check=True)
    added = 0
    for path in fewest.iterdir():
        if not (HERE / "corpus" / target / path.name).exists():
            shutil.copy2(path, HERE / "corpus" / target)
            added += 1
    return added


def main(arguments: Sequence[str]) -> int:
    """Run targets and tell what they found; return the exit status."""
    parser = argparse.ArgumentParser(prog="./dev fuzz", description=__doc__)
    parser.add_argument("what", nargs="*", help="names of targets (all), and seconds for each (60)")
    parser.add_argument(
        "--seed", type=int, default=0, help="seed of the inputs (by default another in every run)"
    )
    parser.add_argument("--keep", action="store_true", help="add new inputs to the kept corpus")
    options = parser.parse_args(arguments)
    numbers = [word for word in options.what if re.fullmatch(r"\d+(\.\d+)?", word)]
    names = [word for word in options.what if word not in numbers] or targets()
    if unknown := [name for name in names if name not in targets()]:
        print(f"fuzz: no target '{unknown[0]}'; there are {', '.join(targets())}", file=sys.stderr)
        return 2
    seconds = float(numbers[-1]) if numbers else 60.0
    seed = options.seed or int.from_bytes(os.urandom(6), "big")
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        results = list(pool.map(lambda name: run_target(name, seconds, seed), names))
    for result in results:
        program = PROGRAMS.relative_to(TREE) / f"fuzz_{result.target}"
        print(f"{result.target}: {result.summary}")
        if result.status != 0:
            print(
                f"  found with seed {seed}; again: {program} build/fuzz_last_input_{program.name}"
            )
    print(*coverage(results), sep="\n")
    if options.keep:
        print(*(f"{keep(name)} inputs kept for {name}" for name in names), sep="\n")
    return 1 if any(result.status != 0 for result in results) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
