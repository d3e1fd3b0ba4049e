"""The player's own feel, as a game's player feels it."""

from __future__ import annotations

import struct

import torsio
from tests.python.game import CONSTANT, Game

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
