"""``./dev`` and packages, requirements, stamps and other systems, without installing anything."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tools import windows
from tools.dev import benches, building, cli, groups, plans

TREE = Path(__file__).parent.parent


def test_commands_are_those_that_the_help_tells() -> None:
    text = (TREE / "tools/dev/help.txt").read_text(encoding="utf-8")
    told = [
        line.split()[0] for line in text.splitlines() if line.startswith("  ") and line[2] != " "
    ]
    assert set(told) == {"help", *cli.COMMANDS}


def named_and_gone(text: str) -> set[str]:
    """Return the commands that a text names and that are not there, with what they are given."""
    named = re.findall(r"\./dev ([a-z]+)(?: ([a-z]+))?", text)
    given = {
        "bench": benches.benchmarks(),
        "build": [*building.PRESETS, "python"],
        "windows": [*windows.LAYERS, "python"],
    }
    return {
        f"{name} {word}".strip()
        for name, word in named
        if name not in ("help", *cli.COMMANDS) or (word and word not in given.get(name, [word]))
    }


def test_commands_need_nothing_but_the_standard_library() -> None:
    # -S leaves out everything that is installed; -I the user's own paths.
    program = "import sys; sys.path.insert(0, sys.argv[1]); import tools.dev.cli"
    result = subprocess.run(
        [sys.executable, "-I", "-S", "-c", program, TREE],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.stderr == ""


def test_every_test_is_in_a_group_that_runs_at_every_change_or_in_a_slow_one() -> None:
    files = {str(file.relative_to(TREE)) for file in (TREE / "tests").rglob("test_*.py")}
    inside = {file for file in files if file.startswith("tests/vm/guest/")}
    assert inside
    left = [file for file in files if not any(group.has(file) for group in groups.GROUPS.values())]
    assert left == []
    slow = set((TREE / ".ci/slow").read_text(encoding="utf-8").splitlines())
    assert {f"test {name}" for name, group in groups.GROUPS.items() if group.slow} <= slow


@pytest.fixture
def stamps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(plans, "BUILD", tmp_path)
    monkeypatch.setattr(building, "digest", lambda names: f"{len(list(names)):08x}")
    return tmp_path


def test_group_that_passed_whole_is_left_out_until_what_it_covers_changes(
    stamps: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)  # a machine without tools
    first = plans.plan([])
    assert (list(first.groups), first.left_out) == (groups.EVERY_CHANGE, ())
    monkeypatch.undo()  # the build has installed them
    monkeypatch.setattr(plans, "BUILD", stamps)
    monkeypatch.setattr(building, "digest", lambda names: f"{len(list(names)):08x}")
    plans.remember(
        plans.with_tools(first.run),
        ["tests/python/test_knob.py::test_x", "tests/test_checks.py::test_y"],
    )
    second = plans.plan([])
    assert second.groups == ("checks", "library")
    assert set(second.groups) | set(second.left_out) == set(groups.EVERY_CHANGE)
    assert list(plans.plan(["all"]).groups) == groups.EVERY_CHANGE
    monkeypatch.setattr(
        building,
        "digest",
        lambda names: f"{len(list(names)):08x}{'docs/reference/c.md' in names or ''}",
    )
    third = plans.plan([])
    assert third.groups == ("checks", "library", "interfaces")


@pytest.mark.parametrize("name", groups.GROUPS)
def test_digest_of_a_group_is_of_files_that_are_there(name: str) -> None:
    group = groups.GROUPS[name]
    assert [path for path in (*group.covers, *group.tests) if not (TREE / path).exists()] == []


def test_file_that_a_test_reads_must_be_covered() -> None:
    test = "tests/c/test_calls.py::test_x"
    files = [
        "docs/reference/c.md",
        "docs/reference/usb.md",
        "build/x",
        "sdk/c/src/structures.cpp",
        "tests/c/layouts.py",
    ]
    assert groups.not_covered(test, files) == ["docs/reference/usb.md"]
    # A slow group may read more than the group of every change that has the same test.
    test = "tests/board/test_guards.py::test_x"
    assert groups.not_covered(test, ["docs/results.md"]) == ["docs/results.md"]
    assert groups.not_covered(test, ["docs/results.md"], ["guards", "documents"]) == []


def _imported(file: Path, known: set[Path]) -> None:
    """Add the files of tests and tools that a module imports, and that these import."""
    known.add(file)
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        for name in names:
            source = TREE / f"{name.replace('.', '/')}.py"
            if name.startswith(("tests.", "tools.")) and source.exists() and source not in known:
                _imported(source, known)


@pytest.mark.parametrize("name", groups.EVERY_CHANGE)
def test_group_covers_what_its_tests_import(name: str, stamps: Path) -> None:
    missing: dict[str, list[str]] = {}
    left_out = plans.plan([name]).arguments
    for own in groups.GROUPS[name].tests:
        for file in [TREE / own] if own.endswith(".py") else (TREE / own).rglob("test_*.py"):
            known: set[Path] = set()
            _imported(file, known)
            test = str(file.relative_to(TREE))
            if f"--ignore={test}" in left_out:
                continue
            left = groups.not_covered(test, [str(path.relative_to(TREE)) for path in known])
            if left:
                missing[test] = left
    assert missing == {}
