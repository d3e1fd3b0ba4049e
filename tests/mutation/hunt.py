"""Random mutants of any product line, and whether a test notices: ``./dev mutate --random N``.

Mutants of C++ are choices at run time, compiled once: into a program with all C++ tests, and into a
Python module. Each test says once what it reaches. A mutant is tried with the tests that reach it,
until one fails; such a test must pass without the mutant. Lines of Python and TypeScript change in
a copy of the tree. ``results.jsonl`` keeps what became of each, so that a run that was ended goes
on; ``explained.txt`` says why some may live.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from tests.mutation import mutate, reach
from tests.mutation.anywhere import TREE, Change, choice_of, drawn
from tests.mutation.lists import HERE, BadList, Mutant, put, with_choices

ROOM = TREE / "build/mutants"
COPY = ROOM / "copy"
RESULTS = ROOM / "results.jsonl"
TESTS = ROOM / "tests.json"
TOLD = ROOM / "told.jsonl"
LEFT_OUT = ROOM / "left_out.json"  # the keys of mutants that do not compile
LOG = TREE / "build/logs/mutants.log"
OPEN = "open"  # C++ that lives through the C++ tests
EXPLAINED = HERE / "explained.txt"
PACKAGE = "bindings/python/torsio"
PYTEST = (sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", reach.__name__)
# Processor time of a mutant's tests. The page's tests and a second try get more.
MOST_S, MOST_OF_PAGE_S, MOST_AGAIN_S = 40.0, 150.0, 600.0
ROUNDS = 40  # until all choices compile; each ends at the first that does not


def copy_tree() -> None:
    """Bring the copy up to date with the tree, without what git ignores."""
    listing = ("git", "ls-files", "-z", "--cached", "--others", "--exclude-standard")
    names = subprocess.run(listing, cwd=TREE, capture_output=True, check=True, text=True).stdout
    for name in names.split("\0"):
        source = TREE / name
        if source.is_file():
            put(COPY / name, source.read_bytes())
            shutil.copymode(source, COPY / name)
    # Compiled code beside the copy's Python, as in the package that is installed.
    script = "import torsio; print(torsio.__path__[0])"
    found = subprocess.run(
        [sys.executable, "-c", script], cwd="/", capture_output=True, check=True, text=True
    )
    installed = Path(found.stdout.strip())
    for pattern in ("*.so", "bin/*", "*.rules"):
        for path in installed.glob(pattern):
            target = COPY / PACKAGE / path.relative_to(installed)
            target.parent.mkdir(exist_ok=True)
            shutil.copy2(path, target)
    for name in ("studio/node_modules", "build/studio/page", "build/studio/modules"):
        if (TREE / name).is_dir() and not (COPY / name).exists():
            shutil.copytree(TREE / name, COPY / name, symlinks=True)


def is_cpp(change: Change) -> bool:
    """Whether a change may be a choice at run time."""
    return change.file.endswith("pp")


# --- choices ------------------------------------------------------------------------------------


def with_all(changes: Sequence[Change], left_out: set[int]) -> tuple[dict[str, str], set[int]]:
    """Return the sources in which changes are choices, numbered from 1, and which these are."""
    cuts: dict[str, dict[tuple[int, int], list[tuple[int, str]]]] = defaultdict(dict)
    texts: dict[str, str] = {}
    inside: set[int] = set()
    for number, change in enumerate(changes, 1):
        if not is_cpp(change) or number in left_out:
            continue
        text = texts.setdefault(change.file, (TREE / change.file).read_text(encoding="utf-8"))
        if (piece := choice_of(change, text)) is None:
            continue
        begin, end, new = piece
        there = cuts[change.file]
        if any((b, e) != (begin, end) and begin < e and b < end for b, e in there):
            continue  # overlaps another
        there.setdefault((begin, end), []).append((number, new))
        inside.add(number)
    return {name: with_choices(texts[name], of_file) for name, of_file in cuts.items()}, inside


def to_blame(log: str, mutated: dict[str, str]) -> set[int]:
    """Return the choices that do not compile, going by what the compiler says."""
    blamed: set[int] = set()
    for block in re.split(r"^(?=FAILED|\[\d+/)", log, flags=re.MULTILINE):
        if " error: " not in block:
            continue
        for name, line in re.findall(r"^\S*?/tree/([^:\s]+):(\d+):", block, re.MULTILINE):
            before = mutated.get(name, "").splitlines()[: int(line)]
            for text in reversed(before[-8:]):
                if numbers := re.findall(r"torsio_mutant_is\((\d+)\)", text):
                    blamed |= {int(number) for number in numbers}
                    break
    return blamed


def build(changes: Sequence[Change], tinyusb: str) -> tuple[Path, set[int]]:
    """Compile all choices that compile; return where, and which are in."""
    keys = set(json.loads(LEFT_OUT.read_text(encoding="utf-8")) if LEFT_OUT.exists() else [])
    left_out = {number for number, change in enumerate(changes, 1) if change.key in keys}
    options = (
        *(f"-DTORSIO_TINYUSB_PATH={tinyusb}", "-DTORSIO_MUTATE_ALL=ON"),
        f"-DPython_EXECUTABLE={sys.executable}",
    )
    for _ in range(ROUNDS):
        mutated, inside = with_all(changes, left_out)
        try:
            count = len(changes)
            folder = mutate.build(ROOM, mutated, count, LOG, *options, target="torsio_random")
        except subprocess.CalledProcessError:
            blamed = to_blame(LOG.read_text(encoding="utf-8"), mutated)
            print(f"{len(blamed)} changes do not compile", flush=True)
            if not blamed:
                break
            left_out |= blamed
            keys |= {changes[number - 1].key for number in blamed}
            LEFT_OUT.write_text(json.dumps(sorted(keys)), encoding="utf-8")
        else:
            return folder, inside
    sys.exit(f"mutate: does not compile; see {LOG.relative_to(TREE)}")


# --- Python tests -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Tried:
    """One test's result, as reach.py writes it."""

    test: str
    failed: bool
    takes_s: float
    reached: tuple[int, ...]
    files: tuple[str, ...]


