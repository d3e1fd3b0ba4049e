"""Encoder, motor, brake and light: what the pins do."""

from __future__ import annotations

import itertools
import random

import pytest

from tests.board.pico import EmulatedPico, restart_saved, rewired

COUNTS_PER_REV = 8192
MOTOR_NM_PER_A = 0.05
BRAKE_NM_PER_A = 0.44
BRAKE_OHM = 40
SUPPLY_V = 12
MOTOR_MAX_NM = 85e-3


def _position(pico: EmulatedPico) -> int:
    pico.run(0.3)
    return int(pico.get("clock")["position_counts"])


def _wall(pico: EmulatedPico, side: str = "above", beta: float = 0.5) -> None:
    """Arm with a wall at angle 0 that is at full strength."""
    assert pico.set("control_config", beta=beta, passive_ramp_s=0.005)["status"] == 0
    pico.arm_at_wall(side=side)
    pico.run(6)


def test_default_lag_of_the_motor_is_that_of_the_boards_own_current_loop(
    lasting_pico: EmulatedPico,
) -> None:
    told_s = lasting_pico.get("actuator_config")["motor_time_constant_s"]
    assert told_s == pytest.approx(lasting_pico.model.motor_lag_s, rel=0.03)


@pytest.mark.parametrize("edges", [1, -1, 4, 250, -250])
def test_every_edge_of_the_encoder_is_one_count(pico: EmulatedPico, edges: int) -> None:
    pico.turn(edges)
    assert _position(pico) == edges


def test_fast_reversals_lose_no_count(pico: EmulatedPico) -> None:
    # Half a microsecond from edge to edge: 244 turns a second.
    generator = random.Random(4)
    position = 0
    for _ in range(60):
        edges = generator.choice([-7, -3, -2, -1, 1, 2, 3, 7])
        pico.turn(edges, period_us=0.5)
        position += edges
    assert _position(pico) == position


def test_index_of_the_encoder_brings_the_centre_back_after_a_power_cycle() -> None:
    at = 0
    with rewired(report="actuator_config", counts_per_rev=32, encoder_index_pin=4) as pico:

        def turn(counts: int) -> str:
            nonlocal at
            for _ in range(counts):
                at += 1
                pico.do("pin", pin=4, high=at % 32 == 0)
                pico.turn(1, period_us=0.5)
                pico.run(0.15)
            pico.run(0.3)
            return str(pico.get("health")["centre"])

        pico.do("pin", pin=4, high=False)  # or the board's resistor pulls it up
        pico.run(0.3)
        assert turn(40) == "awaits_index"
        assert turn(32) == "index"
        assert pico.command("zero") == "ok"
        turn(5)
        restart_saved(pico)
        assert turn(40) == "awaits_index"
        assert turn(15) == "index"
        assert _position(pico) == 60


def test_counter_wraps_at_32_bits_in_both_directions_unnoticed(pico: EmulatedPico) -> None:
    # The counter starts 16 counts before its wrap.
    position = 0
    for edges, counter in [(0, 2**32 - 16), (40, 24), (-80, 2**32 - 56), (40, 2**32 - 16)]:
        pico.turn(edges)
        position += edges
        assert _position(pico) == position
        assert pico.do("encoder_counter") == counter


def test_narrow_counter_and_reversed_encoder_are_configuration(pico: EmulatedPico) -> None:
    pico.set("actuator_config", counts_per_rev=64, counter_bits=8, encoder_reversed="on")
    before = _position(pico)
    for _ in range(10):
        pico.turn(50, period_us=20)
    assert _position(pico) - before == -500


def test_no_torque_before_arming(pico: EmulatedPico) -> None:
    wall = {"angle_turns_q32": 0, "side": "above", "stiffness_nm_per_rad": 2.0}
    pico.send("wall", slot=0, damping_nm_s_per_rad=0.0, **wall)
    pico.send("commit", active=1)
    pico.turn(200)
    pico.run(5)
    assert pico.motor() is None
    assert pico.brake() is None


@pytest.mark.parametrize(("side", "direction"), [("above", 1), ("below", -1)])
def test_wall_makes_the_motor_push_back(pico: EmulatedPico, side: str, direction: int) -> None:
    _wall(pico, side)
    assert pico.motor() == pytest.approx(0, abs=2 * pico.model.pwm_step)
    pico.turn(-20 * direction)
    pico.run(2)
    assert pico.motor() == pytest.approx(0, abs=2 * pico.model.pwm_step)  # outside of it
    pico.turn(40 * direction)
    pico.run(4)
    motor = pico.motor()
    assert motor is not None
    assert motor * direction < -0.05


@pytest.mark.parametrize("beta", [0.2523, 0.75])
def test_brake_voltage_follows_beta(pico: EmulatedPico, beta: float) -> None:
    _wall(pico, beta=beta)
    pico.turn(50)
    pico.run(2)
    depth_rad = 50 * 2 * 3.14159265 / COUNTS_PER_REV
    torque_nm = 2.0 * depth_rad
    wanted = beta * torque_nm / BRAKE_NM_PER_A * BRAKE_OHM / SUPPLY_V
    # Nobody measures this current, so the nearest step counts.
    assert pico.brake() == pytest.approx(wanted, abs=0.55 * pico.model.pwm_step)


@pytest.mark.parametrize("zero", [2048, 1900])
def test_current_loop_gives_the_motor_its_torque(pico: EmulatedPico, zero: int) -> None:
    pico.do("motor", zero=zero)
    pico.run(200)  # the sensor's zero is learned while the power is off
    _wall(pico)
    pico.turn(300)
    pico.run(8)
    amperes = pico.do("amperes")
    assert amperes == pytest.approx(-MOTOR_MAX_NM / MOTOR_NM_PER_A, abs=0.02)
    # A winding of twice the resistance and a lower supply: the current stays.
    pico.do("motor", zero=zero, ohm=5.0, supply=11)
    pico.run(15)
    assert pico.do("amperes") == pytest.approx(-MOTOR_MAX_NM / MOTOR_NM_PER_A, abs=0.02)


def _light(pico: EmulatedPico, samples: int, step_ms: float) -> list[int]:
    seen = []
    for _ in range(samples):
        pico.run(step_ms)
        seen.append(round(pico.do("high_share", pins=[25])[0]))
    return seen


def test_light_tells_the_states_apart(pico: EmulatedPico) -> None:
    # An emulated millisecond is dear, so each state is watched until it cannot be another one.
    disarmed = _light(pico, 1, 25)
    while len(set(disarmed)) == 1:
        assert len(disarmed) < 22, "half a second and no change"
        disarmed += _light(pico, 1, 25)
    # In a fault it would change again after 62 ms.
    assert set(_light(pico, 4, 25)) == {disarmed[-1]}
    _wall(pico)
    armed = []
    for _ in range(2):
        pico.post("command", op="keep_alive")
        armed += _light(pico, 3, 10)
    assert set(armed) == {1}
    pico.emergency_stop(pressed=True)
    fault = _light(pico, 17, 12.5)
    assert sum(a != b for a, b in itertools.pairwise(fault)) >= 3
