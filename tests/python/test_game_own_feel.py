"""The player's own feel, as `torsio games set` keeps it and a game's player feels it."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from typer.testing import CliRunner

import torsio
from tests.python.game import CONSTANT, Game
from torsio.apps.cli import app

FRAME_S = 1 / 60
# A game's stiff spring is at full torque a twentieth of the way to the axis's end.
STIFFNESS = 20


def axis_while_a_game_centres(own_damper_percent: int) -> list[int]:
    """Let a game throw and then centre a knob that nobody holds; return its axis in each frame."""
    game_config = torsio.GameConfig(own_damper_percent=own_damper_percent)
    options = torsio.EmulatorOptions(control_rate_hz=10_000, game=game_config)
    with torsio.open("emulated", emulator=options) as knob:
        game = Game(knob)
        block = game.create(CONSTANT)
        game.constant(block, 32767)
        game.play(block)
        knob.emulator.advance(0.1)
        x = 0
        told = []
        for _ in range(round(6 / FRAME_S)):
            while (report := game.port.read()) is not None:
                if report[0] == 1:
                    x = struct.unpack_from("<h", report, 1)[0]
            told.append(x)
            game.constant(block, max(-32767, min(32767, -STIFFNESS * x)))
            knob.emulator.advance(FRAME_S)
        return told


def test_game_that_centres_in_its_own_frames_swings_a_free_knob_and_the_own_damper_stops_it() -> (
    None
):
    swings, settled = axis_while_a_game_centres(0), axis_while_a_game_centres(40)
    assert max(map(abs, swings[-120:])) > 32767 / 2  # 4 rad, and for ever
    assert max(settled[-120:]) - min(settled[-120:]) <= 2
    assert abs(settled[-1]) < 0.02 * 32767  # friction, and the damper's creep


def test_own_feel_gains_and_reversal_are_kept_on_the_knob() -> None:
    device = "emulated:games-own"
    wanted: dict[str, Any] = {
        "own_damper_percent": 30,
        "own_friction_percent": 10,
        "own_inertia_percent": 20,
        "own_spring_percent": 40,
        "constants_gain_percent": 90,
        "waves_gain_percent": 80,
        "springs_gain_percent": 70,
        "dampers_gain_percent": 60,
        "inertias_gain_percent": 50,
        "frictions_gain_percent": 0,
        "torque_max_percent": 55,
    }
    arguments = ["games", "set", "--device", device, "--reversed", "--dial-coarse"]
    for name, value in wanted.items():
        option = name if name == "torque_max_percent" else name.removesuffix("_percent")
        arguments += ["--" + option.replace("_", "-"), str(value)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    with torsio.open(device) as knob:
        assert knob.game_config() == torsio.GameConfig(reversed=True, dial_coarse=True, **wanted)


@pytest.mark.parametrize("option", ["--own-damper", "--waves-gain", "--torque-max-percent"])
def test_more_than_all_is_refused(option: str) -> None:
    result = CliRunner().invoke(app, ["games", "set", "--device", "emulated", option, "101"])
    assert result.exit_code != 0
    assert "100" in result.output + str(result.stderr_bytes)
