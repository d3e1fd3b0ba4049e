"""Bridges, current sensor and light in cases that the control tests do not meet."""

from __future__ import annotations

import pytest

from tests.board.pico import MS, EmulatedPico, rewired

MOTOR_A = 85e-3 / 0.05  # the reference actuator's torque limit
LIMIT_A = 2.0


def _push_hard(pico: EmulatedPico) -> None:
    """Arm and go so deep into a wall that motor and brake are at their limits."""
    assert pico.set("control_config", passive_ramp_s=0.005)["status"] == 0
    pico.arm_at_wall()
    pico.turn(300)
    pico.run(12)


def test_reversed_motor_pushes_the_other_way_and_its_current_is_held() -> None:
    with rewired(motor_reversed="on") as pico:
        _push_hard(pico)
        for _ in range(5):
            pico.post("command", op="keep_alive")
            pico.run(4)
            assert pico.do("amperes") == pytest.approx(MOTOR_A, abs=0.02)


def test_brake_current_is_limited() -> None:
    with rewired(brake_current_max_a=0.05) as pico:
        _push_hard(pico)
        assert pico.brake() == pytest.approx(0.05 * 40 / 12, abs=pico.model.pwm_step)


def test_over_current_is_a_fault_after_three_measurements_at_one_and_a_half_times_the_limit(
    pico: EmulatedPico,
) -> None:
    _push_hard(pico)
    pico.do("motor", sensor_amperes=1.4 * LIMIT_A)
    pico.run(1)
    assert pico.motor() is not None
    pico.do("motor", sensor_amperes=1.6 * LIMIT_A)
    pico.run(2 * pico.model.step_ns / MS)
    assert pico.motor() is not None
    pico.run(3 * pico.model.tick_ns / MS)
    assert pico.motor() is None
    health = pico.get("health")
    assert (health["state"], health["faults"]) == ("fault", 1 << 3)


def test_both_bridges_and_the_tick_start_at_the_same_moment(pico: EmulatedPico) -> None:
    # Motor on GP6, brake on GP8: units 3 and 4. The tick takes the first that is free.
    assert pico.status()["pwm_starts"] == [1 << 0 | 1 << 3 | 1 << 4]


def test_light_flashes_shortly_without_a_host() -> None:
    with EmulatedPico() as pico:
        pico.boot()
        seen = []
        for until_ms in (30, 100, 300):
            pico.run(until_ms - pico.status()["ns"] / 1e6)
            seen.append(pico.do("high_share", pins=[25])[0])
        assert seen == [1, 0, 0]
        pico.enumerate()
        assert pico.do("high_share", pins=[25]) == [1]
