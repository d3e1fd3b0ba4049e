"""`torsio games` and the monitor show a game; `torsio games set` keeps its settings."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner, Result

import torsio
from tests.python.game import CONSTANT, SPRING, Game
from torsio.apps.cli import app
from torsio.apps.commands import games as games_cli
from torsio.games import GameMonitor

FULL_NM = 0.08


@pytest.fixture
def knob() -> Iterator[torsio.Knob]:
    with torsio.open("emulated") as opened:
        opened.configure(torsio.ControlConfig(law="motor_only"))
        opened.configure(torsio.GameConfig(torque_max_nm=FULL_NM, blend_s=0))
        yield opened


def test_a_knob_without_a_game_has_no_effects(knob: torsio.Knob) -> None:
    assert knob.game_effects() == ()
    status = knob.game_status()
    assert (status.owner, status.gain, status.torque_nm, status.effects) == ("none", 1, 0, 0)


def test_each_effect_is_told_with_what_it_gives(knob: torsio.Knob) -> None:
    game = Game(knob)
    blocks = [game.create(CONSTANT) for _ in range(7)]
    for n, block in enumerate(blocks):
        game.constant(block, 1000 * n)
        if n < 5:
            game.play(block)
    spring = game.create(SPRING)
    knob.sleep(0.1)
    effects = knob.game_effects()
    assert [e.block for e in effects] == [*blocks, spring]
    assert [e.kind for e in effects] == ["constant"] * 7 + ["spring"]
    assert [e.state for e in effects] == ["playing"] * 5 + ["stopped"] * 3
    # Set effect, its level, and a start.
    assert [e.updates for e in effects] == [3] * 5 + [2] * 2 + [1]
    expected = [FULL_NM * 1000 * n / 32767 for n in range(5)]
    assert [e.torque_nm for e in effects[:5]] == pytest.approx(expected, abs=1e-5)
    assert effects[0].silent_s == pytest.approx(0.1, abs=5e-3)
    status = knob.game_status()
    assert status.owner == "game"
    assert status.effects == 8
    assert status.torque_nm == pytest.approx(sum(expected), abs=2e-5)


def test_what_the_device_has_ended_is_told_as_set_aside(knob: torsio.Knob) -> None:
    game = Game(knob)
    block = game.create(CONSTANT)
    game.constant(block, 20000)
    game.play(block)
    knob.sleep(0.1)
    knob.arm()
    knob.sleep(0.2)
    assert [e.state for e in knob.game_effects()] == ["set_aside"]
    knob.disarm()
    game.constant(block, 10000)
    knob.sleep(0.1)
    assert [e.state for e in knob.game_effects()] == ["playing"]
    game.stop(block)
    knob.sleep(0.1)
    assert [e.state for e in knob.game_effects()] == ["stopped"]


def test_monitor_counts_updates_in_a_second_of_the_device(knob: torsio.Knob) -> None:
    game = Game(knob)
    one, other = game.create(CONSTANT), game.create(CONSTANT)
    game.play(one)
    monitor = GameMonitor(knob)
    assert monitor.read().updates_per_s == 0
    for n in range(120):
        game.constant(one, 100 * n)
        if n % 2:
            game.constant(other, n)
        knob.sleep(1 / 60)
    reading = monitor.read()
    assert reading.updates_per_s == pytest.approx(90, rel=0.05)
    assert reading.effect_updates_per_s == pytest.approx((60, 30), rel=0.05)


def test_effects_that_ask_for_more_than_all_together_get_are_told() -> None:
    options = torsio.EmulatorOptions(
        hand=torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (9.0, 0.0)]),  # else it flies away
        control=torsio.ControlConfig(law="motor_only"),
        game=torsio.GameConfig(torque_max_nm=FULL_NM),
    )
    with torsio.open("emulated", emulator=options) as knob:
        game = Game(knob)
        monitor = GameMonitor(knob)
        one, other = game.create(CONSTANT), game.create(CONSTANT)
        for block in (one, other):
            game.constant(block, 26214)  # 80 %, and 160 together
        game.play(one)
        monitor.read()
        knob.sleep(1.2)
        reading = monitor.read()
        assert (reading.clipped_share, reading.status.asked_percent) == (0, 80)
        game.play(other)
        knob.sleep(1.0)
        game.stop(other)
        knob.sleep(1.0)
        reading = monitor.read()
        assert reading.clipped_share == pytest.approx(0.5, abs=0.01)
        assert reading.status.torque_nm == pytest.approx(0.8 * FULL_NM, rel=1e-3)
        assert reading.status.asked_percent == 80  # in the last half second
        game.play(other)
        knob.sleep(1.2)
        assert monitor.read().asked_most_percent == 160
        out = Console(file=io.StringIO(), width=200)
        games_cli.show(knob, out, seconds=None)
        shown = out.file.getvalue()  # type: ignore[attr-defined]
        assert "up to 160 %" in shown
        assert "clipped 100 % of the time" in shown
        assert "--gain 0.62" in shown  # 1 / 1.6, rounded down


# The command ---------------------------------------------------------------------------------


def test_command_tells_one_moment_as_json() -> None:
    result = CliRunner().invoke(app, ["games", "--device", "emulated", "--json"])
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["effects"] == []
    assert told["status"]["owner"] == "none"


def test_command_shows_one_moment_without_a_terminal() -> None:
    result = CliRunner().invoke(app, ["games", "--device", "emulated"])
    assert result.exit_code == 0, result.output
    assert "actuator: nobody" in result.stdout


def test_view_in_a_terminal_follows_what_games_do(
    knob: torsio.Knob, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    game = Game(knob)
    block = game.create(CONSTANT)
    game.constant(block, 16384)
    game.play(block)
    out = Console(file=io.StringIO(), force_terminal=True, width=100)
    games_cli.show(knob, out, seconds=0.6)
    assert isinstance(out.file, io.StringIO)
    shown = out.file.getvalue()
    # Drawn again, in place.
    assert shown.count("actuator: a game or your own feel, torque") >= 2
    assert "playing" in shown
    assert "\x1b[" in shown


@pytest.mark.parametrize("who", ["a game", "the SDK"])
def test_settings_are_refused_while_somebody_has_the_actuator(knob: torsio.Knob, who: str) -> None:
    before = knob.game_config()
    if who == "a game":
        game = Game(knob)
        game.play(game.create(CONSTANT))
        knob.sleep(0.05)
    else:
        knob.arm()
    with pytest.raises(torsio.Refused, match="has the actuator: end it"):
        games_cli.change(knob, {"range_deg": 270.0})
    assert knob.game_config() == before


def test_settings_of_every_kind_are_kept_on_the_knob() -> None:
    device = "emulated:games-set"
    words = (
        "--range-deg 270 --end-stiffness 2 --own-damper 30 --own-friction 10 --own-inertia 20 "
        "--own-spring 40 --constants-gain 90 --waves-gain 80 --springs-gain 70 --dampers-gain 60 "
        "--inertias-gain 50 --frictions-gain 0 --torque-max-percent 55 --reversed --dial-coarse "
        "--personality dial --dial-use pan --dial-detents 36 --hold-updates"
    )
    result = CliRunner().invoke(app, ["games", "set", "--device", device, *words.split()])
    assert result.exit_code == 0, result.output
    for shown in ("range_deg  270", "personality  dial"):
        assert shown in result.stdout
    wanted = torsio.GameConfig(
        range_deg=270,
        end_stiffness_nm_per_rad=2,
        own_damper_percent=30,
        own_friction_percent=10,
        own_inertia_percent=20,
        own_spring_percent=40,
        constants_gain_percent=90,
        waves_gain_percent=80,
        springs_gain_percent=70,
        dampers_gain_percent=60,
        inertias_gain_percent=50,
        frictions_gain_percent=0,
        torque_max_percent=55,
        reversed=True,
        dial_coarse=True,
        personality="dial",
        dial_use="pan",
        dial_detents=36,
        join_updates=False,
    )
    with torsio.open(device) as knob:
        assert knob.game_config() == wanted


def test_profile_keeps_a_players_settings_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    device = ["--device", "emulated:games-profile"]

    def run(*arguments: str) -> Result:
        return CliRunner().invoke(app, ["games", *arguments, *device])

    assert run("set", "--range-deg", "270", "--own-damper", "30").exit_code == 0
    assert run("profile", "save", "rally").exit_code == 0
    assert run("set", "--range-deg", "1080", "--own-damper", "0", "--reversed").exit_code == 0
    loaded = run("profile", "load", "rally")
    assert loaded.exit_code == 0, loaded.output
    with torsio.open(device[1]) as knob:
        assert knob.game_config() == torsio.GameConfig(range_deg=270, own_damper_percent=30)
    file = tmp_path / "torsio/games/rally.json"
    file.write_text(file.read_text(), encoding="utf-16")  # as PowerShell's redirection has it
    assert run("profile", "load", "rally").exit_code == 0
    for name, words in (("drift", "there are: rally"), ("../rally", "use letters")):
        refused = run("profile", "load", name)
        assert refused.exit_code != 0
        assert words in refused.output + str(refused.stderr_bytes)
    file.write_text('{"game_config": {"range_deg": 1}}')
    assert run("profile", "load", "rally").exit_code != 0
    with torsio.open(device[1]) as knob:
        assert knob.game_config() == torsio.GameConfig(range_deg=270, own_damper_percent=30)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--personality", "mouse"], "personality"),
        (["--dial-detents", "0"], "dial_detents"),
        (["--range-deg", "1"], "range_deg"),
        (["--gain", "nan"], "gain"),
        (["--own-damper", "101"], "100"),
        (["--waves-gain", "101"], "100"),
        (["--torque-max-percent", "101"], "100"),
        ([], "name at least one setting"),
    ],
)
def test_bad_settings_are_refused_and_change_nothing(arguments: list[str], words: str) -> None:
    device = "emulated:games-bad"
    result = CliRunner().invoke(app, ["games", "set", "--device", device, *arguments])
    assert result.exit_code != 0
    assert words in result.output + str(result.stderr_bytes)
    with torsio.open(device) as knob:
        assert knob.game_config() == torsio.GameConfig()
