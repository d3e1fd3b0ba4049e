"""The other interface of the same binary: a game controller with force feedback.

Reports are bytes here, after the tables of docs/reference/games.md.
"""

from __future__ import annotations

import struct

import pytest

from tests.board import pico as bench
from tests.board.pico import FEATURE, EmulatedPico

OVERRUN = 1 << 4
INTERFACE = 1
ENDPOINT = 2
CONSTANT, SINE = 1, 4
TO_LARGER_ANGLES = 24575  # the force comes from the left
FULL = 32767


def _play(pico: EmulatedPico, magnitude: int, kind: int = CONSTANT) -> None:
    """Upload a force without end and start it: constant, or a sine of 20 Hz."""
    create = struct.pack("<BBH", 0x21, kind, 0)
    pico.control(0x21, 0x09, FEATURE << 8 | 0x21, INTERFACE, len(create), create)
    load = pico.control(0xA1, 0x01, FEATURE << 8 | 0x22, INTERFACE, 64)
    block, status = load[1], load[2]
    assert (load[0], status) == (0x22, 1)
    no_button, by_direction = 0, 2
    effect = (0xFFFF, 0, 0, FULL, no_button, by_direction, TO_LARGER_ANGLES, 0)
    constant = struct.pack("<BBh", 0x15, block, magnitude)
    for report in (
        struct.pack("<BBBHHHHBBHH", 0x11, block, kind, *effect),
        constant if kind == CONSTANT else struct.pack("<BBHhHI", 0x14, block, magnitude, 0, 0, 50),
        struct.pack("<BBBB", 0x1A, block, 1, 1),
    ):
        assert pico.write(report, endpoint=ENDPOINT) == "ack"


def _joystick(pico: EmulatedPico) -> list[tuple[int, int]]:
    """Return axis and buttons of the reports that the device has."""
    found = []
    for _ in range(10):
        answer = pico.do("in", endpoint=ENDPOINT, within_ns=5e6)
        if answer == "nak":
            break
        report = bytes.fromhex(answer["data"])
        if report[0] == 0x01:
            found.append(struct.unpack_from("<hB", report, 1))
    return found


def test_axis_follows_the_knob(pico: EmulatedPico) -> None:
    for turned, at in ((200, 200), (-400, -200)):
        pico.turn(turned)
        # 900 degrees of 8192 counts a turn are the whole range.
        assert _joystick(pico)[-1][0] == pytest.approx(at / 8192 * 360 / 450 * 32767, abs=1)


def test_buttons_are_pins_to_ground_whose_contacts_may_bounce(pico: EmulatedPico) -> None:
    before = 0
    _joystick(pico)
    for pressed in (0b01, 0b11, 0b10, 0b00):
        for levels in (pressed, before, pressed, before, pressed):
            for bit, pin in enumerate((13, 14)):
                pico.do("pin", pin=pin, high=levels >> bit & 1 == 0)
            pico.run(2)
        pico.run(5)
        told = [buttons for _, buttons in _joystick(pico)]
        assert told[-1] == pressed
        assert told in ([pressed], [before, pressed])
        before = pressed


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


def test_tick_has_time_for_so_many_effects_of_a_game_and_more_are_a_fault() -> None:
    # docs/reference/games.md says so. Sines cost most.
    most = {"pico": 3, "pico2": 16}[bench.chosen.name]
    for count, fault in ((most, 0), (min(40, 4 * most), OVERRUN)):
        with bench.enumerated() as pico:
            for _ in range(count):
                _play(pico, FULL // 100, SINE)
            pico.run(20)
            assert pico.get("health")["faults"] == fault
            assert pico.status()["watchdog_resets"] == 0
