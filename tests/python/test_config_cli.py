"""`torsio config`: reading and setting what a knob is made of."""

from __future__ import annotations

import dataclasses
import json
import time
from contextlib import nullcontext
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner

import torsio
from torsio.apps.cli import app
from torsio.apps.commands import shared
from torsio.common import screen
from torsio.printed.told import Limits

DEVICE = ["--device", "emulated:config-cli"]


def run(*arguments: str, status: int = 0) -> str:
    result = CliRunner().invoke(app, [*arguments, *DEVICE])
    assert result.exit_code == status, result.output
    return result.output


def test_fields_of_several_configurations_are_set_and_kept() -> None:
    run("config", "set", "counts_per_rev=4000", "law=compensated", "confirmed=on", "supply_v=24")
    shown = run("config", "get", "counts_per_rev", "law", "confirmed", "supply_v")
    for words in ("counts_per_rev  4000", "law  compensated", "supply_v  24"):
        assert words in shown
    with torsio.open(DEVICE[1]) as knob:
        assert knob.board_config().confirmed is True
        assert knob.actuator_config().counts_per_rev == 4000


def test_dump_can_be_loaded_again(tmp_path: Path) -> None:
    with torsio.open(DEVICE[1]) as knob:
        before = knob.control_config()
    result = CliRunner().invoke(app, ["config", "dump", *DEVICE])
    file = tmp_path / "knob.json"
    file.write_text(result.stdout, encoding="utf-8")
    run("config", "set", f"beta={0.25 if before.beta != 0.25 else 0.5}")
    run("config", "load", str(file))
    with torsio.open(DEVICE[1]) as knob:
        assert knob.control_config() == before


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-be", "utf-32"])
def test_dump_may_be_as_windows_writes_it(tmp_path: Path, encoding: str) -> None:
    file = tmp_path / "knob.json"
    file.write_text(json.dumps({"control_config": {"beta": 0.375}}), encoding=encoding)
    run("config", "load", str(file))
    assert "beta  0.375" in run("config", "get", "beta")
    run("config", "set", "beta=0.5")
    with torsio.open(DEVICE[1]) as knob:
        torsio.load_config(knob, "\ufeff" + json.dumps({"control_config": {"beta": 0.375}}))
        assert knob.control_config().beta == 0.375


@pytest.mark.parametrize("command", ["config set beta=0.5", "config load", "games set --gain 0.5"])
def test_what_an_emulated_knob_forgets_is_said(tmp_path: Path, command: str) -> None:
    (tmp_path / "knob.json").write_text("{}")
    more = [str(tmp_path / "knob.json")] if command.endswith("load") else []
    said = " ".join(run(*command.split(), *more).split())
    assert "settings are forgotten" in said


@pytest.mark.parametrize(
    "command",
    [
        *("config set beta=0.5", "config load {knob}", "zero", "zero --keep", "calibrate --save"),
        *("stop", "clear-fault"),
        *("games set --gain 0.5", "games profile load rally"),
    ],
)
def test_without_a_knob_what_it_would_keep_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    kept = tmp_path / "torsio/games/rally.json"
    kept.parent.mkdir(parents=True)
    for file in (tmp_path / "knob.json", kept):
        file.write_text("{}")
    opened: list[str] = []
    monkeypatch.setattr(torsio, "open", lambda selector, **_: opened.append(selector))
    words = command.format(knob=tmp_path / "knob.json").split()
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 1
    said = " ".join((result.output + str(result.stderr)).split())
    assert "no knob is plugged in, so nothing was changed" in said
    assert "./dev udev" in said
    assert "--device emulated" in said
    assert opened == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["set", "beta"], "FIELD=VALUE"),
        (["set", "speed_limit=40"], "there are speed_limit_rad_s (ControlConfig)"),
        (["set", "beta=much"], "takes a number"),
        (["set", "confirmed=maybe"], "on or off"),
        (["set", "counts_per_rev=5000", "beta=2"], "beta"),
        (["get", "betta"], "no configuration has a field"),
    ],
)
def test_what_a_knob_does_not_take_is_told_and_changes_nothing(
    arguments: list[str], words: str
) -> None:
    before = json.loads(CliRunner().invoke(app, ["config", "dump", *DEVICE]).stdout)
    assert words in run("config", *arguments, status=1)
    assert json.loads(CliRunner().invoke(app, ["config", "dump", *DEVICE]).stdout) == before


