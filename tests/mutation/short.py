"""A part of the mutants in every test run: mutants of the device that its own tests kill.

Compiling all tests a second time takes minutes. Here only the mutated sources of
``firmware/device`` are, and linked with the objects of the device's tests that the preset
``asan-ubsan`` has already. Each change of the sources tries the mutants of another file or two;
``./dev mutate`` tries every one.
"""

from __future__ import annotations

import json
import re
import shlex
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path

from tests.mutation import lists
from tests.mutation.lists import BadList, Mutant, Place
from tests.mutation.mutate import TREE, Campaign
from tools.dev import building

PRESET = TREE / "build/asan-ubsan"
BUILD = TREE / "build/mutation-short"
PROGRAM = "tests/cpp/torsio_device_tests"
# Only these have mutants, their own or their headers'. Those that a run tries are compiled anew.
SOURCES = (
    *("config", "config_store", "control_loop", "control_loop_orders", "device"),
    *("power_logic", "scene_builder"),
)
# Killed by the virtual knob's or a game's tests alone, or by one that compiles a header of its own.
ELSEWHERE = {"e7a38f5557f9773b", "f9c7152af8794f05", "8b3980b07f6c5a38"}
SHARE = 12  # one mutant in so many is tried
FOLDER = "firmware/device/"
LEFT_OUT = re.compile(r"/game/|/index_watch|/turn_watch")  # tests of the emulated device kill these
_RULES = """\
rule cc
  command = cd $folder && $words -MD -MF $out.d
  depfile = $out.d
  deps = gcc
rule link
  command = cd $folder && $words
"""


def _files(places: Sequence[Place]) -> dict[str, list[tuple[Place, list[int]]]]:
    of_file: dict[str, list[tuple[Place, list[int]]]] = {}
    count = 0
    for place in places:
        numbers = [count + 1 + n for n in range(len(place.replacements))]
        count += len(numbers)
        if place.file.startswith(FOLDER) and not LEFT_OUT.search(place.file):
            of_file.setdefault(place.file, []).append((place, numbers))
    return of_file


def put_sources(tree: Path, of_file: dict[str, list[tuple[Place, list[int]]]]) -> None:
    """Have these sources below a folder, mutated, and no others: they go before the product's."""
    for old in tree.rglob("*"):
        if old.is_file() and str(old.relative_to(tree)) not in of_file:
            old.unlink()
    for name, places in of_file.items():
        text = (TREE / name).read_text(encoding="utf-8")
        lists.put(tree / name, lists.mutate_source(text, places).encode())


def _escaped(path: Path | str) -> str:
    """Return a path as ninja's own language has it."""
    return re.sub(r"([$ :])", r"$\1", str(path))


def _compiling(target: str) -> str:
    """Return how the preset compiles the files of a target."""
    entries = json.loads((PRESET / "compile_commands.json").read_text(encoding="utf-8"))
    commands: Iterator[str] = (entry["command"] for entry in entries)
    return next(command for command in commands if f"/{target}.dir/" in command)


def _changed(command: str, source: Path, output: Path, *first: str) -> str:
    """Return a command of the compiler with another source and another output."""
    words = shlex.split(command)
    words[words.index("-o") + 1] = str(output)
    words[words.index("-c") + 1] = str(source)
    # Mutated lines compare a number with a number, and leave parameters unused.
    words = [word for word in words if word != "-Werror"]
    at = next(n for n, word in enumerate(words) if word.endswith(("c++", "g++"))) + 1
    return shlex.join([*words[:at], *first, *words[at:], "-w", "-g0", "-fno-sanitize=undefined"])


def build(log: Path) -> Path:
    """Compile the mutated sources and link them; return the runner.

    Raises
    ------
    BadList
        If a list does not fit the sources, or something does not compile; says where to look.
    """
    places = lists.read_lists()
    of_file = _files(places)
    count = len(lists.mutants_of(places))
    tree = BUILD / "tree"
    put_sources(tree, of_file)
    objects: list[Path] = []
    lines = [_RULES]

    def compile_one(target: str, source: Path, *options: str) -> None:
        output = BUILD / "objects" / f"{source.stem}.o"
        command = _changed(_compiling(target), source, output, *options)
        lines.append(
            f"build {_escaped(output)}: cc {_escaped(source)}\n"
            f"  folder = {shlex.quote(str(PRESET))}\n  words = {command}"
        )
        objects.append(output)

    switch = ("-include", str(lists.HERE / "switch.hpp"), f"-I{tree / 'firmware'}")
    mutants = {Path(mutant.file) for mutant in chosen(lists.mutants_of(places))}
    in_headers = any(file.suffix == ".hpp" for file in mutants)
    stems = SOURCES if in_headers else {file.stem for file in mutants}
    for stem in stems:
        name = f"{FOLDER}{stem}.cpp"
        compile_one("torsio_device", (tree if name in of_file else TREE) / name, *switch)
    # doctest's main program gives way to the runner.
    compile_one("torsio_test_main", lists.HERE / "runner.cpp", f"-DTORSIO_MUTANTS={count}")
    listing = subprocess.run(
        ["ninja", "-t", "commands", PROGRAM], cwd=PRESET, capture_output=True, text=True, check=True
    ).stdout
    words = shlex.split(listing.splitlines()[-1].removeprefix(": && ").removesuffix(" && :"))
    program = BUILD / "torsio_mutants"
    words[words.index("-o") + 1] = str(program)
    words = [word for word in words if not word.endswith("doctest_main.cpp.o")]
    at = next(n for n, word in enumerate(words) if word.endswith(".o"))
    # In front: of a function that is in several objects the first is taken.
    words[at:at] = ["-Wl,-z,muldefs", *map(str, objects)]
    needs = [PRESET / word for word in words if word.endswith((".o", ".a"))]
    lines.append(
        f"build {_escaped(program)}: link {' '.join(map(_escaped, (*objects, *needs)))}\n"
        f"  folder = {shlex.quote(str(PRESET))}\n  words = {shlex.join(words)}\n"
    )
    lists.put(BUILD / "build.ninja", "\n".join(lines).encode())
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("w") as output:
        status = subprocess.run(
            ["ninja", "-C", BUILD], stdout=output, stderr=output, check=False
        ).returncode
    if status != 0:
        raise BadList(f"does not compile; see {log.relative_to(TREE)}")
    return program


def chosen(mutants: Sequence[Mutant]) -> list[Mutant]:
    """Return the mutants of a test run: of one or two of the device's files, by turns."""
    compiled = [
        mutant
        for mutant in mutants
        if mutant.file.startswith(FOLDER)
        and not LEFT_OUT.search(mutant.file)
        and (Path(mutant.file).suffix == ".hpp" or Path(mutant.file).stem in SOURCES)
        and not mutant.equivalent
        and mutant.key not in ELSEWHERE
    ]
    turn = int(building.digest(["firmware"])[:8], 16) % SHARE
    return compiled[turn * len(compiled) // SHARE : (turn + 1) * len(compiled) // SHARE]


def attack(program: Path) -> tuple[int, list[Mutant]]:
    """Try to kill the chosen mutants with the device's tests; return how many, and what lives."""
    wanted = chosen(lists.mutants_of(lists.read_lists()))
    campaign = Campaign(program)
    campaign.look_round()
    campaign.run(wanted)
    return len(wanted), campaign.survivors
