"""Files that only look like results, and studies that lack a package."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from tests.faults import faults
from tests.python.test_readers import Reader, check
from tests.studies.files import Batch
from torsio_studies import common
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
    kept, batch = Store(tmp_path, {}), Batch()
    kept.write(batch, [{"a": 1.0}, {"a": 2.0}])
    path = kept.path(batch)

    def read() -> str:
        return f"{len(kept.intact([batch]))} {kept.read([batch])}"

    check(Reader(path, path.read_bytes(), read, is_sealed=True), monkeypatch)


def test_store_that_would_fill_the_memory_is_told_before_it_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept, batch = Store(tmp_path, {}), Batch()
    kept.write(batch, [{"a": 0.0}])
    zeros = pyarrow.table({"a": np.zeros(10_000_001)})
    parquet.write_table(zeros, kept.path(batch))
    assert kept.path(batch).stat().st_size < 100_000
    monkeypatch.setattr(parquet.ParquetFile, "read", None)
    with pytest.raises(common.StudyError, match="is damaged: delete it"):
        kept.read([batch])


def test_file_operation_of_a_store_that_fails_once_is_told_and_loses_nothing() -> None:
    outcomes = list(faults.of_files(3, "study's store", module="tests.studies.files"))
    assert outcomes
    assert [outcome for outcome in outcomes if outcome[2]] == []
