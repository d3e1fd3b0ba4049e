"""Mutants of the lines that make the device safe, all in one program, and which test kills each.

``./dev mutate`` copies the sources to ``build/mutation/tree``, makes every mutant of
``tests/mutation/mutants/*.txt`` a choice at run time there, and builds the copy with the C++ tests.
A mutant dies by a test case that fails, crashes or hangs with it. The tests that kill are kept in
``build/mutation/killers.json``. The next run tries them first, then every other test that reaches
the mutant.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from tests.mutation import hunt
from tests.mutation.lists import (
    HERE,
    BadList,
    Mutant,
    Place,
    mutants_of,
    mutate_source,
    put,
    read_lists,
)
from tools.dev.building import use_compiler_cache

TREE = Path(__file__).parent.parent.parent
BUILD = TREE / "build/mutation"
PROGRAM = "torsio_mutants"
KILLERS = BUILD / "killers.json"
# Parts of the mutation build.
FOLDERS = (
    *("firmware", "emulator", "sdk", "bindings", "cmake"),
    *("tests/cpp", "tests/fuzz", "tests/golden", "docs/explanation"),
)
LEAST_LIMIT_S = 5.0  # processor time
# These wait for other threads, and take long on a busy machine.
LEFT_OUT = ("a ring carries everything in order from one thread to another",)


def listed() -> tuple[dict[str, str], int]:
    """Return the sources with all listed mutants, by name, and how many mutants there are."""
    of_file: dict[str, list[tuple[Place, list[int]]]] = {}
    count = 0
    for place in read_lists():
        numbers = [count + 1 + n for n in range(len(place.replacements))]
        count += len(numbers)
        of_file.setdefault(place.file, []).append((place, numbers))
    for file, places in of_file.items():
        if not (TREE / file).is_file():
            raise BadList(f"{places[0][0].where}: there is no {file}")
    texts = {name: (TREE / name).read_text(encoding="utf-8") for name in of_file}
    return {name: mutate_source(text, of_file[name]) for name, text in texts.items()}, count


def make_copy(copy: Path, mutated: Mapping[str, str]) -> None:
    """Bring a copy of the sources up to date, some of them mutated."""
    wanted: set[Path] = set()
    for folder in FOLDERS:
        for source in sorted((TREE / folder).rglob("*")):
            if not source.is_file() or "__pycache__" in source.parts:
                continue
            name = str(source.relative_to(TREE))
            put(copy / name, mutated[name].encode() if name in mutated else source.read_bytes())
            wanted.add(copy / name)
    own = {"CMakeLists.txt": "tree.cmake"}
    for name in (*own, "switch.hpp", "runner.cpp", "module.cpp"):
        put(copy / name, (HERE / own.get(name, name)).read_bytes())
        wanted.add(copy / name)
    for path in list(copy.rglob("*")):
        if path.is_file() and path not in wanted:
            path.unlink()


def build(
    room: Path, mutated: Mapping[str, str], count: int, log: Path, *options: str, target: str
) -> Path:
    """Make a copy in a folder and compile it; return where what is made stands.

    Raises
    ------
    subprocess.CalledProcessError
        If it does not compile; the log says why.
    """
    use_compiler_cache()
    make_copy(room / "tree", mutated)
    folder = room / "objects"
    log.parent.mkdir(parents=True, exist_ok=True)
    configure: list[str | Path] = ["cmake", "-S", room / "tree", "-B", folder, "-G", "Ninja"]
    configure += [f"-DTORSIO_MUTANTS={count}", *options]
    configure += ["-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_CXX_FLAGS_DEBUG=-O1"]
    with log.open("w") as output:
        build: list[str | Path] = ["cmake", "--build", folder, "--target", target]
        for command in (configure, build):
            subprocess.run(command, stdout=output, stderr=output, check=True)
    return folder


# --- running -------------------------------------------------------------------------------------


def box(room: Path) -> tuple[str, ...]:
    """Return what stands before a command with a mutant: it can change one folder of this machine.

    Raises
    ------
    BadList
        If this machine has no such box.
    """
    found = shutil.which("bwrap")
    if found is None:
        raise BadList("mutants run in a box, and bwrap is missing: install bubblewrap")
    words = [found, "--ro-bind", "/", "/", "--dev", "/dev", "--proc", "/proc", "--tmpfs", "/tmp"]
    for option, path in (("--ro-bind", TREE), ("--bind", room)):
        words += [option, str(path), str(path)]
    words += ["--unshare-all", "--die-with-parent"]
    tried = subprocess.run([*words, "true"], capture_output=True, check=False, text=True)
    if tried.returncode:
        raise BadList(f"mutants run in a box, and this machine allows none: {tried.stderr.strip()}")
    return tuple(words)


@dataclass(frozen=True)
class Outcome:
    """The result of one test case with one mutant."""

    result: str  # passed, failed or hung
    took_s: float
    reached: frozenset[int]


class Runner:
    """A process that runs test cases; see ``runner.cpp``."""

    def __init__(self, program: Path, inside: Sequence[str]) -> None:
        self._process = subprocess.Popen(
            [*inside, program],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=program.parent,
        )

    def run(self, case: str, mutant: int = 0, limit_s: float = 120.0) -> Outcome:
        """Run one test case, with a mutant switched on."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{mutant}\t{limit_s}\t{case}\n")
        self._process.stdin.flush()
        words = self._process.stdout.readline().split()
        return Outcome(words[0], float(words[1]), frozenset(int(word) for word in words[2:]))

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


