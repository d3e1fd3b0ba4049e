"""The study `trade`: many scenes, each as `torsio.trade` has it."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

import torsio
from torsio_studies import cli, common
from torsio_studies.execution import execute

SCENE = """
import torsio
scene = torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad={stiffness})
plant = torsio.PlantParams(brake_hysteresis=torsio.BrakeHysteresis())
"""


def test_study_trades_every_file_and_goes_on_where_it_was(tmp_path: Path) -> None:
    files = []
    for name, stiffness in (("soft", 0.5), ("stiff", 3.0)):
        (tmp_path / name).mkdir()
        files.append(tmp_path / name / "scene.py")
        files[-1].write_text(SCENE.format(stiffness=stiffness))
    settings = {"files": files, "workers": 2}

    def run() -> common.Results:
        kept = tmp_path / "trade.json"
        return execute("trade", json_file=kept, out=tmp_path, quick=True, settings=settings)

    results = run()
    assert (tmp_path / "trade_scenes.png").stat().st_size > 20_000
    for file in files:
        alone = torsio.trade(file, quick=True, stretch=False)
        rows = {row["name"]: row for row in results["scenes"][str(file)]["rows"]}
        for row in alone.rows[:10]:
            assert rows[row.name]["largest_nm"] == row.difference.largest_nm
        assert any("Hysteresis changes" in one for one in results["words"][str(file)])
    kept = {path: path.read_text() for path in (tmp_path / "trade").iterdir()}
    assert len(kept) == 2
    again = run()
    for file in files:
        first, second = (one["scenes"][str(file)]["rows"][0] for one in (results, again))
        assert first == pytest.approx(second)


@pytest.mark.parametrize("holds", [True, False])
def test_status_is_0_only_if_every_proposal_holds(
    holds: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenes = {"one": {"holds": True}, "other": {"holds": holds}}
    monkeypatch.setattr(cli, "run", lambda *_: {"scenes": scenes})
    assert CliRunner().invoke(cli.app, ["trade"]).exit_code == (0 if holds else 1)