def run(
    command: Sequence[str | Path], *, most_s: float, number: int = 0, wanted: str = "{}"
) -> tuple[bool, list[Tried]]:
    """Run a command in the copy, with a choice; give whether all was well, and what tests said.

    It may take so much of the processor's time, and much longer in all.
    """
    TOLD.unlink(missing_ok=True)
    environment = {
        **os.environ,
        "PYTHONPATH": str(COPY / "bindings/python"),
        "TORSIO_MUTANT": str(number),
        reach.TOLD: str(TOLD),
        reach.WANTED: wanted,
    }
    seconds = round(most_s)
    with LOG.with_name("mutants-tests.log").open("w") as log:
        process = subprocess.Popen(
            [*mutate.box(ROOM), *map(str, command)],
            cwd=COPY,
            env=environment,
            stdout=log,
            stderr=log,
            start_new_session=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds)),
        )
        try:
            is_good = process.wait(20.0 * most_s) == 0
        except subprocess.TimeoutExpired:
            is_good = False
        finally:
            if process.poll() is None:
                os.killpg(process.pid, 9)
                process.wait()
    lines = TOLD.read_text(encoding="utf-8").splitlines() if TOLD.exists() else []
    return is_good, [Tried(**json.loads(line)) for line in lines]


@dataclass
class Hunt:
    """Tries one change after the other.

    Attributes
    ----------
    changes
        All, whose numbers are from 1.
    reached
        Those that C++ tests reach.
    most_s
        Processor time of a mutant's tests together.
    tests
        Those that pass without a change, the cheapest first.
    """

    changes: Sequence[Change]
    reached: set[int]
    most_s: float = MOST_S
    tests: list[Tried] = field(default_factory=list)

    def look_round(self, folder: str) -> None:
        """Run every Python test of a folder once, to see what it reaches, unless that is known."""
        lines: dict[str, dict[int, int]] = defaultdict(dict)
        for number, change in enumerate(self.changes, 1):
            if change.file.endswith(".py"):
                lines[str(COPY / change.file)][change.number] = number
        wanted = json.dumps({"lines": lines, "choices": len(self.changes)})
        known = json.loads(TESTS.read_text(encoding="utf-8")) if TESTS.exists() else {}
        if known.get(folder, {}).get("wanted") != wanted:
            _, told = run((*PYTEST, folder), most_s=7200.0, wanted=wanted)
            if not told:
                sys.exit("mutate: no test runs in the copy; see build/logs/mutants-tests.log")
            known[folder] = {"wanted": wanted, "tests": [vars(one) for one in told]}
            TESTS.write_text(json.dumps(known), encoding="utf-8")
        told = [Tried(**one) for one in known[folder]["tests"]]
        good = [one for one in told if not one.failed]
        self.tests = sorted((*self.tests, *good), key=lambda one: one.takes_s)
        print(f"{len(told)} tests of {folder}; {len(told) - len(good)} fail anyway", flush=True)

    def judge(self, number: int) -> tuple[str, str]:
        """Give what became of a change, and by what."""
        change = self.changes[number - 1]
        if is_cpp(change):
            if red := self._red(self._reaching(number), number):
                return "dead", red
            is_reached = any(number in one.reached for one in self.tests)
            return ("alive" if is_reached or number in self.reached else "unreached"), ""
        path = COPY / change.file
        original = path.read_bytes()
        lines = original.decode().split("\n")
        lines[change.number - 1] = change.after
        mutated = "\n".join(lines).encode()
        check: tuple[str | Path, ...] = (sys.executable, "-m", "tools.studio", "--page")
        again: tuple[str | Path, ...] = (*check, "--unchecked")
        if path.suffix == ".py":
            check = again = (sys.executable, "-m", "py_compile", path)

        def put_in(is_mutated: bool) -> bool:
            nonlocal check
            wanted = mutated if is_mutated else original
            if path.read_bytes() == wanted:
                return True
            path.write_bytes(wanted)
            # Compiled Python is known by its source's second and size.
            os.utime(path, (number, number) if is_mutated else None)
            is_good = run(check, most_s=300.0)[0]
            check = again
            return is_good

        try:
            if not put_in(True):
                return "unbuilt", ""
            tests = self._reaching(number) if path.suffix == ".py" else self._of_page()
            return self._told(self._red(tests, number, put_in))
        finally:
            put_in(False)

    @staticmethod
    def _told(red: str) -> tuple[str, str]:
        return ("dead" if red else "alive"), red

    def _reaching(self, number: int) -> list[Tried]:
        """Give the tests that reach a change or, of Python, its file; the cheapest first."""
        change = self.changes[number - 1]
        near = [one for one in self.tests if number in one.reached]
        if not is_cpp(change):
            file = str(COPY / change.file)
            near = near or [one for one in self.tests if file in one.files]
            # Each test reaches the code that runs on import.
            near = near or self.tests
        return _within(near, self.most_s)

    def _of_page(self) -> list[Tried]:
        """Give the page's tests. Tests in one file stay together: they share a browser."""
        of_file: dict[str, list[Tried]] = defaultdict(list)
        for one in self.tests:
            if one.test.startswith("tests/studio/"):
                of_file[one.test.partition("::")[0]].append(one)
        files = sorted(of_file.values(), key=lambda tests: sum(one.takes_s for one in tests))
        return _within([one for tests in files for one in tests], max(MOST_OF_PAGE_S, self.most_s))

    def _red(
        self, tests: list[Tried], number: int, put_in: Callable[[bool], object] = lambda _: None
    ) -> str:
        """Give the first test that fails with a change, and without it does not."""

        def is_good(names: Sequence[str], *, is_mutated: bool) -> tuple[bool, list[Tried]]:
            put_in(is_mutated)
            most_s = 30.0 + 5.0 * sum(one.takes_s for one in tests)
            return run((*PYTEST, "-x", *names), most_s=most_s, number=is_mutated * number)

        left = [one.test for one in tests]
        while left:
            good, told = is_good(left, is_mutated=True)
            if good:
                break
            red = [one.test for one in told if one.failed]
            names = red or left
            if is_good(names, is_mutated=False)[0] and not is_good(names, is_mutated=True)[0]:
                return red[0] if red else "a process that ends"
            # It fails anyway, on this machine and today. The others have not been asked.
            done = {one.test for one in told}
            left = [test for test in left if test not in done] if red else []
        return ""


