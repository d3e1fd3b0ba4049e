"""The `torsio` command, as it is installed."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import torsio

COMMAND = str(Path(sys.executable).with_name("torsio"))


def run(*arguments: str, status: int = 0, **options: Any) -> subprocess.CompletedProcess[str]:
    result = subprocess.run(
        [COMMAND, *arguments], capture_output=True, text=True, timeout=120, check=False, **options
    )
    assert result.returncode == status, result.stdout + result.stderr
    assert "Traceback" not in result.stderr
    return result


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any], str]:
    folder = tmp_path_factory.mktemp("demo")
    result = run("demo", "wall", "--out", str(folder))
    return folder, json.loads((folder / "virtual_wall.json").read_text()), result.stdout


def test_version_is_that_of_the_package() -> None:
    assert run("--version").stdout == f"torsio {torsio.__version__}\n"


def test_list_shows_the_emulated_knob() -> None:
    assert "emulated" in run("list").stdout


def test_list_json_has_the_fields_of_a_listed_device() -> None:
    devices = json.loads(run("list", "--json").stdout)
    assert devices[-1]["path"] == "emulated"
    assert devices[-1]["problem"] == ""


def test_info_json_tells_identity_health_and_configuration() -> None:
    info = json.loads(run("info", "--json").stdout)
    assert set(info) == {"info", "health", "clock", "actuator_config", "control_config"}
    assert info["info"]["fingerprint"] == torsio.protocol.fingerprint()
    assert info["control_config"]["law"] == "paper"


def test_info_shows_the_same_as_a_table() -> None:
    assert "control_rate_hz" in run("info").stdout


@pytest.mark.parametrize(
    "arguments",
    [
        ("info", "--device", "/dev/hidraw250"),
        ("demo", "wall", "--device", "TS-9999"),
    ],
)
def test_missing_device_is_one_sentence_and_status_1(arguments: tuple[str, ...]) -> None:
    result = run(*arguments, status=1)
    assert result.stdout == ""
    assert result.stderr.startswith("torsio: error: there is no knob")
    assert len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    "arguments", [("dance",), ("info", "--colour"), ("demo", "wall", "--seed", "-1"), ("demo",)]
)
def test_usage_error_has_status_2(arguments: tuple[str, ...]) -> None:
    run(*arguments, status=2)


def test_unwritable_folder_is_one_sentence_and_status_1(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    result = run("demo", "wall", "--out", str(tmp_path / "file" / "out"), status=1)
    assert result.stderr.startswith("torsio: error: ")
    assert len(result.stderr.splitlines()) == 1


def test_demo_follows_the_wall(demo: tuple[Path, dict[str, Any], str]) -> None:
    _, measures, output = demo
    assert measures["law"] == "paper"
    assert measures["control_rate_hz"] == 1000
    assert measures["beta"] == 0.5
    assert measures["wall_stiffness_nm_per_rad"] == pytest.approx(math.degrees(25e-3))
    assert measures["peak_torque_nm"] == pytest.approx(75e-3, rel=0.02)
    assert 0 < measures["tracking_rms_in"] <= 0.07
    assert 0 < measures["tracking_rms_out"] <= 0.09
    assert 0 < measures["torque_gap_nm"] < 20e-3
    assert 0 < measures["sensor_rms_nm"] <= 4.5e-3
    assert measures["final_angle_rad"] < measures["wall_angle_rad"]
    assert measures["left_wall"] is True
    assert measures["samples"] == 2400
    assert measures["samples_lost"] == 0
    assert measures["realtime_factor"] > 10
    assert "It feels like a wall" in output
    assert "tracking, way in" in output


def test_demo_picture_is_a_large_png(demo: tuple[Path, dict[str, Any], str]) -> None:
    data = (demo[0] / "virtual_wall.png").read_bytes()
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    width, height = (int.from_bytes(data[n : n + 4], "big") for n in (16, 20))
    assert width >= 1800
    assert height >= 1400


def test_demo_is_the_same_again_but_for_its_speed(
    demo: tuple[Path, dict[str, Any], str], tmp_path: Path
) -> None:
    file = tmp_path / "numbers" / "wall.json"
    run("demo", "wall", "--out", str(tmp_path), "--json", str(file))
    again = json.loads(file.read_text())
    assert again | {"realtime_factor": 0} == demo[1] | {"realtime_factor": 0}
    assert not (tmp_path / "virtual_wall.json").exists()


def test_demo_without_arguments_writes_into_out(tmp_path: Path) -> None:
    run("demo", "wall", cwd=tmp_path)
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["virtual_wall.json", "virtual_wall.png"]


def test_interrupted_demo_has_status_130(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    process = subprocess.Popen(
        [COMMAND, "demo", "wall", "--paced", "--out", str(folder)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    try:
        deadline = time.monotonic() + 60
        while not folder.exists() and time.monotonic() < deadline:
            time.sleep(0.01)
        time.sleep(0.3)  # into the visit, which takes 2.4 s
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=20)
    finally:
        process.kill()
    assert errors.splitlines() == ["torsio: interrupted; the knob is disarmed"]
    assert process.returncode == 130
    assert list(folder.iterdir()) == []