def cases(program: Path) -> list[str]:
    """Return the names of all test cases of the runner."""
    listing = subprocess.run([program, "--list"], capture_output=True, check=True).stdout
    found = [case.get("name") or "" for case in ElementTree.fromstring(listing).iter("TestCase")]
    return sorted(set(found) - {"", *LEFT_OUT})


Work = TypeVar("Work")
Done = TypeVar("Done")


@dataclass
class Campaign:
    """A run over mutants.

    Attributes
    ----------
    killers
        By the key of a mutant, the test that kills it.
    survivors
        Those that no test has killed.
    inside
        The box in which tests run; see :func:`box`.
    """

    program: Path
    killers: dict[str, str] = field(default_factory=dict)
    survivors: list[Mutant] = field(default_factory=list)
    reach: dict[str, Outcome] = field(default_factory=dict)
    inside: Sequence[str] = ()

    def look_round(self) -> list[str]:
        """Run every test once as it is, to see what it reaches and how long it takes.

        Return what fails without any mutant: it is not asked again.
        """
        sick: list[str] = []
        names = cases(self.program)

        def one(runner: Runner, name: str) -> tuple[str, Outcome]:
            return name, runner.run(name)

        for name, outcome in self._in_parallel(names, one):
            if os.environ.get("TORSIO_MUTATE_VERBOSE"):
                print(f"{outcome.took_s:8.2f} s  {name}", flush=True)
            if outcome.result == "passed":
                self.reach[name] = outcome
            else:
                sick.append(name)
        return sick

    def _candidates(self, mutant: Mutant) -> list[tuple[str, float]]:
        near = [(n, o.took_s) for n, o in self.reach.items() if mutant.number in o.reached]
        return sorted(near, key=lambda one: one[1])

    def attack(self, runner: Runner, mutant: Mutant) -> tuple[Mutant, str]:
        known = self.killers.get(mutant.key)
        if known and runner.run(known, mutant.number, 4 * LEAST_LIMIT_S).result != "passed":
            return mutant, known
        for name, took_s in self._candidates(mutant):
            limit_s = max(LEAST_LIMIT_S, 20 * took_s)
            if name != known and runner.run(name, mutant.number, limit_s).result != "passed":
                return mutant, name
        return mutant, ""

    def run(self, mutants: Sequence[Mutant]) -> None:
        """Try to kill mutants, the known killers first."""
        for mutant, killer in self._in_parallel(mutants, self.attack):
            self.killers.pop(mutant.key, None)
            if killer:
                self.killers[mutant.key] = killer
            else:
                self.survivors.append(mutant)

    def _in_parallel(
        self, work: Sequence[Work], function: Callable[[Runner, Work], Done]
    ) -> list[Done]:
        """Hand each piece of work to one of as many runners as there are processors."""
        runners = [Runner(self.program, self.inside) for _ in range(os.cpu_count() or 1)]
        free = list(runners)

        def one(piece: Work) -> Done:
            runner = free.pop()
            try:
                return function(runner, piece)
            finally:
                free.append(runner)

        with ThreadPoolExecutor(len(runners)) as pool:
            results = list(pool.map(one, work))
        for runner in runners:
            runner.close()
        return results


