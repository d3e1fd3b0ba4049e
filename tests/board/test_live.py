"""Ordinary Python against a board's binary: the SDK's own knob, and what a hand feels of it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import torsio
from tests.board import pico
from tests.board.felt import plant_of
from tests.board.live import live_knob
from torsio.telemetry import Record

WALL = torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=math.degrees(30e-3))
DEEPEST_RAD = WALL.angle_rad + 0.06  # the hand's aim; some 70 mN m
MOVE_S, HOLD_S = 0.12, 0.04


def visit(knob: torsio.Knob, begin_hand: Any) -> Record:
    """Push into a wall and come out again: a program as a user writes it."""
    knob.update(law="compensated", passive_ramp_s=0.005, speed_limit_rad_s=100.0)
    knob.play(WALL)
    knob.arm()
    begin_hand(
        lambda now_s: torsio.ImpedanceHand(
            stiffness_nm_per_rad=10.0, damping_nm_s_per_rad=10e-3, inertia_kg_m2=1e-4,
            intended_angle_rad=[
                (now_s, 0.0), (now_s + MOVE_S, DEEPEST_RAD),
                (now_s + MOVE_S + HOLD_S, DEEPEST_RAD), (now_s + 2 * MOVE_S + HOLD_S, 0.0),
            ],
        )
    )  # fmt: skip
    log = knob.record(2 * MOVE_S + HOLD_S + 0.02)
    assert knob.state == "armed"
    assert knob.faults() == ()
    knob.disarm()
    return log


def felt_nm(log: Record) -> Any:
    return log["spring_torque_nm"] + log["motor_command_nm"]


def test_program_feels_the_wall_of_a_binary_as_that_of_the_emulated_device() -> None:
    board = pico.chosen
    params = plant_of(board.name)
    with live_knob(params) as (knob, world):
        assert knob.info.board == board.name
        real = visit(knob, lambda hand: world.set_hand(hand(world.time_s)))

    options = torsio.EmulatorOptions(plant=params, control_rate_hz=1e9 / board.tick_ns)
    with torsio.open("emulated", emulator=options) as knob:
        emulator = knob.emulator
        assert emulator is not None
        emulated = visit(knob, lambda hand: emulator.set_hand(hand(0.0)))

    deepest = [float(np.max(log["angle_rad"])) for log in (real, emulated)]
    assert min(deepest) > WALL.angle_rad + 0.02
    # One count is 0.8 mrad, and 1.3 mN m of this wall.
    assert abs(deepest[0] - deepest[1]) < 2e-3
    for log in (real, emulated):
        # Against the wall itself, from the angle that the program sees.
        inside = log["angle_rad"] > WALL.angle_rad
        wanted_nm = -WALL.stiffness_nm_per_rad * (log["angle_rad"][inside] - WALL.angle_rad)
        error_nm = felt_nm(log)[inside] - wanted_nm
        assert float(np.sqrt(np.mean(error_nm**2))) < 5e-3
    # The same depth has the same torque at any time.
    depth = np.linspace(0.01, min(deepest) - WALL.angle_rad - 2e-3, 20)
    for way in (slice(None, None), slice(None, None, -1)):
        found = []
        for log in (real, emulated):
            angle, torque = log["angle_rad"][way], felt_nm(log)[way]
            top = int(np.argmax(angle))
            rising = np.maximum.accumulate(angle[: top + 1])
            found.append(np.interp(WALL.angle_rad + depth, rising, torque[: top + 1]))
        assert float(np.max(np.abs(found[0] - found[1]))) < 4e-3
