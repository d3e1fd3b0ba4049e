"""What keeps a hand safe and a configuration whole."""

from __future__ import annotations

import pytest

from tests.board.pico import SLOTS_AT, EmulatedPico, PowerCut, enumerated


def _push(pico: EmulatedPico) -> None:
    """Arm, and push into a wall until motor and brake are on."""
    assert pico.set("control_config", passive_ramp_s=0.005, watchdog_s=0.05)["status"] == 0
    wall = {"angle_turns_q32": 0, "side": "above", "stiffness_nm_per_rad": 2.0}
    pico.send("wall", slot=0, damping_nm_s_per_rad=0.0, **wall)
    pico.send("commit", active=1)
    assert pico.command("arm") == "ok"
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


def test_bus_reset_makes_it_safe_at_once(pico: EmulatedPico) -> None:
    _push(pico)
    pico.post("command", op="keep_alive")
    pico.do("bus_reset")
    assert pico.motor() is None
    pico.enumerate()
    assert pico.get("health")["state"] == "disarmed"


def test_program_that_hangs_is_restarted_with_its_outputs_off(pico: EmulatedPico) -> None:
    _push(pico)
    pico.do("hang")
    pico.run(51)
    assert pico.status()["watchdog_resets"] == 1
    assert pico.motor() is None
    pico.enumerate()
    assert pico.get("health")["state"] == "disarmed"


def test_idle_device_is_not_restarted_by_its_watchdog(pico: EmulatedPico) -> None:
    pico.run(150)
    status = pico.status()
    assert (status["watchdog_resets"], status["lost"]) == (0, False)


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


# An erased sector is 4096 bytes; of the page written into it the first 208 matter, of which the
# last is 0xFF here, as erased flash is.
@pytest.mark.parametrize("after_bytes", [0, 1, 100, 4095, 4096, 4097, 4200, 4300, 4302])
def test_power_cut_in_the_middle_of_a_save_keeps_the_last_one(after_bytes: int) -> None:
    with enumerated() as pico:
        for beta in (0.25, 0.375):
            pico.set("control_config", beta=beta)
            assert pico.command("save") == "ok"
        pico.set("control_config", beta=0.875)
        pico.do("cut_flash", after_bytes=after_bytes)
        with pytest.raises(PowerCut):
            pico.command("save")
        pico.power_cycle()
        pico.enumerate()
        assert pico.get("control_config")["beta"] == 0.375
        assert pico.get("health")["saves"] == 2
        assert pico.command("save") == "ok"


def test_save_touches_only_its_own_two_sectors(pico: EmulatedPico) -> None:
    before = pico.do("flash", address=0, size=SLOTS_AT)
    for _ in range(3):
        assert pico.command("save") == "ok"
    assert pico.do("flash", address=0, size=SLOTS_AT) == before


def test_bootloader_is_refused_while_armed_and_entered_while_not(pico: EmulatedPico) -> None:
    _push(pico)
    assert pico.command("bootloader") == "not_disarmed"
    assert pico.command("disarm") == "ok"
    assert pico.command("bootloader") == "ok"
    assert not pico.status()["bootloader"]  # the answer goes first
    pico.run(110)
    assert pico.status()["bootloader"]
    assert pico.motor() is None


def test_saving_while_armed_is_refused(pico: EmulatedPico) -> None:
    _push(pico)
    assert pico.command("save") == "not_disarmed"


def test_wiring_takes_effect_only_at_the_next_start(pico: EmulatedPico) -> None:
    pico.set("board_config", enable_pin=20)
    _push(pico)
    assert pico.do("high_share", pins=[10, 20]) == [1, None]
