"""`torsio report`: one file with what a helper needs, and nothing of the user."""

from __future__ import annotations

import getpass
import json
import zipfile
from pathlib import Path

import pytest

import torsio
from tests.python.processes import command
from torsio.apps import bug_report


def test_report_holds_doctor_versions_and_a_recording(tmp_path: Path) -> None:
    file = tmp_path / "report.zip"
    done = command("report", file, "--device", "emulated", "--seconds", "0.5")
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(file) as archive:
        names = ["README.txt", "doctor.json", "versions.json", "recording.mcap"]
        assert archive.namelist() == names
        assert done.stdout == f"report  {file} ({', '.join(names)})\n"
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


def test_recording_that_was_made_before_is_taken_as_it_is(tmp_path: Path) -> None:
    file, recording = tmp_path / "report.zip", tmp_path / "x.mcap"
    with torsio.open("emulated") as knob, knob.record_to(recording):
        knob.sleep(0.1)
    done = command("report", file, "--device", "emulated", "--recording", recording)
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(file) as archive:
        assert archive.read("recording.mcap") == recording.read_bytes()
    recording.write_bytes(b"hello")
    file.unlink()
    done = command("report", file, "--device", "emulated", "--recording", recording)
    assert done.returncode == 1
    assert "is no recording of Torsio" in done.stderr
    assert not file.exists()


def test_report_without_a_knob_says_so(tmp_path: Path) -> None:
    file = tmp_path / "report.zip"
    done = command("report", file, "--device", "/dev/hidraw999")
    assert done.returncode == 0, done.stderr
    assert "no knob could be recorded" in done.stderr
    with zipfile.ZipFile(file) as archive:
        assert not json.loads(archive.read("doctor.json"))[0]["ok"]


def test_report_where_none_can_be_names_the_place_as_it_was_given(tmp_path: Path) -> None:
    file = tmp_path / "none" / "report.zip"
    done = command("report", file, "--device", "/dev/hidraw999")
    assert done.returncode == 1
    assert str(file) in done.stderr.replace("\n", "")
    assert ".part" not in done.stderr


def test_who_has_neither_name_nor_folder_is_impersonal_as_they_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As in a container, which runs under a number that nobody has."""

    def nobody(number: int) -> None:
        raise KeyError(f"getpwuid(): uid not found: {number}")

    monkeypatch.setattr("pwd.getpwuid", nobody)
    for name in ("LOGNAME", "USER", "LNAME", "USERNAME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    assert bug_report._impersonal("/etc/fstab") == "/etc/fstab"
    monkeypatch.setenv("HOME", "/")
    assert bug_report._impersonal("/etc/fstab") == "/etc/fstab"
    monkeypatch.setenv("HOME", "/home/somebody")
    assert bug_report._impersonal("/home/somebody/knob") == "~/knob"
