"""Files that only look like results, and studies that lack a package."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from torsio_studies import common
from torsio_studies.execution import execute


@pytest.mark.parametrize(
    "text",
    ["[" * 100_000, '{"a":' * 100_000, '{"study": ' + "9" * 5000 + "}", "{", "\x00", "[1]", "3"],
    ids=["deep list", "deep object", "long number", "cut", "zero", "list", "number"],
)
def test_file_that_holds_no_results_is_named_in_one_sentence(text: str, tmp_path: Path) -> None:
    path = tmp_path / "paper.json"
    path.write_text(text)
    with pytest.raises(common.StudyError, match=r"paper\.json"):
        common.load(path, "paper")


def test_study_without_a_package_says_which(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("torsio_studies.fidelity")]:
        monkeypatch.delitem(sys.modules, name)
    for name in [name for name in sys.modules if name.partition(".")[0] == "scipy"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "scipy", None)
    with pytest.raises(
        common.StudyError, match="needs the Python package scipy: pip install scipy"
    ):
        execute("fidelity")
