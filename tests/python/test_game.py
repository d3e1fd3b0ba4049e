"""A game on the emulated knob: what it asks for in bytes, and what the motor then gives."""

from __future__ import annotations

import struct

import pytest

import torsio

CONSTANT, SINE, SPRING, DAMPER, FRICTION = 1, 4, 8, 9, 11
WEST = 24575  # from the left: to larger angles
FULL_NM = 0.06


class Game:
    """The part of a driver that the tests need, written after docs/reference/games.md."""

    def __init__(self, knob: torsio.Knob) -> None:
        self.port = knob.emulator.game

    def create(self, kind: int, *, duration_ms: int = 0xFFFF) -> int:
        assert self.port.set_feature(struct.pack("<BBH", 0x21, kind, 0))
        load = self.port.get_feature(0x22)
        assert load is not None
        _, block, status, _ = struct.unpack("<BBBH", load)
        assert status == 1
        self.port.write(
            struct.pack("<BBBHHHHBBHH", 0x11, block, kind, duration_ms, 0, 0, 32767, 0, 2, WEST, 0)
        )
        return int(block)

    def constant(self, block: int, magnitude: int) -> None:
        self.port.write(struct.pack("<BBh", 0x15, block, magnitude))

    def periodic(self, block: int, magnitude: int, period_ms: int) -> None:
        self.port.write(struct.pack("<BBHhHH", 0x14, block, magnitude, 0, 0, period_ms))

    def condition(self, block: int, coefficient: int = 32767) -> None:
        self.port.write(
            struct.pack("<BBBhhhHHH", 0x13, block, 0, 0, coefficient, coefficient, 32767, 32767, 0)
        )

    def start(self, block: int) -> None:
        self.port.write(bytes([0x1A, block, 1, 1]))

    def inputs(self) -> list[bytes]:
        found = []
        while (report := self.port.read()) is not None:
            found.append(report)
        return found


def test_game_configuration_is_kept_and_checked() -> None:
    config = torsio.GameConfig(
        enabled=False,
        range_deg=1440,
        torque_max_nm=0.05,
        gain=0.25,
        spring_gain=2,
        speed_full_rad_s=30,
        acceleration_full_rad_s2=2000,
        blend_s=0.004,
        silence_s=5,
    )
    with torsio.open("emulated") as knob:
        assert knob.game_config() == torsio.GameConfig()
        knob.configure(config)
        assert knob.game_config() == config
        with pytest.raises(torsio.InvalidArgument, match=r"range_deg is 5, allowed are 10"):
            knob.configure(torsio.GameConfig(range_deg=5))
        assert knob.game_config() == config


def test_port_refuses_what_is_no_report() -> None:
    with torsio.open("emulated") as knob:
        port = knob.emulator.game
        with pytest.raises(ValueError, match="1 to 64 bytes"):
            port.write(b"")
        with pytest.raises(TypeError):
            port.write("11")  # type: ignore[arg-type]
        assert port.get_feature(0x21) is None
        assert not port.set_feature(b"\x23\x00")


# Stability ----------------------------------------------------------------------------------


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
        game.condition(block, 16384)
        game.start(block)
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
