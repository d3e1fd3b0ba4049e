"""Libraries with which games are written in Python, with the SDL that they bring from PyPI."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.vm.guest.torque_log import let_pass, pieces, plug, read_log
from tests.vm.guest.udev import run
from tests.vm.guest.virtual_bus import TREE, VirtualBus, wait_for

pytestmark = [pytest.mark.games, pytest.mark.usefixtures("udev")]

PYTHON = TREE / "build/players/bin/python"
# Each defines what it sees, a shake where the library has one, and the state: axis, buttons.
PYGAME = """
import pygame
pygame.display.init()
pygame.joystick.init()
(knob,) = map(pygame.joystick.Joystick, range(pygame.joystick.get_count()))
seen = (knob.get_name(), knob.get_numaxes(), knob.get_numbuttons())
def shake():
    return knob.rumble(0.5, 0.5, 400)
def state():
    pygame.event.pump()
    return knob.get_axis(0), knob.get_button(0), knob.get_button(1)
"""
PYSDL2 = """
from sdl2 import *
SDL_Init(SDL_INIT_VIDEO | SDL_INIT_JOYSTICK)
assert SDL_NumJoysticks() == 1
knob = SDL_JoystickOpen(0)
seen = (SDL_JoystickName(knob).decode(), SDL_JoystickNumAxes(knob), SDL_JoystickNumButtons(knob))
def shake():
    return SDL_JoystickRumble(knob, 32768, 32768, 400) == 0
def state():
    SDL_PumpEvents()
    x = SDL_JoystickGetAxis(knob, 0) / 32767
    return x, SDL_JoystickGetButton(knob, 0), SDL_JoystickGetButton(knob, 1)
"""
PYGLET = """
import pyglet
pyglet.options.shadow_window = False
(knob,) = pyglet.input.get_joysticks()
knob.open()
axes = [axis for axis in knob.device.controls if isinstance(axis, pyglet.input.AbsoluteAxis)]
seen = (knob.device.name, len(axes), len(knob.buttons))
shake = None
def state():
    while knob.device.poll():
        knob.device.select()
    return knob.x, *knob.buttons
"""
END = """
import time
print(*seen, sep=", ", flush=True)
if shake:
    print("shakes:", shake(), flush=True)
told = None
while True:
    x, *buttons = state()
    now = f"state {x:.2f} {[*map(int, buttons)]}"
    if now != told:
        print(now, flush=True)
    told = now
    time.sleep(0.02)
"""


@pytest.mark.parametrize(
    ("program", "shakes"),
    [(PYGAME, True), (PYSDL2, True), (PYGLET, False)],
    ids=["pygame", "PySDL2", "pyglet"],
)
def test_library_sees_axis_and_buttons_and_shakes_the_knob_if_it_can(
    bus: VirtualBus, tmp_path: Path, program: str, shakes: bool
) -> None:
    knob, log = plug(bus, tmp_path)
    run("udevadm", "settle")
    said = tmp_path / "said"
    dummy = {"SDL_VIDEODRIVER": "dummy", "SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS": "1"}
    with said.open("w") as out:
        player = subprocess.Popen(
            (PYTHON, "-c", program + END), env=dummy, stdout=out, stderr=subprocess.STDOUT
        )

    def hear(words: str) -> None:
        wait_for(words, lambda: words in said.read_text())

    hear("Torsio haptic knob, 2, 2")
    if shakes:
        hear("shakes: True")
    let_pass(knob, 1.0)
    for order, words in (
        ("buttons 1", "state 0.00 [1, 0]"),
        ("buttons 2", "state 0.00 [0, 1]"),
        ("angle 1", "state 0.13 [0, 1]"),  # of 7.85 rad
    ):
        knob.say(order)
        hear(words)
    player.kill()  # SDL makes an event of SIGTERM
    player.wait(30)
    time_s, _, torque = read_log(bus, log)
    peaks = [np.abs(part).max() for _, part in pieces(time_s, torque, 0.3)] if shakes else []
    assert peaks == pytest.approx([0.5] * shakes, rel=0.02)
