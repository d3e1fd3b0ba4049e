"""The guards that keep a hand safe and a configuration whole."""

from __future__ import annotations

import pytest

from tests.board.dangers import keep_busy
from tests.board.pico import MS, EmulatedPico, PowerCut, enumerated

WEAK_DAMPED = {"stiffness_nm_per_rad": 0.1, "damping_nm_s_per_rad": 1e-4}


def _push(pico: EmulatedPico) -> None:
    """Arm, and push into a wall until motor and brake are on."""
    assert pico.set("control_config", passive_ramp_s=0.005, watchdog_s=0.05)["status"] == 0
    pico.arm_at_wall()
    pico.turn(120)
    pico.run(8)
    assert pico.motor()
    assert pico.brake()


def test_silent_host_switches_both_outputs_off_within_the_watchdog_time(
    pico: EmulatedPico,
) -> None:
    _push(pico)
    pico.post("command", op="keep_alive")
    pico.run(45)
    assert pico.motor() is not None
    pico.run(12)  # the rest of 50 ms, and 5 ms for the ramp
    assert pico.motor() is None
    assert pico.brake() is None
    assert pico.get("health")["state"] == "disarmed"


def test_suspended_bus_makes_it_safe_at_once(pico: EmulatedPico) -> None:
    _push(pico)
    pico.post("command", op="keep_alive")
    pico.do("suspend")
    pico.run(6.5)
    assert pico.motor() is None
    assert pico.brake() is None
    pico.do("resume")
    pico.run(1)
    assert pico.get("health")["state"] == "disarmed"
    assert pico.command("arm") == "ok"


def test_device_that_loses_its_usb_configuration_makes_it_safe_at_once(
    pico: EmulatedPico,
) -> None:
    _push(pico)
    pico.post("command", op="keep_alive")
    pico.control(0x00, 9, 0, 0, 0)
    pico.run(6.5)
    assert pico.motor() is None
    assert pico.brake() is None
    pico.control(0x00, 9, 1, 0, 0)
    assert pico.get("health")["state"] == "disarmed"
    assert pico.command("arm") == "ok"


def test_bus_reset_makes_it_safe_at_once(pico: EmulatedPico) -> None:
    _push(pico)
    pico.post("command", op="keep_alive")
    pico.do("bus_reset")
    assert pico.motor() is None
    pico.enumerate()
    assert pico.get("health")["state"] == "disarmed"


def test_idle_device_is_not_restarted_by_its_watchdog(pico: EmulatedPico) -> None:
    pico.run(150)
    status = pico.status()
    assert (status["watchdog_resets"], status["lost"]) == (0, False)


def test_scene_that_hardly_fits_and_a_host_that_never_rests_leave_the_watchdog_half_its_time(
    pico: EmulatedPico,
) -> None:
    starved_ms = keep_busy(pico, walls=5 if pico.model.name == "pico" else 16)
    assert pico.get("health")["state"] == "armed"
    assert pico.status()["watchdog_resets"] == 0
    assert 0.05 < starved_ms < 0.5 * pico.model.watchdog_ms


def test_configuration_survives_a_power_cycle() -> None:
    with enumerated() as pico:
        pico.set("control_config", beta=0.625)
        pico.set("board_config", light_pin=22, supply_v=24)
        assert pico.command("save") == "ok"
        pico.set("control_config", beta=0.125)  # not saved
        pico.power_cycle()
        pico.enumerate()
        assert pico.get("control_config")["beta"] == 0.625
        assert pico.get("board_config")["light_pin"] == 22
        assert pico.get("health")["saves"] == 1
        # The wiring took effect: the light is elsewhere now.
        assert pico.do("high_share", pins=[22, 25])[1] is None


def test_ticks_go_on_while_the_flash_is_written(pico: EmulatedPico) -> None:
    pico.turn(30)
    before = pico.get("clock")
    assert pico.command("save") == "ok"
    after = pico.get("clock")
    health = pico.get("health")
    assert health["tick_overruns"] == 0
    assert after["tick"] - before["tick"] > 400  # erasing takes 45 ms
    assert after["position_counts"] == 30


def test_slowest_erase_is_no_reason_for_the_watchdog(pico: EmulatedPico) -> None:
    pico.do("erase_time", ns=400 * MS)
    assert pico.command("save") == "ok"
    assert pico.status()["watchdog_resets"] == 0


def test_save_that_the_flash_does_not_take_is_refused_and_may_be_tried_again() -> None:
    with enumerated() as pico:
        pico.set("control_config", beta=0.25)
        assert pico.command("save") == "ok"
        pico.set("control_config", beta=0.75)
        pico.do("spoil_flash", byte=150)
        assert pico.command("save") == "busy"
        assert pico.get("health")["saves"] == 1
        assert pico.command("save") == "ok"
        pico.power_cycle()
        pico.enumerate()
        assert pico.get("control_config")["beta"] == 0.75


