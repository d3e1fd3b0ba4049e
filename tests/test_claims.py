"""The tests and commands that documents name are there: of each claim, each fault, each row."""

from __future__ import annotations

import functools
import os
import re
from pathlib import Path

import pytest

from tests.test_dev import named_and_gone

TREE = Path(__file__).parent.parent
DOCS = TREE / "docs"
ROW = re.compile(r"^\| (?!---|claim \||fault \||treatment \|)(.*) \|$", re.MULTILINE)
FILE = re.compile(r"`([\w/.]+\.(?:cpp|py|mjs))`")
# A file by its path or its name, then names of its tests.
NAMED = re.compile(r'`([\w/.]+\.(?:cpp|py|mjs))`((?: (?:"[^"]+"|`test_\w+`))*)')


@functools.cache
def _tests_by_name() -> dict[str, list[Path]]:
    found: dict[str, list[Path]] = {}
    for folder, folders, names in os.walk(TREE / "tests"):
        folders[:] = [name for name in folders if name != "node_modules"]
        for name in names:
            found.setdefault(name, []).append(Path(folder, name))
    return found


def file_of(name: str) -> Path:
    """Return the file that a document names, by its path or its name."""
    found = [TREE / name] if "/" in name else _tests_by_name().get(name, [])
    assert found, f"{name} is nowhere below tests/"
    assert found[0].is_file(), f"there is no {name}"
    return found[0]


def missing(text: str) -> list[str]:
    """Return the tests that a text names and that are not there."""
    gone = []
    for name, tests in NAMED.findall(text):
        # A title may go over two lines of its source.
        source = re.sub(r'"\s*\n\s*"', "", file_of(name).read_text(encoding="utf-8"))
        for title in re.findall(r'"([^"]+)"', tests):
            if not re.search(rf'TEST_CASE\(\s*"{re.escape(title)}"', source):
                gone.append(f'{name}: "{title}"')
        gone += [
            f"{name}: {test}"
            for test in re.findall(r"`(test_\w+)`", tests)
            if f"def {test}(" not in source
        ]
    return gone


@pytest.mark.parametrize("document", ["security", "reliability", "threads"])
def test_tests_that_a_document_names_are_there(document: str) -> None:
    text = (DOCS / f"explanation/{document}.md").read_text(encoding="utf-8")
    assert missing(text) == []


def test_each_claim_about_who_may_do_what_has_a_test() -> None:
    rows = ROW.findall((DOCS / "explanation/security.md").read_text(encoding="utf-8"))
    assert len(rows) >= 40
    without = [row for row in rows if not FILE.search(row.rpartition(" | ")[2])]
    assert without == []
    # A file alone is enough of a fuzz target only.
    vague = [
        name
        for row in rows
        for name, tests in NAMED.findall(row)
        if not tests and not name.startswith("tests/fuzz/")
    ]
    assert vague == []


def test_commands_that_the_documents_name_are_there() -> None:
    documents = [*TREE.glob("*.md"), *(TREE / "docs").rglob("*.md")]
    assert len(documents) > 15
    for document in documents:
        # A sentence may go on behind a command, but not within its quotes.
        text = document.read_text(encoding="utf-8")
        quoted = re.findall(r"`(\./dev [^`]*)`", text) + re.findall(r"^ {4}(\./dev .*)", text, re.M)
        assert named_and_gone("\n".join(quoted)) == set(), document.name