def test_zero_is_kept_once_the_index_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    options = torsio.EmulatorOptions(
        control_rate_hz=10_000,
        hand=torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (3.0, 15.0)]),
        actuator=torsio.ActuatorConfig(encoder_index_pin=4),
    )
    with torsio.open("emulated", emulator=options) as knob:
        with pytest.raises(torsio.InvalidArgument, match="encoder_index_pin is 6: this pin has"):
            knob.update(encoder_index_pin=6)
        with pytest.raises(torsio.InvalidArgument, match="encoder_pin is 4: this pin has another"):
            knob.update(encoder_pin=4)
        monkeypatch.setattr(torsio, "open", lambda *_, **__: nullcontext(knob))
        assert "two turns" in run("zero", "--keep", status=1)
        assert "two turns" in run("games")
        knob.sleep(3)
        saves = knob.health().saves
        run("zero", "--keep")
        assert (knob.health().centre, knob.health().saves) == ("index", saves + 1)
        assert knob.position_rad() == pytest.approx(0.0, abs=1e-3)


def test_faults_stop_and_zero_are_commands(monkeypatch: pytest.MonkeyPatch) -> None:
    hand = torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (0.1, 0.5)])
    options = torsio.EmulatorOptions(hand=hand)
    with torsio.open("emulated", emulator=options) as knob:
        # The knob that the commands open, in a state that each has something to do about.
        monkeypatch.setattr(torsio, "open", lambda *_, **__: nullcontext(knob))
        knob.sleep(0.2)
        assert knob.position_rad() == pytest.approx(0.5, abs=1e-3)
        run("zero")
        assert knob.position_rad() == pytest.approx(0.0, abs=1e-3)

        knob.emulator.set_emergency_stop(pressed=True)
        knob.sleep(0.01)
        knob.emulator.set_emergency_stop(pressed=False)
        knob.sleep(0.01)
        assert "emergency_stop" in knob.health().faults
        run("clear-fault")
        assert knob.state == "disarmed"

        knob.play(torsio.Constant(torque_nm=0.02))
        knob.arm()
        knob.start_telemetry()
        assert knob.record(0.1)["motor_command_nm"][-1] != 0.0
        run("stop")
        assert knob.state == "disarmed"
        knob.arm()  # with a scene that is empty by now
        assert not knob.record(0.1)["motor_command_nm"].any()


def test_order_is_given_before_a_screen_that_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(console: Console, text: str) -> None:
        if console is screen.out:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(shared, "line", full)
    with torsio.open("emulated") as knob:
        monkeypatch.setattr(torsio, "open", lambda *_, **__: nullcontext(knob))
        knob.play(torsio.Constant(torque_nm=0.02))
        knob.arm()
        run("stop", status=1)
        assert knob.state == "disarmed"


def test_arm_says_how_much_there_is_at_most_and_sleeps(monkeypatch: pytest.MonkeyPatch) -> None:
    run("config", "set", "motor_torque_cap_nm=0.02", "speed_limit_rad_s=12")
    slept: list[float] = []
    sleep = time.sleep

    def note(seconds: float) -> None:
        slept.append(seconds)
        sleep(seconds)

    monkeypatch.setattr(time, "sleep", note)
    shown = run("arm", "--seconds", "0.2")
    assert max(slept) <= 0.1
    assert sum(slept) == pytest.approx(0.2, abs=0.1)
    assert "motor 20 mN m, brake 110 mN m, 12 rad/s" in shown
    assert "missing" not in shown
    assert "held_low" in run("info")


def test_arm_says_what_a_board_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    low = Limits(
        motor_torque_max_nm=0.015, motor_torque_continuous_max_nm=0.015, brake_torque_max_nm=0.03,
        speed_limit_rad_s=10.0, held_low=True,
    )  # fmt: skip
    monkeypatch.setattr(torsio.Knob, "limits", lambda _: low)
    monkeypatch.setattr(torsio.Knob, "_is_held_low", lambda _: True)
    with pytest.warns(torsio.HeldLowWarning, match="15 mN m and 10 rad/s at most.*confirmed=True"):
        shown = run("arm", "--seconds", "0")
    assert "confirmed=on" in shown
    assert "torsio calibrate" in shown


def test_arm_says_that_a_real_board_has_no_speed_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    run("config", "set", "speed_limit_rad_s=0")
    assert "missing" not in run("arm", "--seconds", "0")
    with torsio.open(DEVICE[1]) as knob:
        monkeypatch.setattr(torsio.Knob, "info", dataclasses.replace(knob.info, board="pico2"))
    with pytest.warns(torsio.NoSpeedLimitWarning, match=r"speed_limit_rad_s=\.\.\."):
        assert "speed_limit_rad_s=160" in run("arm", "--seconds", "0")
    run("config", "set", "speed_limit_rad_s=12")
    assert "missing" not in run("arm", "--seconds", "0")


def test_arm_that_a_fault_ends_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    real = torsio.Knob.arm

    def arm(knob: torsio.Knob) -> None:
        real(knob)
        knob.emulator.set_emergency_stop(pressed=True)

    monkeypatch.setattr(torsio.Knob, "arm", arm)
    assert "emergency_stop" in run("arm", "--seconds", "1", status=1)
