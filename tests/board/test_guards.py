"""No part whose failure moves the knob: what each board does when one of its parts goes wrong."""

from __future__ import annotations

import pytest

from tests.board.dangers import DANGERS, Danger, push, react
from tests.board.pico import EmulatedPico, enumerated

OVER_SPEED, CURRENT_SENSOR = 1 << 1, 1 << 6


@pytest.mark.parametrize("danger", DANGERS, ids=str)
def test_danger_cuts_the_power_and_is_told(lasting_pico: EmulatedPico, danger: Danger) -> None:
    passed_ms, told = react(lasting_pico, danger)
    assert passed_ms <= danger.limit_ms(lasting_pico)
    assert told == danger.tells
    # Mended and cleared it works again.
    push(lasting_pico)
    assert lasting_pico.motor()
    assert lasting_pico.command("disarm") == "ok"
    lasting_pico.turn(-lasting_pico.get("clock")["position_counts"], period_us=2)


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


def test_board_whose_parts_nobody_has_confirmed_is_held_low() -> None:
    with EmulatedPico() as pico:
        pico.boot()
        pico.enumerate()
        assert pico.get("health")["reset_cause"] == "power"
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
