"""Chooses the tests that a call of ``./dev test`` runs, and notes which groups have passed.

A digest of a group's files tells whether it has changed; it is kept in ``build/tests``.
"""

from __future__ import annotations

import hashlib
import itertools
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from tools.dev import building
from tools.dev.groups import BOARDS_VARIABLE, EVERY_CHANGE, FIGURES, FIREFOX, GROUPS
from tools.dev.running import BUILD, TREE, UsageError, stamp_is, stamped


def _tools() -> str:
    """Return the versions of what an upgrade of the system changes."""
    found = [sys.version]
    for program in ("c++", "arm-none-eabi-g++", "node", "qemu-system-x86_64"):
        if shutil.which(program):
            found.append(
                subprocess.run([program, "--version"], capture_output=True).stdout.decode()
            )
    return "\n".join(found)


def with_tools(digests: Mapping[str, str]) -> dict[str, str]:
    """Return digests that an upgrade of the system's tools changes too."""
    tools = _tools()
    return {
        name: hashlib.sha256((digest + tools).encode()).hexdigest()
        for name, digest in digests.items()
    }


# Groups for pytest's own words where no group or path is named. They need the least.
QUICK = ("library", "cpp")
# Words of pytest's that leave out no test.
_HARMLESS = re.compile(r"--(junitxml|durations|tb|color)(=.*)?|-v+|-q+|-s|-r\w+")


@dataclass(frozen=True)
class Plan:
    """The tests that a call of ``./dev test`` runs.

    Attributes
    ----------
    groups
        Names.
    arguments
        For pytest.
    left_out
        Names of groups that have not changed since they passed.
    run
        Digest of each group that runs whole.
    turn
        Chooses the board and the kernel of a change.
    """

    groups: tuple[str, ...]
    arguments: tuple[str, ...]
    left_out: tuple[str, ...] = ()
    run: Mapping[str, str] = field(default_factory=dict)
    turn: int = field(default_factory=lambda: int(GROUPS["board"].digest()[:8], 16))

    @property
    def needs(self) -> set[str]:
        """Steps of the build."""
        return {need for name in self.groups for need in GROUPS[name].needs}

    @property
    def boards(self) -> tuple[str, ...]:
        """Boards whose firmware runs: one whose turn it is, if not all."""
        named = self.variables.get(BOARDS_VARIABLE, "").split()
        return tuple(named) or (building.BOARDS[self.turn % len(building.BOARDS)],)

    @property
    def variables(self) -> dict[str, str]:
        """For the environment of the tests."""
        found: dict[str, list[str]] = {}
        for name in self.groups:
            for key, value in GROUPS[name].variables.items():
                found.setdefault(key, []).append(value)
        return {key: " ".join(values) for key, values in found.items()}


def _stamp(name: str) -> Path:
    return BUILD / "tests" / f"{name}.passed"


def remember(run: Mapping[str, str], failed: Iterable[str]) -> None:
    """Note the digests, tools included, of groups that ran whole and passed.

    Others have none. `failed` has node ids.
    """
    failed = list(failed)
    for name, digest in run.items():
        if digest and not any(GROUPS[name].has(test) for test in failed):
            with stamped(_stamp(name), digest):
                pass


def _paths(words: Sequence[str]) -> list[str]:
    """Return the paths of tests among pytest's words."""
    values = [word for option, word in itertools.pairwise(words) if option in ("-k", "-m")]
    found = [word for word in words if not word.startswith("-") and word not in values]
    return [path for path in found if (TREE / path.partition("::")[0]).exists()]


def _of_path(path: str) -> list[str]:
    """Return the groups that run a path: the one that names its very file, or those around it."""
    file = path.partition("::")[0].rstrip("/")
    exact = [name for name, group in GROUPS.items() if file in group.tests]
    around = [
        name
        for name in EVERY_CHANGE
        if GROUPS[name].has(path)
        or any(PurePosixPath(own).is_relative_to(file) for own in GROUPS[name].tests)
    ]
    slow = [name for name, group in GROUPS.items() if group.has(path)]
    return exact[:1] or around or slow[:1]


def _tests(names: Sequence[str]) -> list[str]:
    """Return the paths of groups, with words that leave out what slow groups have below them."""
    paths = list(dict.fromkeys(path for name in names for path in GROUPS[name].tests))
    below = [
        file
        for file in (*FIGURES, FIREFOX)
        if file not in paths and any(file.startswith(f"{path}/") for path in paths)
    ]
    return [*paths, *(f"--ignore={file}" for file in below)]


def _named(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the groups that come first among the words, and the words behind them."""
    names: list[str] = []
    rest = list(words)
    while rest and rest[0] in (*GROUPS, "all"):
        word = rest.pop(0)
        names += EVERY_CHANGE if word == "all" else [word]
    alone = [name for name in dict.fromkeys(names) if name in ("slow", "games")]
    if alone and len(set(names)) > 1:
        raise UsageError(f"'{alone[0]}' leaves out tests of other groups; run it alone")
    return list(dict.fromkeys(names)), rest


def plan(words: Sequence[str]) -> Plan:
    """Choose groups by the words behind ``./dev test``: names of groups, then pytest's own."""
    names, rest = _named(words)
    paths = _paths(rest)
    if paths:
        found = [name for path in paths for name in _of_path(path)]
        return Plan(tuple(dict.fromkeys([*names, *found])), (*_tests(names), *rest))
    if not names and any(word.startswith(("-k", "-m")) for word in rest):
        return Plan(QUICK, (*_tests(QUICK), *rest))
    return _named_or_changed(names, rest)


def _named_or_changed(names: Sequence[str], rest: Sequence[str]) -> Plan:
    digests = {name: GROUPS[name].digest() for name in names or EVERY_CHANGE}
    known = {} if names else with_tools(digests)
    left_out = [name for name, digest in known.items() if stamp_is(_stamp(name), digest)]
    chosen = [name for name in digests if name not in left_out]
    whole = all(_HARMLESS.fullmatch(word) for word in rest)
    run = {name: digests[name] for name in chosen} if whole else {}
    return Plan(tuple(chosen), (*_tests(chosen), *rest), tuple(left_out), run)
