"""A game on the emulated knob: what it asks for in bytes, and what the motor then gives."""

from __future__ import annotations

import struct
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

import torsio

CONSTANT, SINE, SPRING, DAMPER, FRICTION = 1, 4, 8, 9, 11
WEST = 24575  # from the left: to larger angles
FULL_NM = 0.06
Floats = npt.NDArray[np.float64]

MOTOR_ONLY = torsio.ControlConfig(law="motor_only")


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


def test_a_sine_reaches_the_simulated_motor() -> None:
    game_config = torsio.GameConfig(torque_max_nm=FULL_NM)
    with torsio.open(
        "emulated",
        emulator=torsio.EmulatorOptions(
            control_rate_hz=10_000, game=game_config, control=MOTOR_ONLY, log_truth=True
        ),
    ) as knob:
        game = Game(knob)
        knob.emulator.set_hand(torsio.PrescribedMotion(angle_rad=[(0.0, 0.0)]))
        block = game.create(SINE)
        game.periodic(block, 30000, 40)
        game.start(block)
        knob.emulator.advance(0.01)
        knob.emulator.truth()
        knob.emulator.advance(0.4)
        truth = knob.emulator.truth()
        expected = FULL_NM * 30000 / 32767
        # A first-order lag of 44 us behind the commands, which are held for 0.1 ms.
        time_s = truth["time_s"] - 50e-6 - 44e-6
        error = truth["motor_torque_nm"] - expected * np.sin(2 * np.pi * time_s / 0.04)
        assert np.abs(error).max() < 0.01 * expected
        assert knob.health().owner == "game"


def test_axis_follows_the_knob_over_the_configured_range() -> None:
    hand = torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (1.0, 1.5), (2.0, -1.0)])
    with torsio.open(
        "emulated",
        emulator=torsio.EmulatorOptions(hand=hand, game=torsio.GameConfig(range_deg=180)),
    ) as knob:
        game = Game(knob)
        seen = []
        for _ in range(40):
            knob.emulator.advance(0.05)
            seen += [
                (knob.position_rad(), struct.unpack("<h", r[1:3])[0])
                for r in game.inputs()
                if r[0] == 1
            ]
        angle, x = np.array(seen).T
        count = 2 * np.pi / 8192
        assert len(seen) > 30
        # Asked for one after the other: a millisecond of motion lies between at most.
        assert np.abs(x - angle / (np.pi / 2) * 32767).max() < 32767 * (count + 2.5e-3) / 1.5


def test_sdk_takes_over_and_the_game_comes_back_by_starting() -> None:
    config = torsio.GameConfig(torque_max_nm=FULL_NM)
    with torsio.open(
        "emulated", emulator=torsio.EmulatorOptions(game=config, control=MOTOR_ONLY)
    ) as knob:
        game = Game(knob)
        block = game.create(CONSTANT)
        game.constant(block, 32767)
        game.start(block)
        knob.emulator.advance(0.1)
        assert knob.health().owner == "game"
        assert (knob.record(duration_s=0.01)["flags"] & torsio.telemetry.FLAG_GAME).all()
        with pytest.raises(torsio.Refused):
            knob.configure(torsio.GameConfig())
        knob.arm()
        knob.emulator.advance(0.1)
        assert knob.health().owner == "sdk"
        knob.disarm()
        knob.configure(replace(config, gain=0.5))
        assert knob.game_config().gain == 0.5
        knob.emulator.advance(0.1)
        assert knob.health().owner == "none"
        game.start(block)
        knob.emulator.advance(0.1)
        assert knob.health().owner == "game"


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


def _released(rate_hz: float, kind: int, actuator: torsio.ActuatorConfig | None) -> Floats:
    """Angle of a knob that was let go with the strongest effect that the device renders."""
    config = torsio.GameConfig(
        range_deg=100, spring_gain=1000, speed_full_rad_s=0.1, torque_max_nm=0.085, silence_s=0
    )
    with torsio.open(
        "emulated",
        emulator=torsio.EmulatorOptions(
            control_rate_hz=rate_hz,
            game=config,
            control=MOTOR_ONLY,
            actuator=actuator,
            log_truth=True,
        ),
    ) as knob:
        game = Game(knob)
        knob.emulator.set_hand(torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (0.1, 0.4)]))
        block = game.create(kind)
        game.condition(block)
        game.start(block)
        knob.emulator.advance(0.15)
        knob.emulator.set_hand(torsio.NoHand())
        # A push, for what does not move by itself.
        knob.emulator.set_hand(torsio.TorqueHand(torque_nm=[(0.0, 0.2), (0.01, 0.2), (0.01, 0.0)]))
        knob.emulator.truth()
        knob.emulator.advance(1.5)
        return np.asarray(knob.emulator.truth()["angle_rad"], dtype=np.float64)


def _rest(angle_rad: Floats) -> float:
    """Peak to peak over the last third."""
    return float(np.ptp(angle_rad[-angle_rad.size // 3 :]))


@pytest.mark.parametrize("rate_hz", [1_000, 10_000])
@pytest.mark.parametrize("kind", [SPRING, DAMPER])
def test_released_knob_comes_to_rest_at_the_strongest_allowed(rate_hz: float, kind: int) -> None:
    assert _rest(_released(rate_hz, kind, None)) < 2 * np.pi / 8192


@pytest.mark.parametrize("rate_hz", [1_000, 10_000])
@pytest.mark.parametrize("kind", [SPRING, DAMPER])
def test_without_the_limit_the_knob_oscillates(rate_hz: float, kind: int) -> None:
    # A device that was told of inertia and friction which are not there sets the limit too high.
    wrong = torsio.ActuatorConfig(knob_inertia_kg_m2=1e-2, knob_coulomb_nm=0.1)
    assert _rest(_released(rate_hz, kind, wrong)) > 5 * 2 * np.pi / 8192


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