def _within(tests: Sequence[Tried], most_s: float) -> list[Tried]:
    """Give the first tests, up to so many seconds."""
    sums = itertools.accumulate(one.takes_s for one in tests)
    return [one for one, until_s in zip(tests, sums, strict=True) if until_s <= most_s]


# --- results ------------------------------------------------------------------------------------


def results_of(seed: int) -> dict[str, dict[str, str]]:
    """Give what was found with a seed, by the changes' keys."""
    lines = RESULTS.read_text(encoding="utf-8").splitlines() if RESULTS.exists() else []
    found = [json.loads(line) for line in lines]
    return {one["key"]: one for one in found if one["seed"] == seed}


def explained() -> dict[str, str]:
    """Give the reasons why changes may live, by their keys."""
    lines = EXPLAINED.read_text(encoding="utf-8").splitlines()
    pairs = [line.split("  ", 1) for line in lines if line and line[0] != "#"]
    return dict(pairs)


def summary(results: Sequence[dict[str, str]]) -> list[str]:
    """Say how many died, and name those that live without a reason."""
    reasons = explained()
    what = Counter(
        "explained" if one["result"] == "alive" and one["key"] in reasons else one["result"]
        for one in results
    )
    total = sum(what.values()) - what["unbuilt"] - what["unreached"] - what[OPEN]
    good = what["dead"] + what["explained"]
    living = [one for one in results if one["result"] == "alive" and one["key"] not in reasons]
    return [
        *(f"lives {one['key']} {one['change']}" for one in living),
        f"{total} mutants: {what['dead']} dead, {what['explained']} explained, {what['alive']} "
        f"live: {good / max(total, 1):.1%} dead or explained; {what['unbuilt']} more did not "
        f"build, {what['unreached']} of C++ no test reaches: the compiler computes many of them; "
        f"{what[OPEN]} are not tried to the end",
    ]


