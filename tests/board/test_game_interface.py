"""The other interface of the same binary: a game controller with force feedback.

Reports are bytes here, after the tables of docs/reference/games.md.
"""

from __future__ import annotations

import struct

import pytest

from tests.board.pico import FEATURE, EmulatedPico

INTERFACE = 1
ENDPOINT = 2
CONSTANT = 1
TO_LARGER_ANGLES = 24575  # the force comes from the left
FULL = 32767


def _play(pico: EmulatedPico, magnitude: int) -> None:
    """Upload a constant force without end and start it."""
    create = struct.pack("<BBH", 0x21, CONSTANT, 0)
    pico.control(0x21, 0x09, FEATURE << 8 | 0x21, INTERFACE, len(create), create)
    load = pico.control(0xA1, 0x01, FEATURE << 8 | 0x22, INTERFACE, 64)
    block, status = load[1], load[2]
    assert (load[0], status) == (0x22, 1)
    no_button, by_direction = 0, 2
    effect = (0xFFFF, 0, 0, FULL, no_button, by_direction, TO_LARGER_ANGLES, 0)
    for report in (
        struct.pack("<BBBHHHHBBHH", 0x11, block, CONSTANT, *effect),
        struct.pack("<BBh", 0x15, block, magnitude),
        struct.pack("<BBBB", 0x1A, block, 1, 1),
    ):
        assert pico.write(report, endpoint=ENDPOINT) == "ack"


def _joystick(pico: EmulatedPico) -> int:
    """Return the newest position of the axis that the device reports."""
    x = None
    for _ in range(10):
        answer = pico.do("in", endpoint=ENDPOINT, within_ns=5e6)
        if answer == "nak":
            break
        report = bytes.fromhex(answer["data"])
        if report[0] == 0x01:
            (x,) = struct.unpack_from("<h", report, 1)
    assert x is not None
    return int(x)


def test_axis_follows_the_knob(pico: EmulatedPico) -> None:
    pico.turn(200)
    # 900 degrees of 8192 counts a turn are the whole range.
    assert _joystick(pico) == pytest.approx(200 / 8192 * 360 / 450 * 32767, abs=1)
    pico.turn(-400)
    assert _joystick(pico) == pytest.approx(-200 / 8192 * 360 / 450 * 32767, abs=1)


@pytest.mark.parametrize("sign", [1, -1])
def test_constant_force_of_a_game_turns_the_motor(pico: EmulatedPico, sign: int) -> None:
    assert pico.motor() is None
    _play(pico, sign * FULL // 2)
    pico.run(20)
    motor = pico.motor()
    assert motor is not None
    assert motor * sign > 0.1
    health = pico.get("health")
    assert (health["state"], health["owner"]) == ("armed", "game")
    assert pico.write(bytes([0x1C, 3]), endpoint=ENDPOINT) == "ack"  # stop all effects
    pico.run(120)  # it fades
    assert pico.motor() == pytest.approx(0, abs=0.002)
