"""A disk that is full in the middle of a file: one sentence, and nothing that looks whole."""

from __future__ import annotations

import json
import os
import resource
import signal
import stat
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import torsio
from tests.faults.knobs import device
from torsio.apps.cli import app
from torsio.common import whole_file
from torsio.common.whole_file import beside
from torsio.recordings import file as recording_file
from torsio.telemetry import TELEMETRY_DTYPE

ROOM_BYTES = 6000


@contextmanager
def full_disk(most_bytes: int = ROOM_BYTES) -> Iterator[None]:
    """Let no file grow beyond a few thousand bytes, as on a full disk.

    Nor does Python write what it compiles: it would read the part that fits as the whole.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    writes, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        sys.dont_write_bytecode = writes
        signal.signal(signal.SIGXFSZ, before)


def says_so(*arguments: str) -> str:
    """Run a command on a full disk, and return what it says."""
    with full_disk():
        result = CliRunner().invoke(app, list(arguments))
    assert result.exit_code == 1, (result.output, result.exception)
    lines = [line for line in result.stderr.splitlines() if line.startswith("torsio: error: ")]
    assert len(lines) == 1, result.stderr
    assert "Traceback" not in result.output
    return lines[0]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recording") / "whole.mcap"
    with torsio.open("emulated") as knob, knob.record_to(path):
        knob.arm()
        knob.sleep(2.0)
    return path


def test_recording_on_a_full_disk_says_so_and_has_what_came_before(tmp_path: Path) -> None:
    path = tmp_path / "torn.mcap"
    said = says_so("record", str(path), "--device", "emulated", "--seconds", "3")
    assert "large" in said or "space" in said
    assert not torsio.load(path).whole


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_table_on_a_full_disk_leaves_the_one_that_was_there(
    recording: Path, tmp_path: Path, ending: str
) -> None:
    table = tmp_path / f"table.{ending}"
    table.write_text("of yesterday")
    says_so("export", str(recording), str(table))
    assert table.read_text() == "of yesterday"
    assert list(tmp_path.iterdir()) == [table]


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o444, 0o666])
def test_table_has_the_mode_of_the_one_that_was_there(
    recording: Path, tmp_path: Path, mode: int
) -> None:
    table = tmp_path / "table.csv"
    table.touch()
    table.chmod(mode)
    torsio.load(recording).save(table)
    assert table.stat().st_mode & 0o777 == mode
    assert table.stat().st_size > 1000


def test_new_table_has_the_mode_of_any_new_file(recording: Path, tmp_path: Path) -> None:
    torsio.load(recording).save(tmp_path / "table.csv")
    (tmp_path / "other").touch()
    assert (tmp_path / "table.csv").stat().st_mode == (tmp_path / "other").stat().st_mode


def test_file_of_one_user_is_read_by_no_other_while_it_is_written(tmp_path: Path) -> None:
    (tmp_path / "x").touch(0o600)
    with beside(tmp_path / "x") as part:
        part.write_text("whole")
        assert part.stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("name", ["x" * 251 + ".csv", "\u00e4" * 125 + ".csv", "x." + "y" * 253])
def test_name_may_be_as_long_as_names_are(tmp_path: Path, name: str) -> None:
    assert len(name.encode()) > 250
    with beside(tmp_path / name) as part:
        part.write_text("whole")
    assert [file.name for file in tmp_path.iterdir()] == [name]


def test_report_on_a_full_disk_leaves_none(recording: Path, tmp_path: Path) -> None:
    path = tmp_path / "report.zip"
    says_so("report", str(path), "--device", "emulated", "--recording", str(recording))
    assert list(tmp_path.iterdir()) == []


def test_demo_on_a_full_disk_leaves_nothing(tmp_path: Path) -> None:
    says_so("demo", "wall", "--out", str(tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_map_on_a_full_disk_leaves_none(tmp_path: Path) -> None:
    says_so("stability", "--quick", "--picture", str(tmp_path / "map.png"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "command",
    ["stability --device emulated --quick", "calibrate --device emulated --drift",
     "trade scene.py --quick --no-extremes --parts cogging"],
)  # fmt: skip
def test_result_is_printed_though_its_picture_cannot_be_drawn(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scene.py").write_text(
        "import torsio\nscene = torsio.Wall(angle_rad=0.3, stiffness_nm_per_rad=2.0)\n"
    )
    Path("x.png").mkdir()
    result = CliRunner().invoke(app, [*command.split(), "--json", "--picture", "x.png"])
    assert result.exit_code == 1, result.output
    assert "x.png: Is a directory" in result.stderr
    assert json.loads(result.stdout)


@pytest.mark.parametrize("arguments", ["--help", "--version", "config dump", "doctor --json"])
@pytest.mark.parametrize(("where", "words"), [(">/dev/full", "No space left"), (">&-", "closed")])
def test_standard_output_that_takes_nothing_is_told(arguments: str, where: str, words: str) -> None:
    device = "" if arguments.startswith("--") else "--device emulated"
    result = subprocess.run(
        ["sh", "-c", f'"{sys.executable}" -m torsio {arguments} {device} {where}'],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert result.returncode == 1, result.stderr
    (line,) = [line for line in result.stderr.splitlines() if not line.startswith("knob ")]
    assert line.startswith("torsio: error: ")
    assert words in line


@pytest.mark.parametrize("paced", [False, True], ids=["virtual", "paced"])
def test_disk_that_is_slower_than_time_holds_it_up_or_costs_samples_that_are_counted(
    paced: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recording_file, "_MOST_WAITING_BYTES", 300 * TELEMETRY_DTYPE.itemsize)
    made, path, disk = device(paced=paced), tmp_path / "x.mcap", threading.Event()
    held_up_at_s: list[float] = []

    def hold_up() -> None:
        while not held_up_at_s or made.now_ns() > 1e9 * held_up_at_s[-1]:
            held_up_at_s.append(1e-9 * made.now_ns())
            time.sleep(0.3)
        disk.set()

    def write(_: object) -> None:
        disk.wait()

    with torsio.open(made) as knob, knob.record_to(path) as recording:
        recording.put(write, [None])
        if paced:
            got = sum(len(knob.record(0.1)) for _ in range(10))
            disk.set()
        else:
            other = threading.Thread(target=hold_up)
            other.start()
            knob.sleep(5.0)
            other.join()
    loaded = torsio.load(path)
    assert loaded.whole
    assert loaded.samples_lost == recording.samples_lost
    if paced:
        assert loaded.samples_lost > 0
        assert len(loaded.telemetry) + loaded.samples_lost >= got
    else:
        assert held_up_at_s[-1] < 2.0
        assert loaded.samples_lost == 0
        assert set(np.diff(loaded.telemetry["tick"].astype(np.int64))) == {1}
        assert len(loaded.telemetry) >= 5000


def test_recording_that_cannot_begin_leaves_the_file_that_was_there(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(b"of yesterday")
    with torsio.open("emulated") as knob:
        with full_disk(most_bytes=100), pytest.raises(OSError, match=r"x\.mcap"):
            knob.record_to(path)
        assert path.read_bytes() == b"of yesterday"
        assert [file.name for file in tmp_path.iterdir()] == ["x.mcap"]
        with knob.record_to(path):
            knob.sleep(0.1)
    assert len(torsio.load(path).telemetry) >= 100


def test_device_in_the_place_of_a_file_is_written_to_and_stays_one() -> None:
    one, other = os.openpty()
    with whole_file.beside(os.ttyname(other)) as place:
        place.write_text("written")
    assert os.read(one, 7) == b"written"
    assert stat.S_ISCHR(os.stat(os.ttyname(other)).st_mode)
