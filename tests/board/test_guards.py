"""No part whose failure moves the knob: what each board does when one of its parts goes wrong."""

from __future__ import annotations

import pytest

from tests.board.pico import EmulatedPico, enumerated

OVER_SPEED, ENCODER, CURRENT_SENSOR, WINDING = 1 << 1, 1 << 2, 1 << 6, 1 << 7
STACK_ENDS_AT = {"pico": 0x20041000, "pico2": 0x20081000}


def _push(pico: EmulatedPico) -> None:
    """Arm, and go so deep into a wall that the motor gives all it may."""
    assert pico.set("control_config", passive_ramp_s=0.005)["status"] == 0
    pico.arm_at_wall()
    pico.turn(300)
    pico.run(8)
    assert pico.motor() is not None


def _time_until_off(pico: EmulatedPico, within_ms: float = 20) -> float:
    for n in range(int(within_ms * 4)):
        if pico.motor() is None:
            return n / 4
        pico.run(0.25)
    raise AssertionError("the outputs stay on")


@pytest.mark.parametrize("steady_a", [0.0, 1.0, -0.5], ids=["dead", "stuck high", "stuck low"])
def test_current_sensor_that_does_not_follow_the_current_cuts_the_power(
    pico: EmulatedPico, steady_a: float
) -> None:
    _push(pico)
    pico.do("motor", sensor_amperes=steady_a)
    assert _time_until_off(pico) < 20
    health = pico.get("health")
    assert (health["state"], health["faults"]) == ("fault", WINDING)
    # The sensor works again: cleared, armed, and the motor pushes.
    pico.do("motor")
    assert pico.command("clear_fault") == "ok"
    assert pico.command("arm") == "ok"
    pico.run(20)
    assert pico.motor()
    assert pico.get("health")["faults"] == 0


def test_missing_supply_is_a_fault(pico: EmulatedPico) -> None:
    _push(pico)
    pico.do("motor", supply=0)
    assert _time_until_off(pico) < 20
    assert pico.get("health")["faults"] == WINDING


def test_supply_of_a_quarter_of_the_configured_voltage_is_a_fault(pico: EmulatedPico) -> None:
    # The current loop would give all it has, for ever, and the wall would be soft without a word.
    pico.do("motor", supply=3)
    pico.set("control_config", passive_ramp_s=0.005)
    pico.arm_at_wall()
    pico.turn(300)
    assert _time_until_off(pico) < 20
    health = pico.get("health")
    assert (health["state"], health["faults"]) == ("fault", WINDING)
    # Cleared with a supply as it should be, the motor pushes again.
    pico.do("motor", supply=12)
    assert pico.command("clear_fault") == "ok"
    assert pico.command("arm") == "ok"
    pico.run(20)
    assert pico.motor()
    assert pico.get("health")["faults"] == 0


def test_supply_of_twice_the_configured_voltage_is_a_fault(pico: EmulatedPico) -> None:
    pico.do("motor", supply=24)
    pico.set("control_config", passive_ramp_s=0.005)
    pico.arm_at_wall()
    pico.turn(300)
    assert 60 < _time_until_off(pico, 140) < 140
    assert pico.get("health")["faults"] == WINDING


def test_current_sensor_with_a_wrong_zero_keeps_the_board_from_arming() -> None:
    with enumerated() as pico:
        pico.do("motor", zero=300)
        pico.power_cycle()
        pico.enumerate()
        health = pico.get("health")
        assert (health["state"], health["faults"]) == ("fault", CURRENT_SENSOR)
        assert pico.command("arm") == "fault_latched"
        assert pico.command("clear_fault") == "fault_persists"
        pico.do("motor", zero=1800)
        pico.power_cycle()
        pico.enumerate()
        assert pico.command("arm") == "ok"


def test_trip_level_beyond_the_sensors_range_keeps_the_board_from_arming() -> None:
    with enumerated() as pico:
        pico.set("board_config", current_sense_v_per_a=1.0)  # 3 A are then 3 V
        assert pico.command("save") == "ok"
        pico.power_cycle()
        pico.enumerate()
        assert pico.get("health")["faults"] == CURRENT_SENSOR
        assert pico.command("arm") == "fault_latched"


def test_counts_that_no_knob_makes_are_a_fault(pico: EmulatedPico) -> None:
    _push(pico)
    pico.turn(400, period_us=0.1)  # as noise on a loose cable
    pico.run(0.3)
    assert pico.motor() is None
    assert pico.get("health")["faults"] & ENCODER


def test_board_whose_parts_nobody_has_confirmed_is_held_low() -> None:
    with EmulatedPico() as pico:
        pico.boot()
        pico.enumerate()
        assert pico.get("board_config")["confirmed"] == "off"
        pico.set("control_config", passive_ramp_s=0.005)
        pico.arm_at_wall(stiffness_nm_per_rad=20.0)
        pico.turn(60, period_us=500)  # 1.5 rad/s
        pico.run(10)
        assert pico.do("amperes") == pytest.approx(-15e-3 / 0.05, abs=0.03)
        assert pico.brake() == pytest.approx(30e-3 / 0.44 * 40 / 12, abs=0.01)
        pico.turn(200, period_us=40)  # 19 rad/s
        assert pico.motor() is None
        assert pico.get("health")["faults"] & OVER_SPEED
        assert pico.command("clear_fault") == "ok"
        # Confirmed it may do what it is told, at once.
        pico.set("board_config", confirmed="on")
        assert pico.command("arm") == "ok"
        pico.run(20)
        assert pico.do("amperes") == pytest.approx(-85e-3 / 0.05, abs=0.05)


def test_fresh_board_says_that_it_was_switched_on(lasting_pico: EmulatedPico) -> None:
    assert lasting_pico.get("health")["reset_cause"] == "power"


def test_stack_that_is_too_small_cuts_the_power_and_is_reported(pico: EmulatedPico) -> None:
    _push(pico)
    pico.do("poke", address=STACK_ENDS_AT[pico.model.name], word=0)
    pico.run(0.3)
    assert pico.motor() is None
    pico.run(pico.model.watchdog_ms + 2)
    assert pico.status()["watchdog_resets"] == 1
    pico.enumerate()
    assert pico.get("health")["reset_cause"] == "stack"