def read_killers() -> dict[str, str]:
    """Return the tests that killed in the last run, by the keys of the mutants."""
    if not KILLERS.exists():
        return {}
    kept: dict[str, str] = json.loads(KILLERS.read_text(encoding="utf-8"))
    return kept


def write_killers(killers: dict[str, str], mutants: Sequence[Mutant]) -> None:
    """Keep the killers of these mutants for the next run."""
    kept = {mutant.key: killers[mutant.key] for mutant in mutants if mutant.key in killers}
    put(KILLERS, json.dumps(kept, indent=1, ensure_ascii=False).encode())


def verdict(mutants: Sequence[Mutant], survivors: Sequence[Mutant]) -> list[str]:
    """Return what is wrong: mutants that live, and equivalents that died after all."""
    living = {mutant.number for mutant in survivors}
    wrong = [f"lives: {m}" for m in mutants if m.number in living and not m.equivalent]
    wrong += [
        f"died, though {m.where} calls it equivalent: {m}"
        for m in mutants
        if m.number not in living and m.equivalent
    ]
    return wrong


def main(arguments: Sequence[str]) -> int:
    """Run a campaign, tell what lives and return the exit status."""
    if any(word.startswith("--random") for word in arguments):
        return hunt.main(arguments)
    parser = argparse.ArgumentParser(prog="./dev mutate", description=__doc__)
    parser.add_argument("only", nargs="*", help="numbers of mutants, or parts of their text")
    parser.add_argument("--all", action="store_true", help="forget the known killers")
    parser.add_argument("--list", action="store_true", help="only list the mutants")
    parser.add_argument("--tinyusb", default="", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    begin_s = time.monotonic()
    try:
        mutants = mutants_of(read_lists())
        chosen = [
            m
            for m in mutants
            if not options.only
            or any(w == str(m.number) or (not w.isdigit() and w in str(m)) for w in options.only)
        ]
        if options.list:
            print(*chosen, sep="\n")
            return 0
        log = TREE / "build/logs/mutate.log"
        mutated, count = listed()
        tinyusb = f"-DTORSIO_TINYUSB_PATH={options.tinyusb}"
        program = build(BUILD, mutated, count, log, tinyusb, target=PROGRAM) / PROGRAM
        print(f"{len(mutants)} mutants built after {time.monotonic() - begin_s:.0f} s", flush=True)
        campaign = Campaign(program, {} if options.all else read_killers(), inside=box(BUILD))
        if sick := campaign.look_round():
            raise BadList(f"the test '{sick[0]}' fails without any mutant")
        print(f"{len(campaign.reach)} tests know what they reach", flush=True)
        campaign.run(chosen)
    except BadList as error:
        print(f"mutate: {error}", file=sys.stderr)
        return 2
    except subprocess.CalledProcessError:
        print("mutate: does not compile; see build/logs/mutate.log", file=sys.stderr)
        return 2
    wrong = verdict(chosen, campaign.survivors)
    write_killers(campaign.killers, mutants)
    equivalent = sum(1 for mutant in chosen if mutant.equivalent)
    print(*wrong, sep="\n")
    print(
        f"{len(chosen)} mutants, {len(chosen) - len(campaign.survivors)} killed, "
        f"{equivalent} equivalent, "
        f"{len(wrong)} wrong, {time.monotonic() - begin_s:.0f} s"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
