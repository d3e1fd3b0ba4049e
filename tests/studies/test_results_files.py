"""Files that only look like results, and studies that lack a package."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.python.test_readers import Reader, check
from torsio_studies import common
from torsio_studies.design.devices import Batch, Design
from torsio_studies.design.store import Store
from torsio_studies.execution import execute


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


def test_bad_results_are_told_in_a_sentence_and_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "x.json"
    common.save({"study": "x", "schema": common.SCHEMA, "rows": [1.0, 2.5]}, path)
    check(Reader(path, path.read_bytes(), lambda: common.load(path, "x")), monkeypatch)


def test_bad_store_is_told_in_a_sentence_and_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept, batch = Store(tmp_path, {}), Batch("x", 0, (Design(), Design()))
    kept.write(batch, [{"a": 1.0}, {"a": 2.0}])
    path = kept.path(batch)

    def read() -> str:
        return f"{len(kept.intact([batch]))} {kept.read([batch])}"

    check(Reader(path, path.read_bytes(), read, is_sealed=True), monkeypatch)
