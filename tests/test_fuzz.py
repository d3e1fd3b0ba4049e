"""``./dev fuzz`` around its targets; ``tests/test_cpp.py`` runs each of them shortly."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz import fuzz
from tests.fuzz.fuzz import Result

TREE = Path(__file__).parent.parent


def test_every_target_has_a_corpus_and_is_built() -> None:
    cmake = (TREE / "tests/fuzz/CMakeLists.txt").read_text(encoding="utf-8")
    for target in fuzz.targets():
        assert any((TREE / "tests/fuzz/corpus" / target).iterdir()), target
        assert target in cmake


def test_unknown_target_is_named_with_those_that_there_are(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert fuzz.main(["no_such", "3"]) == 2
    error = capsys.readouterr().err
    assert "no target 'no_such'" in error
    assert "vendor_reports" in error


def test_coverage_is_that_of_all_targets_together() -> None:
    one = Result("one", 0, "", {"sdk/a.cpp": {"all": {1, 2, 3, 4}, "reached": {1}}})
    two = Result("two", 0, "", {"sdk/a.cpp": {"all": {1, 2, 3, 4}, "reached": {2, 3}}})
    (line,) = fuzz.coverage([one, two])
    assert "3 of" in line
    assert " 75 %  sdk" in line
