"""``./dev`` and packages, requirements, stamps and other systems, without installing anything."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from tools import windows
from tools.dev import benches, building, cli, groups, plans

TREE = Path(__file__).parent.parent


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


@pytest.mark.parametrize("name", groups.GROUPS)
def test_digest_of_a_group_is_of_files_that_are_there(name: str) -> None:
    group = groups.GROUPS[name]
    assert [path for path in (*group.covers, *group.tests) if not (TREE / path).exists()] == []


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
