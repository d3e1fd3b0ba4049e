"""``./dev fuzz`` around its targets; ``tests/test_cpp.py`` runs each of them shortly."""

from __future__ import annotations

from pathlib import Path

from tests.fuzz import fuzz

TREE = Path(__file__).parent.parent


def test_every_target_has_a_corpus_and_is_built() -> None:
    cmake = (TREE / "tests/fuzz/CMakeLists.txt").read_text(encoding="utf-8")
    for target in fuzz.targets():
        assert any((TREE / "tests/fuzz/corpus" / target).iterdir()), target
        assert target in cmake
