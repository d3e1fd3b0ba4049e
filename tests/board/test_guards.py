"""No part whose failure moves the knob: what each board does when one of its parts goes wrong.

And what would be if it did not: with firmware in which that guard is switched off.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator

import pytest

from tests.board import felt
from tests.board import pico as bench
from tests.board.dangers import (
    DANGERS,
    DIVIDER,
    FINE_MS,
    LITTLE,
    PLENTY,
    PUSHED_A,
    SUPPLY_DANGERS,
    SUPPLY_RETURNS_MS,
    Danger,
    Left,
    arm_while_bridge_wakes,
    endure,
    foreseen,
    hold_warm,
    named,
    push,
    react,
    start_with_other_layout,
    time_until_off_ms,
)
from tests.board.pico import EmulatedPico, confirm, enumerated, rewired
from tests.board.run_aways import RUN_AWAYS, RunAway
from tests.board.unguarded import GUARDS, image, mutated, start_without, take_away, unguarded
from tests.mcu.mcu import as_documented
from tools.dev.building import EVERY_BOARD_VARIABLE

OVER_SPEED, ENCODER, ACTUATOR, OVERRUN = 1 << 1, 1 << 2, 1 << 3, 1 << 4
CURRENT_SENSOR, WINDING, TEMPERATURE, SUPPLY = 1 << 6, 1 << 7, 1 << 8, 1 << 9


each_run_away = pytest.mark.parametrize(
    "danger",
    [
        pytest.param(one, marks=[] if one.both_boards else pytest.mark.one_board)
        for one in RUN_AWAYS
    ],
    ids=str,
)
WARM = {
    "motor": "motor gets 1.7 A, 0.2 A being allowed for ever",
    "coil": "coil gets 0.25 A, 0.006 A being allowed for ever",
}


@pytest.fixture(scope="module")
def bare_pico(_model: None) -> Iterator[EmulatedPico]:
    """Give many tests a board whose guards can be switched off."""
    with unguarded() as board:
        yield board


@pytest.fixture(scope="module")
def watching_pico(_model: None) -> Iterator[EmulatedPico]:
    """Give many tests a board with a divider at its supply."""
    with rewired(**DIVIDER) as board:
        yield board


@pytest.fixture(scope="module")
def bare_watching_pico(_model: None) -> Iterator[EmulatedPico]:
    """Give many tests such a board whose guards can be switched off."""
    with rewired(image(), **DIVIDER) as board:
        take_away(board)
        yield board


# Where both boards run, the table of docs/results.md is held against what they do.
PAGES = EVERY_BOARD_VARIABLE in os.environ


def _documented(name: str) -> tuple[str, str, str]:
    """Give a danger's row of that table, as the chosen board has it.

    Returns
    -------
    tuple
        Its reaction, what it is told as, and what is without the guard.
    """
    text = (bench.TREE / "docs" / "results.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (.*) \| (.*) \| (.*) \| (.*) \| (.*) \| .*\|$", text, re.MULTILINE)
    name = re.sub("^(encoder|motor)'s sign", "encoder's or motor's sign", name)
    (cells,) = (cells for danger, *cells in rows if danger == name)
    at = ["pico2", "pico"].index(bench.chosen.name)
    both = cells[3].split(" or ")  # where they are apart
    return cells[at], cells[2], both[min(at, len(both) - 1)]


def _documented_ms(name: str) -> float:
    reaction, _, _ = _documented(name)
    return 0.0 if reaction == "at once" else float(reaction.removesuffix(" ms"))


def test_every_guard_is_where_it_is_said_to_be() -> None:
    assert "torsio_mutant_is(0)" in mutated()[GUARDS["emergency stop"].file]


@pytest.mark.boards_in_turn
@pytest.mark.parametrize("danger", DANGERS, ids=str)
def test_danger_cuts_the_power_and_is_told(lasting_pico: EmulatedPico, danger: Danger) -> None:
    _check_reaction(lasting_pico, danger)


@pytest.mark.parametrize("danger", SUPPLY_DANGERS, ids=str)
def test_another_supply_cuts_the_power_of_a_board_that_measures_it(
    watching_pico: EmulatedPico, danger: Danger
) -> None:
    _check_reaction(watching_pico, danger)


def _check_reaction(lasting_pico: EmulatedPico, danger: Danger) -> None:
    passed_ms, told = react(lasting_pico, danger)
    assert passed_ms <= danger.limit_ms(lasting_pico)
    assert told == danger.tells
    if PAGES:
        _check_page(danger, passed_ms)
    # Mended and cleared it works again.
    push(lasting_pico)
    assert lasting_pico.motor()
    assert lasting_pico.command("disarm") == "ok"
    lasting_pico.turn(-lasting_pico.get("clock")["position_counts"], period_us=2)


def _check_page(danger: Danger, passed_ms: float) -> None:
    assert f"`{danger.tells}`" in _documented(danger.name)[1]
    # The table has the worst of 16 moments. A slow fault may take half as long again in others.
    worst_ms = _documented_ms(danger.name)
    assert worst_ms / 2 - FINE_MS <= passed_ms
    if worst_ms < 10.0:
        assert passed_ms <= worst_ms * (1 + as_documented(0.1)) + 2 * FINE_MS


@pytest.mark.parametrize("share", [0.0, 0.2, 0.4, 0.6])
def test_control_interrupt_that_hangs_anywhere_in_its_tick_is_cut(
    lasting_pico: EmulatedPico, share: float
) -> None:
    push(lasting_pico)
    tick_us = 1e-3 * lasting_pico.get("health")["tick_time_max_ns"]
    before = lasting_pico.status()["watchdog_resets"]
    # The longest tick was longer than one that only pushes.
    lasting_pico.do("hang", inside_us=share * tick_us)
    passed_ms = time_until_off_ms(lasting_pico, lasting_pico.model.watchdog_ms + 5)
    assert passed_ms <= lasting_pico.model.watchdog_ms + 0.5
    assert lasting_pico.status()["watchdog_resets"] == before + 1
    lasting_pico.run(lasting_pico.model.watchdog_ms + 2)
    lasting_pico.enumerate()
    confirm(lasting_pico)
    assert lasting_pico.get("health")["reset_cause"] == "watchdog"


@pytest.mark.unguarded
@pytest.mark.boards_in_turn
@pytest.mark.parametrize("danger", DANGERS, ids=str)
def test_danger_keeps_the_power_on_without_its_guard(
    bare_pico: EmulatedPico, danger: Danger
) -> None:
    left = _check_what_is_left(bare_pico, danger)
    if danger.name in ("current sensor stuck at its zero", "current sensor stuck at -0.5 A"):
        assert left.motor_share == -1
        assert left.amperes == pytest.approx(12 / 2.5, rel=0.01)


@pytest.mark.unguarded
@pytest.mark.parametrize("danger", SUPPLY_DANGERS, ids=str)
def test_another_supply_keeps_the_power_on_without_its_guards(
    bare_watching_pico: EmulatedPico, danger: Danger
) -> None:
    _check_what_is_left(bare_watching_pico, danger)


def _check_what_is_left(board: EmulatedPico, danger: Danger) -> Left:
    left = endure(board, danger)
    assert left is not None, "it is off: the guard is not what this takes"
    # The currents' ripple and noise, and where in a period one looks.
    told_a = float(_documented(danger.name)[2].removesuffix(" A"))
    assert left.amperes == pytest.approx(told_a, rel=0.05, abs=0.1)
    return left


@pytest.mark.parametrize("supply_v", [0, 8.9, 15.1, 24, 400])
def test_another_supply_keeps_a_board_that_measures_it_from_arming_while_it_lasts(
    watching_pico: EmulatedPico, supply_v: float
) -> None:
    pico = watching_pico
    pico.do("motor", supply=supply_v)
    pico.run(2.5)
    health = pico.get("health")
    assert (health["state"], health["faults"]) == ("fault", SUPPLY)
    assert pico.command("arm") == "fault_latched"
    assert pico.command("clear_fault") == "fault_persists"
    # It need not be cleared: nobody was at it.
    pico.do("motor", supply=12)
    pico.run(SUPPLY_RETURNS_MS)
    health = pico.get("health")
    assert (health["state"], health["faults"]) == ("disarmed", 0)
    assert pico.command("arm") == "ok"
    assert pico.command("disarm") == "ok"


@pytest.mark.unguarded
def test_another_supply_may_arm_without_the_guard(bare_watching_pico: EmulatedPico) -> None:
    pico = bare_watching_pico
    take_away(pico, "supply")
    pico.do("motor", supply=24)
    pico.run(2.5)
    assert pico.command("arm") == "ok"
    assert pico.command("disarm") == "ok"
    pico.do("motor", supply=12)
    pico.run(SUPPLY_RETURNS_MS)
    take_away(pico)


def test_board_that_measures_its_supply_goes_on_with_one_that_sags(
    watching_pico: EmulatedPico,
) -> None:
    push(watching_pico)
    for supply_v in (9.2, 14.8, 12):
        watching_pico.do("motor", supply=supply_v)
        watching_pico.run(10)
        assert watching_pico.motor()
        # The current that is asked for, with the voltage that it takes then.
        assert abs(watching_pico.do("amperes")) == pytest.approx(1.7, abs=0.05)
    assert watching_pico.command("disarm") == "ok"
    watching_pico.turn(-watching_pico.get("clock")["position_counts"], period_us=2)


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


@pytest.mark.unguarded
def test_current_sensor_with_a_wrong_zero_may_arm_without_the_guard(
    bare_pico: EmulatedPico,
) -> None:
    bare_pico.do("motor", zero=300)
    start_without(bare_pico, "sensor's zero")
    assert bare_pico.get("health")["faults"] == 0
    assert bare_pico.command("arm") == "ok"
    bare_pico.do("motor")
    start_without(bare_pico)


def test_trip_level_beyond_the_sensors_range_keeps_the_board_from_arming() -> None:
    with enumerated() as pico:
        pico.set("board_config", current_sense_v_per_a=1.0)  # 3 A are then 3 V
        assert pico.command("save") == "ok"
        pico.power_cycle()
        pico.enumerate()
        assert pico.get("health")["faults"] == CURRENT_SENSOR
        assert pico.command("arm") == "fault_latched"


@pytest.mark.unguarded
def test_trip_level_beyond_the_sensors_range_may_arm_without_the_guard() -> None:
    # And over-current, which waits for 3 A, would then never be seen.
    with rewired(image(), current_sense_v_per_a=1.0) as pico:
        pico.power_cycle()
        take_away(pico, "sensor's zero")
        pico.enumerate()
        assert pico.get("health")["faults"] == 0
        assert pico.command("arm") == "ok"


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
        # Confirmed and known, it gives full torque at once.
        pico.set("board_config", confirmed="on")
        pico.set("calibration_config", values_are="stated")
        assert pico.command("arm") == "ok"
        pico.run(20)
        assert pico.do("amperes") == pytest.approx(-85e-3 / 0.05, abs=0.05)


@pytest.mark.unguarded
def test_unconfirmed_board_gives_all_it_has_without_the_guard(bare_pico: EmulatedPico) -> None:
    take_away(bare_pico, "timid")
    bare_pico.set("board_config", confirmed="off")
    push(bare_pico)
    assert bare_pico.do("amperes") == pytest.approx(-85e-3 / 0.05, abs=0.05)
    bare_pico.turn(200, period_us=40)  # 19 rad/s
    assert bare_pico.motor() is not None
    start_without(bare_pico)


def test_supply_of_twice_is_told_by_a_motor_that_holds_enough_and_not_before() -> None:
    # 30 mN m by hand: their share of 12 V, of 24 V through the coil's 40 ohm.
    usual_a = 30e-3 / 0.44
    found = felt.press_with_supply(bench.chosen.name, 24, confirmed=False)
    assert (found.off_s, found.faults) == (None, 0)
    assert found.coil_a == pytest.approx(2 * usual_a, rel=0.02)
    found = felt.press_with_supply(bench.chosen.name, 24, confirmed=True)
    assert found.off_s is not None
    assert found.faults == WINDING
    assert found.coil_a == 0


@pytest.mark.boards_in_turn
@each_run_away
def test_knob_does_not_run_away(danger: RunAway) -> None:
    with danger.bench(guarded=True) as found:
        run = danger.begin(found)
        assert named(run.faults) == danger.tells
        assert (run.off_s is None) == (not danger.tells)
        assert run.moved_rad < danger.most_rad
        assert run.fastest_rad_s < danger.most_rad_s
        if PAGES:
            _check_page_of(danger, run.off_s)
        if run.off_s is None:
            return
        # Off is off: friction takes the speed away from then on.
        speed = abs(found.place.record()["speed_rad_s"][-1])
        found.board.run(20)
        assert abs(found.place.record()["speed_rad_s"][-1]) < speed
        assert found.board.command("clear_fault") == "ok"


def _check_page_of(danger: RunAway, off_s: float | None) -> None:
    reaction, told, _ = _documented(danger.name)
    if off_s is None:
        assert reaction == "stays on"
        return
    assert told == f"`{danger.tells}`"
    # Looked at every 4 ms, and how fast a knob gets depends on the sensor's noise.
    assert 1e3 * off_s == pytest.approx(_documented_ms(danger.name), rel=0.1, abs=12)


@pytest.mark.unguarded
@pytest.mark.boards_in_turn
@each_run_away
def test_knob_runs_away_without_the_guards(danger: RunAway) -> None:
    with danger.bench(guarded=False) as found:
        run = danger.begin(found)
        assert (run.off_s, run.faults) == (None, 0)
        told_rad_s = float(_documented(danger.name)[2].removesuffix(" rad/s"))
        assert run.fastest_rad_s == pytest.approx(told_rad_s, rel=0.15, abs=1.0)


def test_warm_winding_and_coil_get_less_and_less_until_the_continuous_current() -> None:
    with rewired(**LITTLE["motor"] | LITTLE["coil"]) as pico:
        found = hold_warm(pico, 300)
        assert found.off_ms is None
        for part, amperes in found.amperes.items():
            expected, _ = foreseen(part, 300)
            # The push took some milliseconds before, and the model has steps of 6 at most.
            for n in range(4, len(amperes) - 4):
                most, least = expected[n - 4], expected[n + 4]
                assert 0.97 * least - 0.03 <= amperes[n] <= 1.03 * most + 0.03, (part, n)
            assert amperes[2] > 0.9 * PUSHED_A[part]
            if PAGES:
                reaction, told, _ = _documented(WARM[part])
                told_a, after_s = map(float, re.findall(r"[\d.]+", told))
                assert reaction == "stays on"
                assert told_a == pytest.approx(amperes[round(1e3 * after_s / 5) - 1], rel=0.1)
            assert amperes[-1] < 0.3 * PUSHED_A[part]
        assert pico.get("health")["state"] == "armed"
        # It is the winding that is warm, not the order: it stays so when armed anew.
        assert pico.command("disarm") == "ok"
        pico.turn(-pico.get("clock")["position_counts"], period_us=2)
        again = hold_warm(pico, 10)
        assert again.amperes["motor"][0] < 0.6
        assert again.amperes["coil"][0] < 0.06


@pytest.mark.unguarded
@pytest.mark.parametrize("part", ["motor", "coil"])
def test_winding_that_nothing_holds_down_is_a_fault_before_it_burns(part: str) -> None:
    with rewired(image(), **PLENTY | LITTLE[part]) as pico:
        take_away(pico, f"{part}'s heat")
        found = hold_warm(pico, 250)
        _, hot_ms = foreseen(part, 250)
        assert found.off_ms == pytest.approx(hot_ms, abs=15)
        danger = f"{WARM[part]}, not held down"
        assert _documented_ms(danger) == pytest.approx(found.off_ms, abs=10)
        assert _documented(danger)[1] == "`temperature`"
        assert pico.get("health")["faults"] == TEMPERATURE
        assert pico.command("clear_fault") == "fault_persists"
        # And without this guard too it gets all that it is told to.
        take_away(pico, f"{part}'s heat", "temperature")
        assert pico.command("clear_fault") == "ok"
        pico.turn(-pico.get("clock")["position_counts"], period_us=2)
        found = hold_warm(pico, 60)
        assert found.off_ms is None
        assert found.amperes[part][-1] == pytest.approx(PUSHED_A[part], rel=0.03)
        for told in (danger, WARM[part]):
            assert _documented(told)[2] == f"{PUSHED_A[part]:g} A"


@pytest.mark.unguarded
def test_stored_configuration_of_another_layout_is_not_believed() -> None:
    with unguarded() as pico:
        assert pico.set("board_config", supply_v=24, motor_pin=18)["status"] == 0
        start_with_other_layout(pico)
        found = pico.get("board_config")
        assert (found["supply_v"], found["motor_pin"], found["confirmed"]) == (12, 6, "off")
        assert pico.get("health")["saves"] == 0
        # Anybody may arm, and gets little.
        pico.set("control_config", passive_ramp_s=0.005)
        pico.arm_at_wall()
        pico.turn(100, period_us=300)
        pico.run(8)
        assert pico.do("amperes") == pytest.approx(-15e-3 / 0.05, abs=0.03)
        # Without the guard the device would read its bytes as values, also as a confirmation.
        start_without(pico, "layout")
        found = pico.get("board_config")
        assert (found["supply_v"], found["motor_pin"], found["confirmed"]) == (24, 18, "on")
        told = _documented("saved configuration of other firmware")
        assert told == ("never believed", "defaults, held low", "its bytes, `confirmed` too")


def test_supply_that_was_too_low_for_a_moment_is_told(lasting_pico: EmulatedPico) -> None:
    push(lasting_pico)
    # An RP2040 does not tell it from a supply that was switched on.
    tells = lasting_pico.model.chip == "rp2350"
    lasting_pico.do("power_cycle", **({"brown_out": True} if tells else {}))
    assert lasting_pico.motor() is None
    lasting_pico.enumerate()
    health = lasting_pico.get("health")
    assert health["reset_cause"] == ("brown_out" if tells else "power")
    if PAGES:
        told = _documented("board's own supply too low for a moment")[1].split(",")
        assert f"`{health['reset_cause']}`" in told[1 if tells else 2]
    assert health["state"] == "disarmed"
    assert lasting_pico.motor() is None


def test_start_of_a_file_that_was_copied_is_no_program_that_hung(
    lasting_pico: EmulatedPico,
) -> None:
    lasting_pico.do("start_copied")
    lasting_pico.enumerate()
    health = lasting_pico.get("health")
    assert (health["reset_cause"], health["state"]) == ("unknown", "disarmed")
    # The next hang is one again.
    lasting_pico.do("hang", masked=False)
    lasting_pico.run(20)
    lasting_pico.enumerate()
    assert lasting_pico.get("health")["reset_cause"] == "watchdog"


@pytest.mark.unguarded
def test_bridge_may_wake_up_for_a_millisecond_and_no_longer(bare_pico: EmulatedPico) -> None:
    assert arm_while_bridge_wakes(bare_pico, 0.8) == 0
    assert bare_pico.command("disarm") == "ok"
    bare_pico.run(20)
    assert arm_while_bridge_wakes(bare_pico, 1.3) == ACTUATOR
    assert bare_pico.motor() is None
    assert bare_pico.command("clear_fault") == "ok"
    # Without the pause each arming is a false trip.
    take_away(bare_pico, "bridge's waking")
    assert arm_while_bridge_wakes(bare_pico, 0.8) == ACTUATOR
    told = _documented("bridge says for 0.8 ms after it was enabled that it does not work")
    assert told == ("stays on", "not told: it wakes up", "`actuator`")
    take_away(bare_pico)
    assert bare_pico.command("clear_fault") == "ok"


@pytest.mark.unguarded
@pytest.mark.slow_chip
def test_load_that_does_not_fit_starves_the_main_loop_without_the_guard() -> None:
    with unguarded() as pico:
        take_away(pico, "overrun")
        pico.turn(60)
        pico.play_walls(16, stiffness_nm_per_rad=0.1, damping_nm_s_per_rad=1e-4)
        pico.post("command", op="arm")
        pico.run(5)
        # Only the watchdog can stop it.
        assert pico.motor() is not None
        with pytest.raises(AssertionError, match="no acknowledgement"):
            pico.acknowledgement(reads=1)
        pico.run(10)
        assert pico.motor() is None
        assert pico.status()["watchdog_resets"] == 1
