"""A calibration's excitations through both binaries; ./dev bench calibration does whole ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import torsio
from tests.board import felt, pico
from tests.board.live import live_knob
from tests.board.world import LEAD_S, World
from torsio.calibration.electric import intervals
from torsio.calibration.play import Player, Run
from torsio.printed.plant import Electrics, PlantParams
from torsio.printed.told import MotorCurrent

# Parts are other than the board is told: seen torques and currents are 1.06 times the true ones,
# and seen volts 1 / 0.95 times.
SENSOR, SUPPLY = 1.06, 0.95
PLANT = PlantParams(knob_inertia_kg_m2=1e-4, brake_inertia_kg_m2=5e-5)
RESISTANCE_OHM = 2.3
TORQUE_NM, STRETCH_S = 40e-3, 0.06


@pytest.fixture
def knob(_model: None) -> Iterator[torsio.Knob]:
    """Give the chosen board, which knows nothing of its knob but counts and limits."""
    electrics = felt.ELECTRICS[pico.chosen.name]
    electrics = replace(
        electrics,
        supply_v=SUPPLY * electrics.supply_v,
        sensor_v_per_a=SENSOR * electrics.sensor_v_per_a,
        winding_resistance_ohm=RESISTANCE_OHM,
    )
    with live_knob(replace(PLANT, electrics=electrics)) as (knob, _):
        # For so long the winding stands more.
        knob.update(motor_current_continuous_a=2.0)
        yield knob


def _acceleration(log: Run, begin_s: float) -> float:
    part = log.between(begin_s + 0.01, begin_s + STRETCH_S - 2e-3)
    return 2.0 * float(np.polyfit(part.time_s - part.time_s[0], part.angle_rad, 2)[0])


def test_torques_to_and_fro_tell_the_inertia_through_the_binary(knob: torsio.Knob) -> None:
    with Player.playing(knob) as player:
        log = player.chain(
            [
                (STRETCH_S, {"motor_command_nm": TORQUE_NM}),
                (STRETCH_S, {"motor_command_nm": -TORQUE_NM}),
            ],
            travel_rad=20.0,
            speed_limit_rad_s=60.0,
            torque_limit_nm=TORQUE_NM,
        )
    assert knob.state == "disarmed"
    # Samples come from the first excitation on, which the chain begins with.
    assert log.stopped == ""
    begin_s = float(log.time_s[np.argmax(log.motor_nm > 0.5 * TORQUE_NM)] - log.time_s[0])
    faster = _acceleration(log, begin_s) - _acceleration(log, begin_s + STRETCH_S)
    # It turns one way in both, so friction drops out.
    assert 2.0 * TORQUE_NM / faster == pytest.approx(SENSOR * 15e-5, rel=0.05)


def test_board_in_a_world_sees_the_current_through_the_sensor_that_is_there() -> None:
    electrics = Electrics(sensor_v_per_a=0.22, sensor_noise_v=0.0)  # and a board is told 0.2
    world = World(PlantParams(electrics=electrics))
    for _ in range(400):
        world.pass_period(0.3, 0.0, True)
    flows_a = world.circuit.current_a(electrics.sample_offset_s - LEAD_S)
    seen_a, _ = world.pass_period(0.3, 0.0, True)
    assert flows_a > 0.1
    assert seen_a == pytest.approx(1.1 * flows_a)


def test_currents_of_a_held_knob_tell_its_resistance_through_the_binary(knob: torsio.Knob) -> None:
    looks: dict[int, list[MotorCurrent]] = {}
    supply_v = knob.board_config().supply_v
    with Player.playing(knob) as player:

        def look(stretch: int) -> MotorCurrent:
            now = player.motor_current()
            looks.setdefault(stretch, []).append(now)
            return now

        log = player.chain(
            [
                (0.3, {"motor_command_nm": 0.0}),
                (0.06, {"motor_command_nm": 15e-3}),
                (0.06, {"motor_command_nm": 40e-3}),
            ],
            look=look,
            look_every_s=0.02,
            brake_command_nm=0.1,
            travel_rad=0.4,
            speed_limit_rad_s=60.0,
            torque_limit_nm=40e-3,
        )
    assert log.stopped == ""
    # The last 40 ms of each: winding and shaft have settled by then.
    less, more = (intervals(looks[stretch][-3:], supply_v) for stretch in (1, 2))
    volts, amperes = (
        [float(np.sum(of) / np.sum(part.duration_s)) for part, of in pairs]
        for pairs in (
            ((less, less.voltage_v_s), (more, more.voltage_v_s)),
            ((less, less.charge_c), (more, more.charge_c)),
        )
    )
    # Both include the bridge's own current.
    resistance = (volts[1] - volts[0]) / (amperes[1] - amperes[0])
    assert resistance == pytest.approx(RESISTANCE_OHM / SUPPLY / SENSOR, rel=0.03)
    assert amperes[1] == pytest.approx(40e-3 / 0.05, rel=0.02)
