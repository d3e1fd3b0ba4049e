"""`torsio report`: one file with what a helper needs, and nothing of the user."""

from __future__ import annotations

import getpass
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import torsio
from torsio import bug_report, documents

RUN = "import sys; from torsio.__main__ import main; main()"


def _report(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", RUN, "report", *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_report_holds_doctor_versions_and_a_recording(tmp_path: Path) -> None:
    file = tmp_path / "report.zip"
    done = _report(file, "--device", "emulated", "--seconds", "0.5")
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(file) as archive:
        names = ["README.txt", "doctor.json", "versions.json", "recording.mcap"]
        assert archive.namelist() == names
        assert all(name in done.stdout for name in names)
        found = json.loads(archive.read("doctor.json"))
        assert found[0]["device"] == "emulated"
        versions = json.loads(archive.read("versions.json"))
        assert versions["fingerprint"] == f"0x{torsio.protocol.fingerprint():08x}"
        assert versions["packages"]["torsio"] == torsio.__version__
        for name in ("doctor.json", "versions.json"):
            text = archive.read(name).decode()
            assert str(Path.home()) + "/" not in text
            assert "file://" not in text
            assert str(Path(__file__).parents[2]) not in text
            if getpass.getuser() != "root":
                assert getpass.getuser() not in text
        archive.extract("recording.mcap", tmp_path)
    recorded = torsio.load(tmp_path / "recording.mcap")
    assert recorded.whole
    assert len(recorded.telemetry) >= 490
    assert recorded.metadata["versions"]["fingerprint"] == torsio.protocol.fingerprint()


def test_links_of_findings_name_no_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(documents.VARIABLE, raising=False)
    link = documents.entry("clock")
    assert link.startswith("file:///")  # this package comes from a clone
    text = bug_report._impersonal(json.dumps({"more": link, "links": [link, "clock"]}))
    ours = "docs/troubleshooting.md#clock"
    assert json.loads(text) == {"more": ours, "links": [ours, "clock"]}


def test_recording_that_was_made_before_is_taken_as_it_is(tmp_path: Path) -> None:
    file, recording = tmp_path / "report.zip", tmp_path / "x.mcap"
    with torsio.open("emulated") as knob, knob.record_to(recording):
        knob.sleep(0.1)
    done = _report(file, "--device", "emulated", "--recording", recording)
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(file) as archive:
        assert archive.read("recording.mcap") == recording.read_bytes()
    recording.write_bytes(b"hello")
    file.unlink()
    done = _report(file, "--device", "emulated", "--recording", recording)
    assert done.returncode == 1
    assert "is no recording of Torsio" in done.stderr
    assert not file.exists()


def test_report_without_a_knob_says_so(tmp_path: Path) -> None:
    file = tmp_path / "report.zip"
    done = _report(file, "--device", "/dev/hidraw999")
    assert done.returncode == 0, done.stderr
    assert "no knob could be recorded" in done.stderr
    with zipfile.ZipFile(file) as archive:
        assert not json.loads(archive.read("doctor.json"))[0]["ok"]