def try_cpp(changes: Mapping[int, Change], program: Path) -> Iterator[tuple[int, str, str]]:
    """Try choices with the C++ tests; yield what became of each, and by what."""
    if not changes:
        return
    cpp = mutate.Campaign(program, inside=mutate.box(ROOM))
    for name in cpp.look_round():
        print(f"fails anyway: {name}", flush=True)
    runner = mutate.Runner(program, cpp.inside)
    for number, change in changes.items():
        mutant = Mutant(number, change.file, change.before, change.after, str(change))
        if red := cpp.attack(runner, mutant)[1]:
            yield number, "dead", red
        else:
            is_reached = any(number in one.reached for one in cpp.reach.values())
            yield number, OPEN, "reached" if is_reached else ""


def campaign(changes: Sequence[Change], seed: int, tinyusb: str, *, again: bool) -> None:
    """Try what is not known yet, and perhaps what lived."""
    known = results_of(seed)
    if again:
        known = {key: one for key, one in known.items() if one["result"] != "alive"}
    if all(known.get(change.key, {"result": OPEN})["result"] != OPEN for change in changes):
        return
    folder, inside = build(changes, tinyusb)
    for module in (folder / "bindings").glob("_torsio*.so"):
        shutil.copy2(module, COPY / PACKAGE / module.name)
    begin_s = time.monotonic()

    def note(number: int, result: str, by: str) -> None:
        nonlocal begin_s
        change = changes[number - 1]
        print(f"{result:8} {time.monotonic() - begin_s:4.0f} s  {change}  [{by}]", flush=True)
        begin_s = time.monotonic()
        one: dict[str, Any] = {"key": change.key, "change": str(change), "result": result, "by": by}
        with RESULTS.open("a", encoding="utf-8") as file:
            file.write(json.dumps({**one, "seed": seed}) + "\n")
        known[change.key] = one

    new = {n: one for n, one in enumerate(changes, 1) if one.key not in known}
    for number, change in new.items():
        if is_cpp(change) and number not in inside:
            note(number, "unbuilt", "")
    # The cheapest tests go first: of C++, of the library, of the page.
    choices = {number: change for number, change in new.items() if number in inside}
    for found in try_cpp(choices, folder / mutate.PROGRAM):
        note(*found)
    open_now = {
        n: known.get(one.key, {})
        for n, one in enumerate(changes, 1)
        if known.get(one.key, {"result": OPEN})["result"] == OPEN
    }
    reached = {n for n, one in open_now.items() if one.get("by")}
    hunt = Hunt(changes, reached, MOST_AGAIN_S if again else MOST_S)
    for tests, is_of_page in (("tests/python", False), ("tests/studio", True)):
        hunt.look_round(tests)
        # In the order of the draw: what is done when it is ended early is a sample too.
        for number in open_now:
            if ("/studio/" in f"/{changes[number - 1].file}") == is_of_page:
                note(number, *hunt.judge(number))


