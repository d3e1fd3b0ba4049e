"""The `torsio` command, as it is installed."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

import torsio
from tests.faults.knobs import device
from torsio.apps.cli import app
from torsio.apps.commands import other as other_commands
from torsio.demos import wall

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


def test_list_shows_the_emulated_knob() -> None:
    assert "emulated" in run("list").stdout


def test_list_json_has_the_fields_of_a_listed_device() -> None:
    devices = json.loads(run("list", "--json").stdout)
    assert devices[-1]["path"] == "emulated"
    assert devices[-1]["problem"] == ""


def test_info_json_tells_identity_health_and_configuration() -> None:
    info = json.loads(run("info", "--json").stdout)
    assert set(info) == {
        *("info", "health", "clock", "limits"),
        *("actuator_config", "control_config", "board_config", "game_config"),
        *("shaft_config", "calibration_config"),
    }
    assert info["calibration_config"]["values_are"] == "assumed"
    assert info["board_config"]["motor_pin"] == 6
    assert info["game_config"]["range_deg"] == 900
    assert info["info"]["fingerprint"] == torsio.protocol.fingerprint()
    assert info["control_config"]["law"] == "paper"


def test_info_shows_the_same_as_a_table() -> None:
    printed = run("info").stdout
    for name in ("control_rate_hz", "motor_torque_max_nm", "beta", "motor_pin", "range_deg"):
        assert name in printed


@pytest.mark.parametrize("arguments", [("info", "--json"), ("demo", "wall", "--json")])
def test_without_a_real_knob_it_is_the_emulated_one_and_that_is_said(
    arguments: tuple[str, ...], tmp_path: Path
) -> None:
    result = run(*arguments, cwd=tmp_path)
    first = result.stderr.splitlines()[0]
    assert first == (
        "knob     emulated, serial number EMULATED; no real knob is plugged in; "
        "settings are forgotten"
    )


@pytest.mark.parametrize("command", [("info",), ("demo", "wall")])
@pytest.mark.parametrize("arguments", [(), ("--device", "emulated")])
def test_real_knob_is_taken_unless_another_is_named(
    command: tuple[str, ...], arguments: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    real = torsio.ListedDevice("/dev/hidraw3", "TS-1", "haptic knob", "pico2", "hid", "")
    asked: list[tuple[str | None, bool]] = []

    def refuse(selector: str | None, *, emulator: torsio.EmulatorOptions | None) -> None:
        asked.append((selector, emulator is not None))
        raise torsio.DeviceBusy("in use")

    monkeypatch.setattr(torsio, "list_devices", lambda: [real])
    monkeypatch.setattr(torsio, "open", refuse)
    result = CliRunner().invoke(app, [*command, *arguments])
    assert result.exit_code == 1
    assert asked == [("emulated", command[0] == "demo") if arguments else (None, False)]


def test_options_of_the_emulated_knob_are_refused_while_a_real_one_would_be_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    real = torsio.ListedDevice("/dev/hidraw3", "TS-1", "haptic knob", "pico2", "hid", "")
    monkeypatch.setattr(torsio, "list_devices", lambda: [real])
    result = CliRunner().invoke(app, ["demo", "wall", "--seed", "3"])
    assert result.exit_code == 2
    assert "add --device emulated" in result.stderr


def test_help_says_of_each_word_what_it_is_and_of_none_that_it_is_always_there() -> None:
    commands: list[Any] = [typer.main.get_command(app)]
    wrong = []
    while commands:
        command = commands.pop()
        commands += vars(command).get("commands", {}).values()
        for each in command.params:
            is_on = getattr(each, "is_flag", False) and each.default is True
            if not each.help or (is_on and not each.secondary_opts):
                wrong.append(f"{command.name}: {each.name}")
    assert wrong == []


def test_module_runs_as_the_command_does() -> None:
    words = [sys.executable, "-m", "torsio", "list", "--json"]
    result = subprocess.run(words, capture_output=True, text=True, check=True)
    assert result.stdout == run("list", "--json").stdout
    usage = subprocess.run(
        [sys.executable, "-m", "torsio", "-h"], capture_output=True, text=True, check=True
    )
    assert "Usage: torsio " in usage.stdout


def test_shell_completes_commands() -> None:
    environment = {
        **os.environ,
        "_TORSIO_COMPLETE": "complete_bash",
        "COMP_WORDS": "torsio in",
        "COMP_CWORD": "1",
    }
    assert run(env=environment).stdout.split() == ["info"]


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
    "arguments",
    [
        ("dance",),
        ("demo",),
        ("demo", "wall", "--device", "TS-9999", "--paced"),
        ("demo", "wall", "--device", "TS-9999", "--seed", "1"),
        ("demo", "wall", "--json", "numbers.json"),
        ("demo", "wall", "--seed", "-1"),
        ("stop", "--device", ""),
        ("info", "--colour"),
    ],
)
def test_usage_error_has_status_2(arguments: tuple[str, ...]) -> None:
    run(*arguments, status=2)


@pytest.mark.parametrize(
    "arguments",
    [
        ("--out", "file/out"),
        ("-o", "taken"),
        ("-o", "taken_too"),
        ("--out", "linked"),
    ],
)
def test_place_that_cannot_be_written_is_named_before_the_visit(
    tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "taken" / "virtual_wall.png").mkdir(parents=True)
    (tmp_path / "taken_too" / "virtual_wall.json").mkdir(parents=True)
    (tmp_path / "linked").mkdir()
    (tmp_path / "linked" / "virtual_wall.json").symlink_to("/dev/stdout")
    before = sorted(tmp_path.rglob("*"))
    result = run("demo", "wall", *arguments, status=1, cwd=tmp_path)
    assert result.stderr.startswith("torsio: error: --out: ")
    assert result.stderr.endswith("choose another place\n")
    assert len(result.stderr.splitlines()) == 1
    assert result.stdout == ""
    assert sorted(tmp_path.rglob("*")) == before


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
    # JNDs of 12.7 % at 60 mN m; a count is 360/8192 degrees in a wall of 25 mN m per degree.
    assert measures["jnds"]["torque_gap"] == pytest.approx(measures["torque_gap_nm"] / 7.62e-3)
    assert measures["jnds"]["count_step"] == pytest.approx(25e-3 * 360 / 8192 / 7.62e-3)
    assert measures["final_angle_rad"] < measures["wall_angle_rad"]
    assert measures["left_wall"] is True
    assert measures["samples"] == 2400
    assert measures["samples_lost"] == 0
    assert measures["realtime_factor"] > 0
    assert "It feels like a wall" in output
    assert "tracking, way in" in output


def test_demo_json_to_standard_output_is_all_that_is_there(
    demo: tuple[Path, dict[str, Any], str], tmp_path: Path
) -> None:
    result = run("demo", "wall", "--out", str(tmp_path), "--json")
    measures = json.loads(result.stdout)
    assert measures == json.loads((tmp_path / "virtual_wall.json").read_text())
    assert measures | {"realtime_factor": 0} == demo[1] | {"realtime_factor": 0}
    assert "It feels like a wall" in result.stderr
    assert (tmp_path / "virtual_wall.png").exists()


def test_demo_that_is_not_as_it_should_be_has_status_1_and_writes_its_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(wall, "GOOD_TRACKING_OUT", 0.001)
    result = CliRunner().invoke(app, ["demo", "wall", "--out", str(tmp_path)])
    assert result.exit_code == 1
    assert "Not as it should be" in result.stdout
    assert result.stderr.startswith("torsio: error: it does not feel like a wall: tracking on the ")
    assert len(result.stderr.splitlines()) == 1
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["virtual_wall.json", "virtual_wall.png"]


@pytest.mark.parametrize(
    ("interrupted", "arguments", "message"),
    [
        ("torsio.list_devices", ("list",), "torsio: interrupted"),
        ("torsio.open", ("info",), "torsio: interrupted"),
        ("torsio.Knob.health", ("info",), "torsio: interrupted; the knob is disarmed"),
        ("time.sleep", ("arm",), "torsio: interrupted; the knob is disarmed"),
        # A real knob's prompt
        ("builtins.input", ("demo", "wall"), "torsio: interrupted; the knob is disarmed"),
    ],
)
def test_interrupt_has_status_130_and_speaks_of_a_knob_only_if_one_was_open(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    interrupted: str,
    arguments: tuple[str, ...],
    message: str,
) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(torsio.Knob, "is_emulated", False)
    monkeypatch.setattr(interrupted, interrupt)
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 130
    assert result.stderr == message + "\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("command", "state"), [("info", "armed"), ("arm", "disarmed")])
def test_interrupt_says_whether_an_autonomous_knob_plays_on(
    monkeypatch: pytest.MonkeyPatch, command: str, state: str
) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    def armed(*given: Any, **named: Any) -> torsio.Knob:
        knob = real(*given, **named)
        knob.update(autonomous=True)
        knob.arm()
        return knob

    real = torsio.open
    monkeypatch.setattr(torsio, "open", armed)
    monkeypatch.setattr(torsio.Knob, "health", interrupt)
    monkeypatch.setattr(time, "sleep", interrupt)
    result = CliRunner().invoke(app, [command, "--device", "emulated"])
    assert result.exit_code == 130
    assert result.stderr == f"torsio: interrupted; the knob is {state}\n"


@pytest.mark.parametrize(
    ("interrupted", "arguments"),
    [("Knob.health", ("info",)), ("Knob.faults", ("arm",)), ("Knob.telemetry", ("demo", "wall"))],
)
def test_interrupted_command_orders_before_it_asks(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    interrupted: str,
    arguments: tuple[str, ...],
) -> None:
    def interrupt(*_: object, **__: object) -> None:
        knob.arm()
        monkeypatch.setattr(torsio.Knob, "state", property(ask))
        raise KeyboardInterrupt

    def ask(_: torsio.Knob) -> str:
        armed.append(made.is_armed)
        return "disarmed"

    armed: list[bool] = []
    made = device(paced=False)
    knob = torsio.open(made)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(torsio, "open", lambda *_, **__: knob)
    monkeypatch.setattr(time, "sleep", interrupt)
    monkeypatch.setattr(f"torsio.{interrupted}", interrupt)
    assert CliRunner().invoke(app, arguments, input="\n").exit_code == 130
    assert armed
    assert not any(armed)


def test_file_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    file = tmp_path / "none" / "a.mcap"
    result = CliRunner().invoke(app, ["record", str(file), "--device", "emulated"])
    assert result.exit_code == 1
    assert result.stderr.endswith(f"torsio: error: {file}: No such file or directory\n")


def test_study_says_what_to_install_where_the_studies_are_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(other_commands, "entry_points", lambda group: ())
    bare = typer.Typer()
    bare.command("list")(lambda: None)
    other_commands.add_commands(bare)
    for arguments in ([], ["paper"], ["design", "--devices", "9", "--help"]):
        result = CliRunner().invoke(bare, ["study", *arguments])
        assert result.exit_code == 1
        assert result.stderr.endswith("in a clone of the project: pip install ./studies\n")
        assert result.stdout == ""
    assert "Not installed" in CliRunner().invoke(bare, ["--help"]).output
