"""The player's own feel, as a game's player feels it."""

from __future__ import annotations

import struct

import pytest

import torsio
from tests.python.game import CONSTANT, Game

FRAME_S = 1 / 60
# A game's stiff spring is at full torque a twentieth of the way to the axis's end.
STIFFNESS = 20


def axis_while_a_game_centres(own_damper_percent: int, control_rate_hz: int) -> list[int]:
    """Let a game throw and then centre a knob that nobody holds; return its axis in each frame."""
    game_config = torsio.GameConfig(own_damper_percent=own_damper_percent)
    options = torsio.EmulatorOptions(control_rate_hz=control_rate_hz, game=game_config)
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


@pytest.mark.parametrize("control_rate_hz", [1000, 10_000, 20_000])
def test_game_that_centres_in_its_own_frames_swings_a_free_knob_and_the_own_damper_stops_it(
    control_rate_hz: int,
) -> None:
    swings, settled = (axis_while_a_game_centres(own, control_rate_hz) for own in (0, 40))
    # Half of the axis is 3.9 rad. To either side it swings by 7.4 rad or more at 1 kHz, 5.8 rad at
    # 10 kHz, 5.0 rad at 20 kHz, and for ever.
    assert min(max(swings[-120:]), -min(swings[-120:])) > 32767 / 2
    assert max(settled[-120:]) - min(settled[-120:]) <= 2
    assert abs(settled[-1]) < 0.02 * 32767  # friction, and the damper's creep
