"""Studies keep earlier results whatever happens, and say what is wrong."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console
from typer.testing import CliRunner

from torsio.apps.cli import app
from torsio_studies import STUDIES, common
from torsio_studies.common import StudyError
from torsio_studies.execution import execute
from torsio_studies.paper import study as paper


def results(**own: Any) -> dict[str, Any]:
    return {"schema": common.SCHEMA, "study": "paper", **own}


def test_results_come_back_as_they_were_saved(tmp_path: Path) -> None:
    file = tmp_path / "new" / "paper.json"
    common.save(results(value=1.5, nothing=float("nan")), file)
    assert common.load(file, "paper") == results(value=1.5, nothing=None)
    assert [path.name for path in file.parent.iterdir()] == ["paper.json"]


@pytest.mark.parametrize(
    ("content", "why"),
    [
        ('{"schema": 1, "study": "pap', "damaged"),
        ("", "damaged"),
        ("[1, 2]", "does not hold"),
        (json.dumps({"schema": 1, "study": "extremes"}), "does not hold"),
        (json.dumps({"schema": 99, "study": "paper"}), "schema 99"),
    ],
)
def test_a_damaged_or_foreign_file_is_left_alone(tmp_path: Path, content: str, why: str) -> None:
    file = tmp_path / "paper.json"
    file.write_text(content)
    with pytest.raises(StudyError, match=why):
        execute("paper", json_file=file, quick=True)
    assert file.read_text() == content


def test_a_full_disk_keeps_the_earlier_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "paper.json"
    common.save(results(value=1), file)

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(StudyError, match="the disk is full; what was there before is kept"):
        common.save(results(value=2), file)
    assert common.load(file, "paper")["value"] == 1
    assert [path.name for path in tmp_path.iterdir()] == ["paper.json"]


def test_an_unknown_study_is_an_error_that_lists_those_there_are() -> None:
    with pytest.raises(StudyError, match=r"nonsense.*extremes.*paper"):
        execute("nonsense")


def test_every_study_has_its_command_and_its_page() -> None:
    listed = CliRunner().invoke(app, ["study", "--help"])
    assert listed.exit_code == 0
    pages = Path(__file__).parents[2] / "docs" / "results"
    for name in STUDIES:
        assert name in listed.output
        assert (pages / f"{name}.md").exists()


def test_json_to_standard_output_is_all_that_goes_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    def run(study: common.Study) -> common.Results:
        list(study.track(range(3), "counting"))
        return {"value": 1.5, "nothing": float("nan")}

    def show(results: common.Results, console: Console) -> None:
        console.print("a table of", results["value"])

    monkeypatch.setattr(paper, "run", run)
    monkeypatch.setattr(paper, "show", show)
    outcome = CliRunner().invoke(app, ["study", "paper", "--json"])
    assert outcome.exit_code == 0
    printed = json.loads(outcome.stdout)
    assert printed["study"] == "paper"
    assert printed["value"] == 1.5
    assert printed["nothing"] is None
    assert "a table of" in outcome.stderr
    assert "Written in" in outcome.stderr
    assert json.loads((tmp_path / "out" / "paper.json").read_text()) == printed