def sources_at(revision: str) -> Path:
    """Unpack a revision's sources; return where."""
    folder = ROOM / "drawn"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    archive = subprocess.run(
        ("git", "archive", revision), cwd=TREE, capture_output=True, check=True
    )
    subprocess.run(("tar", "-x", "-C", folder), input=archive.stdout, check=True)
    return folder


def still_there(changes: Sequence[Change]) -> Iterator[Change]:
    """Yield the changes whose lines stand in the tree, where they stand now."""
    for change in changes:
        path = TREE / change.file
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        lines = [*enumerate(text.split("\n"), 1)]
        if same := [one for one in lines if one[1].strip() == change.before.strip()][
            change.twins :
        ]:
            number, line = same[0]
            margin = line[: len(line) - len(line.lstrip())]
            after = margin + change.after.lstrip()
            yield replace(change, number=number, before=line, after=after)


def main(arguments: Sequence[str]) -> int:
    """Try random mutants, tell which live, and return the exit status."""
    parser = argparse.ArgumentParser(prog="./dev mutate", description=__doc__)
    parser.add_argument(
        "--random", type=int, required=True, metavar="N", help="number of mutants to draw"
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the draw; 1 if unset")
    parser.add_argument("--at", metavar="REVISION", help="draw from the sources of a revision")
    parser.add_argument(
        "--again", action="store_true", help="try those that lived, with more tests"
    )
    parser.add_argument("--tinyusb", default="", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    copy_tree()
    # The same change may be drawn twice.
    tree = sources_at(options.at) if options.at else TREE
    many = itertools.islice(drawn(options.seed, tree), 4 * options.random)
    changes = list({change.key: change for change in many}.values())[: options.random]
    changes = list(still_there(changes))
    print(f"{len(changes)} of {options.random} lines are as they were drawn", flush=True)
    try:
        campaign(changes, options.seed, options.tinyusb, again=options.again)
    except BadList as error:
        print(f"mutate: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("ended; the same command goes on", flush=True)
    results = results_of(options.seed)
    lines = summary([results[change.key] for change in changes if change.key in results])
    print(*lines, sep="\n")
    return 1 if len(lines) > 1 else 0
