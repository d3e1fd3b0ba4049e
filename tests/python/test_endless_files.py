"""A file without an end is told in a sentence by whoever reads it, and fills no memory."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

import torsio
from torsio import whole_file
from torsio.calibration import keeping
from torsio.cli import app
from torsio_studies import common

READERS: dict[str, Callable[[Path], object]] = {
    "results": lambda path: common.load(path, "paper"),
    "calibration": lambda path: keeping.kept(path.stem),
}


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(whole_file, "_MOST_BYTES", 1 << 20)


@pytest.mark.parametrize("reader", READERS)
def test_endless_file_is_told(reader: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "endless.json"
    path.symlink_to("/dev/zero")
    monkeypatch.setattr(keeping, "place_of", lambda _: path)
    with pytest.raises(torsio.Error, match=r"endless\.json cannot be read"):
        READERS[reader](path)


def test_endless_configuration_is_told(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["config", "load", "/dev/zero", "--device", "emulated"])
    assert result.exit_code == 1
    assert "torsio: error: " in result.output
    assert "/dev/zero" in result.output


def test_file_that_is_just_small_enough_is_read(tmp_path: Path) -> None:
    file = tmp_path / "x"
    file.write_bytes(bytes(1 << 20))
    assert len(whole_file.content(file)) == 1 << 20
    file.write_bytes(bytes((1 << 20) + 1))
    with pytest.raises(OSError, match="more than 1 MiB"):
        whole_file.content(file)