# An erased sector has 4096 bytes. Of the written page the first 208 bytes matter. The last one is
# 0xFF here, like erased flash. The slots take turns, also across a restart.
@pytest.mark.one_board
@pytest.mark.parametrize(
    ("saves", "restarted", "after_bytes"),
    [
        *((saves, restarted, 4200) for saves in (1, 2, 3) for restarted in (False, True)),
        *((2, False, 0), (2, True, 1), (3, False, 100), (2, False, 4095)),
        *((1, False, 4096), (3, True, 4097), (2, True, 4302)),
    ],
)
def test_power_cut_in_the_middle_of_a_save_keeps_the_last_one(
    saves: int, restarted: bool, after_bytes: int
) -> None:
    with enumerated() as pico:
        pico.do("erase_time", ns=MS)
        for save in range(saves):
            pico.set("control_config", beta=0.125 * save)
            assert pico.command("save") == "ok"
        if restarted:
            pico.power_cycle()
            pico.enumerate()
        pico.set("control_config", beta=0.875)
        pico.do("cut_flash", after_bytes=after_bytes)
        with pytest.raises(PowerCut):
            pico.command("save")
        pico.power_cycle()
        pico.enumerate()
        assert pico.get("control_config")["beta"] == 0.125 * (saves - 1)
        assert pico.get("health")["saves"] == saves


def test_save_touches_only_its_own_two_sectors(pico: EmulatedPico) -> None:
    before = pico.do("flash", address=0, size=pico.model.slots_at)
    for _ in range(3):
        assert pico.command("save") == "ok"
    assert pico.do("flash", address=0, size=pico.model.slots_at) == before


def test_bootloader_is_refused_while_armed_and_arming_on_the_way_to_it(
    pico: EmulatedPico,
) -> None:
    _push(pico)
    assert pico.command("bootloader") == "not_disarmed"
    assert pico.command("disarm") == "ok"
    assert pico.command("bootloader") == "ok"
    assert pico.command("arm") == "busy"
    assert pico.motor() is None
    assert not pico.status()["bootloader"]  # the answer goes first
    pico.run(110)
    assert pico.status()["bootloader"]
    # The pins are plain low outputs then, not the PWM's any more.
    assert pico.do("pin_functions", pins=[6, 7, 8, 9, 10]) == [5] * 5
    assert pico.do("high_share", pins=[6, 7, 8, 9, 10]) == [0] * 5


# Twelve take a little more than the period, so that hardly a tick is missed, and yet the main loop
# gets no time.
@pytest.mark.parametrize("walls", [12, 16])
def test_scene_that_takes_too_long_is_a_fault_and_the_bus_stays_alive(
    pico: EmulatedPico, walls: int
) -> None:
    pico.turn(60)
    pico.arm_at_wall(walls, **WEAK_DAMPED)
    pico.run(3)
    if pico.model.name == "pico2":  # its floating point has time for the largest scene
        assert pico.get("health")["state"] == "armed"
        assert pico.get("health")["tick_overruns"] == 0
        return
    assert pico.motor() is None
    assert pico.brake() is None
    health = pico.get("health")
    assert (health["state"], health["faults"]) == ("fault", 1 << 4)
    assert health["tick_overruns"] > 0 or walls == 12
    assert health["tick_time_max_ns"] > 95_000
    assert pico.command("clear_fault") == "ok"
    pico.arm_at_wall(4, **WEAK_DAMPED)
    pico.run(20)
    assert pico.get("health")["state"] == "armed"
    assert pico.status()["watchdog_resets"] == 0


@pytest.mark.parametrize("walls", [0, 4])
def test_measured_tick_time_is_what_the_bench_sees(pico: EmulatedPico, walls: int) -> None:
    pico.turn(60)
    if walls:
        pico.arm_at_wall(walls, **WEAK_DAMPED)
    pico.run(5)
    health = pico.get("health")
    seen = pico.status()["tick_ns"]
    # The bench sees the processor enter and leave as well, and the current being taken.
    assert health["tick_time_max_ns"] == pytest.approx(seen["most"], rel=0.1)
    if pico.model.step_ns == pico.model.tick_ns:  # or the last interrupt may have been no tick
        # The device tells of the tick before, which may have had more or less to do.
        assert 0.5 * seen["last"] < health["tick_time_ns"] < 1.1 * seen["most"]
    assert health["tick_overruns"] == 0


def test_saving_while_armed_is_refused(pico: EmulatedPico) -> None:
    _push(pico)
    assert pico.command("save") == "not_disarmed"


def test_wiring_takes_effect_only_at_the_next_start(pico: EmulatedPico) -> None:
    pico.set("board_config", enable_pin=20)
    _push(pico)
    assert pico.do("high_share", pins=[10, 20]) == [1, None]
