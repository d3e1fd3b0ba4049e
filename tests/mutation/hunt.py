"""Random mutants of any product line, and whether a test notices: ``./dev mutate --random N``.

A copy of the tree in ``build/mutants/tree`` gets one change at a time. What depends on it is built
there. Then the tests run that could notice, the fastest first: the C++ programs that were linked
anew, and the files of Python tests that name most of what is changed. ``results.jsonl`` keeps what
became of each, so that a run that was ended goes on; ``explained.txt`` says why some may live.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from tests.mutation.anywhere import TREE, Change, drawn
from tests.mutation.lists import HERE, put
from tools.dev.building import use_compiler_cache

ROOM = TREE / "build/mutants"
COPY = ROOM / "tree"
RESULTS = ROOM / "results.jsonl"
HEALTH = ROOM / "health.json"
WHOLE = ROOM / "whole"
EXPLAINED = HERE / "explained.txt"
PACKAGE = "bindings/python/torsio"
LONGEST_BUILD_S = 1500.0
LONGEST_TESTS_S = 400.0
MOST_FILES = 5
LATE = "ran out of time"
# What reaches most of the C++ from Python in seconds.
BROAD = tuple(
    f"tests/python/test_{name}.py"
    for name in ("knob", "core", "replay", "closed_loop", "protocol", "game")
)
OF_PAGE = ("tests/studio/test_wasm.py", "tests/studio/test_page.py")


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
    for name in ("studio/node_modules", "build/studio/page"):
        if (TREE / name).is_dir():
            shutil.copytree(TREE / name, COPY / name, symlinks=True, dirs_exist_ok=True)


def run(command: Sequence[str | Path], limit_s: float) -> tuple[bool, str]:
    """Run a command in the copy; give whether it succeeded in time, and what it said."""
    paths = {"PYTHONPATH": str(COPY / "bindings/python"), "PYTHONDONTWRITEBYTECODE": "1"}
    with subprocess.Popen(
        [str(word) for word in command],
        cwd=COPY,
        env={**os.environ, **paths},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    ) as process:
        try:
            said, _ = process.communicate(timeout=limit_s)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            return False, LATE
    return process.returncode == 0, said


@dataclass
class Health:
    """What is known of tests without a mutant: how long they take, and which fail anyway."""

    takes_s: dict[str, float] = field(default_factory=dict)
    sick: list[str] = field(default_factory=list)

    def try_one(self, name: str, command: Sequence[str | Path], pattern: str) -> str:
        """Run a test program or file; give the case that failed, or what was said, or nothing."""
        begin_s = time.monotonic()
        is_good, said = run(command, LONGEST_TESTS_S)
        if is_good or "no tests ran" in said:
            self.takes_s[name] = time.monotonic() - begin_s
            HEALTH.write_text(json.dumps(asdict(self)), encoding="utf-8")
            return ""
        case = re.search(pattern, said, re.MULTILINE)
        return case[1] if case else f"{name}: {said[-80:]}"

    def in_order(self, names: Sequence[str]) -> list[str]:
        """Give tests in the order of their time; those that nobody has timed take a while."""
        return sorted(dict.fromkeys(names), key=lambda name: self.takes_s.get(name, 20.0))


LAYERS = ("core", "protocol", "device", "emulator", "usbip", "sdk")
TARGETS = {"asan-ubsan": [f"torsio_{layer}_tests" for layer in LAYERS], "release": ["_torsio"]}
PRODUCTS = {"asan-ubsan": "tests/cpp/torsio_*_tests", "release": "bindings/_torsio*.so"}
PYTEST = (sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--no-header")


class Builds:
    """The C++ of the copy: its test programs and, for what these do not notice, Python's module.

    Both are presets, in the folders that they have in the tree: a compiler's cache knows them.
    """

    def __init__(self, tinyusb: str) -> None:
        use_compiler_cache()
        self._settings = {
            "asan-ubsan": [f"-DTORSIO_TINYUSB_PATH={tinyusb}", "-DTORSIO_WERROR=OFF"],
            "release": [f"-DPython_EXECUTABLE={sys.executable}", "-DTORSIO_BUILD_BINDINGS=ON"],
        }
        self._whole: dict[Path, Path] = {}

    def configure(self) -> None:
        """Have what there is without a mutant; takes minutes, the first time."""
        if self._whole:
            return
        for preset, settings in self._settings.items():
            is_good, said = run(["cmake", "--preset", preset, *settings], 600.0)
            if not is_good or not self.build(preset, 4 * LONGEST_BUILD_S):
                sys.exit(f"mutate: the copy does not build without a mutant:\n{said[-3000:]}")
            for path in (COPY / "build" / preset).glob(PRODUCTS[preset]):
                self._whole[path] = WHOLE / path.name
                WHOLE.mkdir(exist_ok=True)
                shutil.copy2(path, WHOLE / path.name)

    @staticmethod
    def build(preset: str, limit_s: float = LONGEST_BUILD_S) -> bool:
        """Compile what has changed."""
        command = ["cmake", "--build", f"build/{preset}", "--target", *TARGETS[preset]]
        return run(command, limit_s)[0]

    def changed(self, preset: str) -> dict[Path, Path]:
        """Give what was linked and is not what it was without a mutant, with that."""
        there = {p: whole for p, whole in self._whole.items() if preset in p.parts}
        return {p: whole for p, whole in there.items() if p.read_bytes() != whole.read_bytes()}


def words_of(change: Change) -> set[str]:
    """Give names that a test of the changed line may have: of its file, and what that is for."""
    text = (COPY / change.file).read_text(encoding="utf-8")
    above = text.splitlines()[: change.number]
    pattern = re.compile(r"^\s*(?:async )?(?:def|class|function|export function) (\w+)")
    defined = [found[1] for line in above if (found := pattern.match(line))]
    public = re.search(r"^__all__ = \[([^\]]*)\]", text, re.MULTILINE)
    names = {Path(change.file).stem, Path(change.file).parent.name, *defined[-1:]}
    names |= set(re.findall(r"\w+", public[1])) if public else set()
    return {name.strip("_") for name in names} - {"torsio", "src", "core", "init", "main"}


def files_for(change: Change, folders: Sequence[str]) -> list[str]:
    """Give the files of Python tests that name most of what is changed."""
    words = words_of(change)
    scored = []
    for path in sorted(path for folder in folders for path in COPY.glob(f"{folder}/test_*.py")):
        text = path.read_text(encoding="utf-8")
        score = sum(min(5, len(re.findall(rf"\b\w*{re.escape(w)}\w*\b", text))) for w in words)
        score += 20 * sum(word in path.stem for word in words)
        if score:
            scored.append((-score, str(path.relative_to(COPY))))
    return [file for _, file in sorted(scored)[:MOST_FILES]]


@dataclass
class Hunt:
    """Tries one change after the other."""

    builds: Builds
    health: Health

    def judge(self, change: Change) -> tuple[str, str]:
        """Give what became of a change, and by what."""
        path = COPY / change.file
        original = path.read_bytes()
        lines = original.decode().split("\n")
        lines[change.number - 1] = change.after
        mutated = "\n".join(lines).encode()

        def put_in(*, is_mutated: bool) -> bool:
            path.write_bytes(mutated if is_mutated else original)
            if path.suffix == ".ts":
                return run([sys.executable, "-m", "tools.studio", "--page"], LONGEST_BUILD_S)[0]
            return path.suffix != ".py" or run([sys.executable, "-m", "py_compile", path], 60.0)[0]

        is_cpp = path.suffix in (".cpp", ".hpp")
        if is_cpp:
            self.builds.configure()
        try:
            if not put_in(is_mutated=True):
                return "unbuilt", ""
            if is_cpp:
                return self._try_cpp(change)
            if path.suffix == ".ts":
                return self._try_python([*files_for(change, ["tests/studio"]), *OF_PAGE], put_in)
            files = files_for(change, ["tests/python", "tests/studio"])
            return self._try_python([*files, *BROAD], put_in)
        finally:
            put_in(is_mutated=False)

    def _try_cpp(self, change: Change) -> tuple[str, str]:
        if not self.builds.build("asan-ubsan"):
            return "unbuilt", ""
        programs = {path.name: (path, w) for path, w in self.builds.changed("asan-ubsan").items()}
        for name in self.health.in_order(list(programs)):
            program, whole = programs[name]
            command = (program, "--abort-after=1", "--minimal")
            case = self.health.try_one(name, command, r"TEST CASE:\s*(.*)")
            again = () if case.endswith(LATE) else (f"--test-case={case}",)
            if case and run([whole, *again], 3 * LONGEST_TESTS_S)[0]:
                return "dead", f"{name}: {case}"
        if not self.builds.build("release"):
            return "unbuilt", ""
        modules = self.builds.changed("release")
        if not modules:
            return "alive" if programs else "same code", ""
        ((module, whole),) = modules.items()

        def put_in(*, is_mutated: bool) -> bool:
            shutil.copy2(module if is_mutated else whole, COPY / PACKAGE / module.name)
            return True

        try:
            put_in(is_mutated=True)
            return self._try_python([*files_for(change, ["tests/python"]), *BROAD], put_in)
        finally:
            put_in(is_mutated=False)

    def _try_python(self, files: Sequence[str], put_in: Callable[..., bool]) -> tuple[str, str]:
        begin_s = time.monotonic()
        for file in self.health.in_order(files):
            leave = [f"--deselect={case}" for case in self.health.sick]
            command = [*PYTEST, "-x", *leave, file]
            case = self.health.try_one(file, command, r"^(?:FAILED|ERROR) (\S+)")
            if case:
                # Does it pass without the change?
                put_in(is_mutated=False)
                if run([*PYTEST, case if "::" in case else file], 3 * LONGEST_TESTS_S)[0]:
                    return "dead", case
                self.health.sick.append(case)
                put_in(is_mutated=True)
            if time.monotonic() - begin_s > LONGEST_TESTS_S:
                break
        return "alive", ""


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
    total = sum(what.values()) - what["unbuilt"]
    good = what["dead"] + what["same code"] + what["explained"]
    living = [one for one in results if one["result"] == "alive" and one["key"] not in reasons]
    return [
        *(f"lives {one['key']} {one['change']}" for one in living),
        f"{total} mutants: {what['dead']} dead, {what['same code']} give the same code, "
        f"{what['explained']} explained, {what['alive']} live: {good / max(total, 1):.1%} dead or "
        f"explained; {what['unbuilt']} more did not build",
    ]


def wanted(seed: int, count: int, known: dict[str, dict[str, str]]) -> Iterator[Change]:
    """Yield changes until so many were built, without those that are known."""
    seen: set[str] = set()
    for change in drawn(seed, COPY):
        built = sum(known[key]["result"] != "unbuilt" for key in seen & known.keys())
        if built >= count:
            return
        if change.key not in seen:
            seen.add(change.key)
            if change.key not in known:
                yield change


def main(arguments: Sequence[str]) -> int:
    """Try random mutants, tell which live, and return the exit status."""
    parser = argparse.ArgumentParser(prog="./dev mutate", description=__doc__)
    parser.add_argument("--random", type=int, required=True, metavar="N", help="how many to build")
    parser.add_argument("--seed", type=int, default=1, help="of the draw; 1 unless given")
    parser.add_argument("--tinyusb", default="", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    os.nice(10)
    copy_tree()
    health = Health()
    if HEALTH.exists():
        health = Health(**json.loads(HEALTH.read_text(encoding="utf-8")))
    hunt = Hunt(Builds(options.tinyusb), health)
    known = results_of(options.seed)
    for change in wanted(options.seed, options.random, known):
        begin_s = time.monotonic()
        result, by = hunt.judge(change)
        took_s = time.monotonic() - begin_s
        print(f"{result:9} {took_s:5.0f} s  {change}  [{by}]", flush=True)
        one = {"key": change.key, "change": str(change), "result": result, "by": by}
        known[change.key] = one
        with RESULTS.open("a", encoding="utf-8") as file:
            file.write(json.dumps({**one, "seed": options.seed}) + "\n")
    lines = summary(list(known.values()))
    print(*lines, sep="\n")
    return 1 if len(lines) > 1 else 0
