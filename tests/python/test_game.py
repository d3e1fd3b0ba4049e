"""A game on the emulated knob: what it asks for in bytes, and what the motor then gives."""

from __future__ import annotations

import struct

import pytest

import torsio
from tests.python.game import Game

DAMPER, FRICTION = 9, 11
FULL_NM = 0.06


def test_port_refuses_what_is_no_report() -> None:
    with torsio.open("emulated") as knob:
        port = knob.emulator.game
        with pytest.raises(ValueError, match="1 to 64 bytes"):
            port.write(b"")
        with pytest.raises(TypeError):
            port.write("11")  # type: ignore[arg-type]
        assert port.get_feature(0x21) is None
        assert not port.set_feature(b"\x23\x00")


@pytest.mark.parametrize(("kind", "share"), [(DAMPER, 0.5 * 10 / 20), (FRICTION, 0.5)])
def test_motor_and_brake_give_together_what_the_game_asks_for(kind: int, share: float) -> None:
    plant = torsio.PlantParams()
    config = torsio.GameConfig(torque_max_nm=FULL_NM)
    with torsio.open(
        "emulated",
        emulator=torsio.EmulatorOptions(
            control_rate_hz=10_000, game=config, plant=plant, log_truth=True
        ),
    ) as knob:
        game = Game(knob)
        block = game.create(kind)
        condition = (0x13, block, 0, 0, 16384, 16384, 32767, 32767, 0)
        game.port.write(struct.pack("<BBBhhhHHH", *condition))
        game.play(block)
        knob.emulator.advance(0.05)
        knob.emulator.set_hand(torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (0.5, 5.0)]))
        knob.emulator.advance(0.3)
        knob.emulator.truth()
        knob.emulator.advance(0.15)
        truth = knob.emulator.truth()
    motor_nm, brake_nm = (truth[name].mean() for name in ("motor_torque_nm", "brake_torque_nm"))
    # A brake that is off still drags.
    wanted_nm = share * FULL_NM
    assert motor_nm + brake_nm == pytest.approx(-wanted_nm - plant.brake_drag_nm, rel=0.02)
    assert brake_nm == pytest.approx(-wanted_nm / 2 - plant.brake_drag_nm, rel=0.05)
