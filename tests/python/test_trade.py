"""The needs of a scene, against closed forms, independent counts, and theory."""

from __future__ import annotations

import json
import math
import re
from dataclasses import asdict, replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from typer.testing import CliRunner

import torsio
from firmware.protocol.definition import costs
from torsio import perception, stability
from torsio.apps.cli import app
from torsio.closed_loop import LoopOptions, simulate
from torsio.printed.board_costs import BOARDS
from torsio.printed.config import ControlConfig, Law
from torsio.trading import Trade, answers
from torsio.trading import extremes as stretching
from torsio.trading.answers import _in_batch, _row
from torsio.trading.found import board_shares, pasteable
from torsio.trading.runs import PARTS, Kept, Runs, Variant
from torsio.trading.sources import EVERYTHING, configured, options_of
from torsio.trading.visits import (
    CHOOSE,
    Difference,
    Visit,
    differ,
    edges_rad,
    felt_nm,
    verifying,
)
from torsio.trading.words import _of_part, lines

COGGING = torsio.Cogging.sine(periods_per_rev=12, amplitude_nm=2e-3)
MOTOR_ONLY = ControlConfig(law="motor_only")
WALL = torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=1.4)
SPRING = torsio.Spring(stiffness_nm_per_rad=0.5)
# A turn of 0.2 rad in 2 s, whatever that takes: speed and place are known in closed form.
SPEED = 0.1
DRIVEN = torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (2.0, 2.0 * SPEED)])


@pytest.fixture(scope="module")
def walled() -> Trade:
    return torsio.trade(WALL, plant=torsio.PlantParams(), quick=True, stretch=False)


def one(
    variant: Variant, plant: torsio.PlantParams, hand: torsio.Hand = DRIVEN, scene: object = SPRING
) -> Difference:
    options = options_of(scene, {"plant": plant, "hand": hand, "control": MOTOR_ONLY})
    ((found, _),) = Runs(options, Kept(None), 1).measure([variant], [Visit()])
    return found


def test_long_hands_are_kept_apart() -> None:
    kept = Kept(None)
    for middle in (0.01, 0.02):
        hand = torsio.TorqueHand(torque_nm=[(0.0, 0.0), *[(0.1, middle)] * 99, (1.0, 0.0)])
        options = LoopOptions(hand=hand, scene=[SPRING])
        assert kept.get((options,), lambda nm=middle: {"nm": nm}) == {"nm": middle}  # type: ignore[misc]


@pytest.mark.parametrize("together", [True, False])
def test_felt_torque_balances_a_weight_that_rests(together: bool) -> None:
    plant = torsio.PlantParams(cogging=COGGING, spring_and_brake=together)
    hand = torsio.TorqueHand(torque_nm=[(0.0, 0.0), (0.5, 0.03)])
    rows = simulate(LoopOptions(scene=WALL, plant=plant, hand=hand), duration_s=3.0)
    assert felt_nm(rows, plant, hand)[-1] == pytest.approx(-0.03, abs=1e-9)


def test_felt_torque_of_one_body_is_what_newton_says() -> None:
    plant = torsio.PlantParams(spring_and_brake=False, knob_viscous_nm_s_per_rad=0.0)
    hand = torsio.TorqueHand(torque_nm=0.03)
    rows = simulate(LoopOptions(plant=plant, hand=hand, control=MOTOR_ONLY), duration_s=0.01)
    friction = plant.knob_coulomb_nm + plant.brake_drag_nm
    speedup = (0.03 - friction) / (plant.knob_inertia_kg_m2 + plant.brake_inertia_kg_m2)
    expected = plant.knob_inertia_kg_m2 * speedup - 0.03
    assert felt_nm(rows, plant, hand)[1:] == pytest.approx(expected, rel=1e-3)


def test_parts_that_cannot_matter_change_nothing_to_the_bit() -> None:
    # Nothing engages the brake, and the shaft twists by less than its knee.
    plant = torsio.PlantParams(
        brake_hysteresis=torsio.BrakeHysteresis(), shaft_hardening=torsio.ShaftHardening()
    )
    for part in ("hysteresis", "hardening", "brake"):
        found = one(Variant(left_out=(part,)), plant)
        assert found == Difference(), part


def test_cogging_left_out_is_missed_by_its_own_amplitude() -> None:
    found = one(Variant(left_out=("cogging",)), torsio.PlantParams(cogging=COGGING))
    # 0.2 rad are less than a period; the mean over 10 ms takes 0.1 % of it.
    turned = 12 * SPEED * np.linspace(0.0, 2.2, 2200).clip(max=2.0)
    assert found.largest_nm == pytest.approx(2e-3, rel=5e-3)
    assert found.rms_nm == pytest.approx(2e-3 * np.sqrt(np.mean(np.sin(turned) ** 2)), rel=0.02)
    assert found.jnds == pytest.approx(found.largest_nm / (0.127 * 60e-3))
    assert found.angle_rad == found.contact_s == 0.0


def test_rate_is_missed_by_the_path_of_a_longer_hold() -> None:
    plant = torsio.PlantParams(counts_per_rev=2**24, motor_time_constant_s=0.0)
    found = one(Variant(rate_hz=1000), plant)
    # The torque at a sample comes from the sample before.
    expected = 0.5 * SPEED * (1e-3 - 50e-6)
    assert found.largest_nm == pytest.approx(expected, rel=1e-2)


def test_counts_are_missed_by_the_coarser_step() -> None:
    found = one(Variant(counts_per_rev=256), torsio.PlantParams(counts_per_rev=2**24))
    assert found.spike_nm == pytest.approx(0.5 * 2 * math.pi / 256, rel=0.01)


def test_contact_comes_later_by_what_the_path_says() -> None:
    # Spring and friction stretch the hand, and a belief of the law changes neither; a knob without
    # its 6 mN m of friction, in the hand of 1 N m/rad, is 6 mrad further.
    hand = torsio.ImpedanceHand(
        stiffness_nm_per_rad=1.0,
        damping_nm_s_per_rad=0.05,
        intended_angle_rad=[(0.0, 0.0), (2.0, 0.2)],
    )
    edge = torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1e-3)
    runs = [
        simulate(
            LoopOptions(scene=edge, plant=plant, hand=hand, control=MOTOR_ONLY), duration_s=2.0
        )
        for plant in (torsio.PlantParams(), torsio.PlantParams(knob_coulomb_nm=0.0))
    ]
    nothing = np.zeros(len(runs[0]))
    found = differ(runs[0], runs[1], (nothing, nothing), edge)
    assert found.contact_s == pytest.approx(6e-3 / 0.1, rel=0.02)
    assert found.missed == 0


def test_trade_proposes_verifies_and_pastes() -> None:
    plant = torsio.PlantParams(brake_hysteresis=torsio.BrakeHysteresis(), cogging=COGGING)
    found = torsio.trade(WALL, plant=plant, stretch=False, threads=2)
    assert found.holds
    assert found.proposal.difference.jnds <= 0.5
    assert max(found.verified.jnds, found.on_device.difference.jnds) <= 0.5
    assert {row.variant.rate_hz for row in found.rows} == {20_000, 10_000, 5_000, 2_000, 1_000}
    # Each combination at each rate, and once spring and brake with and without cogging.
    combined = [r for r in found.rows if r.variant.may_be_proposed and r.name == r.variant.name]
    assert len(combined) == 5 * (4 + 2) + 1
    # Nothing on the front is beaten both ways.
    for row in (row for row in combined if row.is_on_front):
        assert not any(
            r.cpu_s < row.cpu_s and r.difference.largest_nm < row.difference.largest_nm
            for r in combined
        )
    assert eval(found.paste(), {"torsio": torsio}) == found.options
    with torsio.open("emulated", emulator=found.options) as knob:
        assert knob.info.control_rate_hz == found.proposal.variant.rate_hz
    batch = next(row for row in found.rows if row.name.startswith("torsio.batch"))
    assert batch.difference.jnds <= found.proposal.difference.jnds


def test_batch_at_the_rate_of_the_reference_differs_by_nothing() -> None:
    scene = torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=60.0)
    runs = Runs(options_of(scene, {}), Kept(None), 1)
    reference = _row("", Variant(), runs, Difference(), 1.0)
    assert _in_batch(reference, runs).difference == Difference()


def test_trade_says_by_how_much_it_falls_short() -> None:
    # Only the reference is as exact, and the device's noise begins earlier.
    plant = torsio.PlantParams(encoder_noise_counts=0.25)
    found = torsio.trade(WALL, plant=plant, wanted_jnds=1e-9, quick=True, stretch=False)
    assert found.proposal.variant == Variant()
    assert not found.holds
    assert found.short_by_jnds == pytest.approx(found.on_device.difference.jnds - 1e-9)
    assert 0.0 < found.short_by_jnds < 0.5
    assert any("Even with all parts two visits differ by 0." in one for one in lines(found))


def test_proposal_that_fails_gives_way_to_one_that_verifies() -> None:
    scene = [
        torsio.Spring(stiffness_nm_per_rad=0.15),
        torsio.Damper(damping_nm_s_per_rad=1e-3),
        torsio.Periodic(amplitude_nm=5e-3, frequency_hz=40.0),
    ]
    found = torsio.trade(scene, quick=True, stretch=False)
    assert found.holds
    smallest = Variant(("spring and brake", "cogging", "electrics", "noise"), rate_hz=1000)
    assert next(row for row in found.rows if row.variant == smallest).difference.jnds <= 0.5
    assert found.proposal.variant != smallest


def test_search_ends_where_a_proposal_holds_on_the_device_too() -> None:
    # The device's noise is another: there most of the cheap rows are worse than 1 JND.
    found = torsio.trade(
        replace(WALL, stiffness_nm_per_rad=20.0), wanted_jnds=1.0, quick=True, stretch=False
    )
    assert found.holds
    assert found.proposal.variant != Variant()


@pytest.mark.parametrize(
    ("left_out", "rate_hz", "shares"),
    [
        (("belt",), 5000, True),
        (("belt", "noise"), 2000, True),
        (("spring and brake",), 5000, True),  # and the belt with it
        (("noise",), 2000, False),
        (("belt", "noise"), 10_000, False),
    ],
)
def test_what_leaves_out_as_much_shares_a_failure(
    left_out: tuple[str, ...], rate_hz: int, shares: bool
) -> None:
    failed = Variant(("belt",), rate_hz=5000)
    assert Variant(left_out, rate_hz=rate_hz).leaves_out_all_of(failed) is shares


def test_verifying_visits_are_new_each_time() -> None:
    visits = [*CHOOSE, *(visit for number in range(40) for visit in verifying(number))]
    assert len({*visits}) == len(visits)


def test_of_rows_as_cheap_the_one_with_fewest_parts_is_chosen(
    monkeypatch: pytest.MonkeyPatch, walled: Trade
) -> None:
    monkeypatch.setattr(answers, "_batch_cpu_s", lambda *_: 1e-3)
    rows = [
        replace(walled.rows[0], variant=Variant(left_out), cpu_s=1e-3, difference=Difference(nm))
        for left_out, nm in (
            (("hysteresis", "hardening", "cogging"), 0.0),
            (("spring and brake",), 2e-3),
            (("spring and brake", "hardening"), 1e-3),
        )
    ]
    assert answers._choose(rows, LoopOptions(plant=EVERYTHING)) is rows[2]


@pytest.mark.parametrize(
    ("jnds", "share", "verdict"),
    [
        (0.6, 0.3, "costs 30 %: keep it"),
        (0.4, 0.3, "costs 30 %: keep it beside what is left out"),
        (0.4, 0.0, "costs nothing: keep it"),
    ],
)
@pytest.mark.parametrize("part", ["brake", "spring and brake", "belt"])
def test_verdict_on_a_part_follows_from_error_and_cost(
    part: str, jnds: float, share: float, verdict: str, walled: Trade
) -> None:
    first = walled.rows[0]
    difference = Difference(largest_nm=jnds * perception.torque_jnds(1.0) ** -1)
    row = replace(first, difference=difference, cpu_s=(1.0 - share) * first.cpu_s)
    less = replace(first, variant=Variant(left_out=("noise",)))
    line = _of_part(part, row, first, replace(walled, proposal=less))
    assert line.endswith(f"{verdict}.")
    whole = _of_part(part, row, first, replace(walled, proposal=first))
    assert whole.endswith(f"{verdict.removesuffix(' beside what is left out')}.")


def test_proposal_swings_only_if_the_scene_does() -> None:
    plant, wall = torsio.PlantParams(), replace(WALL, stiffness_nm_per_rad=30.0)
    found = torsio.trade(wall, plant=plant, wanted_jnds=2.0, quick=True, stretch=False)
    assert not found.swings
    options = options_of(wall, {"plant": plant})
    coarse = found.row(rate_hz=1000)
    assert coarse.difference.jnds <= 2.0
    assert stretching.swings(coarse.variant.of(options), 0)
    assert not stretching.swings(found.proposal.variant.of(options), 0)


def test_hand_that_never_touches_the_scene_is_refused() -> None:
    with pytest.raises(torsio.Error, match="the hand never touches the scene"):
        torsio.trade(WALL, hand=torsio.NoHand(), quick=True)


def test_parts_are_those_of_the_plant_and_else_the_usual_ones() -> None:
    plant = torsio.PlantParams(
        cogging=COGGING, shaft_hardening=torsio.ShaftHardening(), knob_inertia_kg_m2=3e-4
    )
    traded = options_of([], {"plant": plant}, ["cogging", "belt"]).plant
    assert traded == replace(plant, shaft_hardening=None, belt=EVERYTHING.belt)


def test_parts_that_went_with_the_spring_are_not_kept(walled: Trade) -> None:
    each = [Variant(left_out=(part,)) for part in PARTS]
    alone = [replace(walled.rows[0], name=one.name, variant=one) for one in each]
    proposal = walled.row(left_out=("spring and brake",))
    told = [*lines(replace(walled, rows=(*walled.rows, *alone), proposal=proposal))]
    for part in ("hysteresis", "hardening", "belt", "brake"):
        (line,) = (one for one in told if one.startswith(f"{part.capitalize()} changes"))
        assert line.endswith("leave it out."), line


@pytest.mark.parametrize(
    ("contact_s", "told"),
    [
        (12.34567e-3, "12"),
        (0.0994e-3, "0.099"),
        (1.26e-3, "1.3"),
        (0.49e-6, "0"),
        (0.51e-6, "0.001"),
    ],
)
def test_contacts_are_told_in_two_digits_and_whole_microseconds(
    contact_s: float, told: str, walled: Trade
) -> None:
    proposal = replace(walled.proposal, difference=Difference(contact_s=contact_s))
    (line,) = (one for one in lines(replace(walled, proposal=proposal)) if "Proposed:" in one)
    assert f"contacts by {told} ms and" in line


def test_interrupted_trade_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = tmp_path / "kept"
    # The cheapest is chosen by time, which is never twice the same.
    monkeypatch.setattr(answers, "_batch_cpu_s", lambda *_: 1.0)

    def interrupt(_what: str, done: int, _total: int) -> None:
        if done == 7:
            raise KeyboardInterrupt

    def run(**more: object) -> Trade:
        plant = torsio.PlantParams()
        return torsio.trade(WALL, plant=plant, quick=True, stretch=False, resume=kept, **more)  # type: ignore[arg-type]

    with pytest.raises(KeyboardInterrupt):
        run(on_progress=interrupt)
    lines = kept.read_text().splitlines()
    assert len([*filter(None, lines)]) >= 7
    kept.write_text("\n".join([*lines, '{"key": "torn", "ro']))
    found = run()
    assert kept.read_text().splitlines()[: len(lines)] == lines
    tried: list[Variant] = []
    played = Runs._play

    def count(self: Runs, variant: Variant, visit: Visit, *more: object) -> object:
        tried.append(variant)
        return played(self, variant, visit, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(Runs, "_play", count)
    again = run()
    assert set(tried) == {Variant()}
    assert [row.difference for row in again.rows[:10]] == [r.difference for r in found.rows[:10]]
    kept.write_text(re.sub('"row": .*', '"row": 7}', kept.read_text()))  # bits have flipped
    assert [row.difference for row in run().rows[:10]] == [r.difference for r in found.rows[:10]]
    kept.write_text("a diary\n")
    with pytest.raises(torsio.Error, match="keeps no results of a trade"):
        run()
    assert kept.read_text() == "a diary\n"


def test_instructions_of_many_walls_are_as_they_were_counted() -> None:
    for board in board_shares([WALL] * 16, ControlConfig()):
        assert board.instructions == pytest.approx(
            costs.INSTRUCTIONS[board.board]["walls 16"], rel=0.12
        )
    for law in get_args(Law):
        for board in board_shares(WALL, ControlConfig(law=law), 1e6):
            scene = "walls 1" if law == "paper" else f"walls, {law} 1"
            counted = costs.INSTRUCTIONS[board.board][scene]
            assert board.instructions == pytest.approx(counted, rel=0.03)
            assert board.share == board.time_ns / 1e6


def test_law_and_effect_that_nobody_has_counted_cost_as_much_as_the_most_costly(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    impact = torsio.Impact(strength_nm_s_per_rad=0.01)
    most = board_shares(impact, ControlConfig(law="calibrated"))[0]
    in_air = board_shares(None, ControlConfig(law="calibrated"))[0]
    monkeypatch.delitem(BOARDS["pico2"].effects, "Wall")
    monkeypatch.delitem(BOARDS["pico2"].laws, "motor_only")
    assert board_shares(WALL, MOTOR_ONLY)[0] == most
    assert board_shares(None, MOTOR_ONLY)[0] == in_air


def test_rows_cost_what_their_law_and_rate_cost(walled: Trade) -> None:
    reference, slow = walled.rows[0].boards, walled.row(rate_hz=1000).boards
    assert [20.0 * one.share for one in slow] == pytest.approx([one.share for one in reference])
    counted = costs.INSTRUCTIONS["pico"]
    more = walled.row(law="calibrated").boards[1].instructions - reference[1].instructions
    assert more == counted["walls, calibrated 1"] - counted["walls 1"]
    told = f"a tick is {walled.row(law='parallel').boards[0].instructions:,} on `pico2`"
    assert any("Law parallel changes" in one and told in one for one in lines(walled))


def test_swings_begin_where_theory_says() -> None:
    plant = torsio.PlantParams(counts_per_rev=131_072)
    fast = torsio.EmulatorOptions(plant=plant, control_rate_hz=20_000.0)
    with torsio.open("emulated", emulator=fast) as knob:
        knob.configure(plant.matching_config())
        knob.configure(MOTOR_ONLY)
        stable = knob.stable_stiffness().stiffness_nm_per_rad
    scene = torsio.Spring(stiffness_nm_per_rad=0.5 * stable)
    options = options_of(scene, {"plant": plant, "control": MOTOR_ONLY})
    first = stretching._at("stiffness", 1, options, Variant(rate_hz=1000), 0)
    found = stretching._stretch("stiffness", options, Variant(rate_hz=1000), 0.5, 0, first)
    # Cases that the device calls stable are; where it swings, `torsio stability` says so too.
    assert found.swings_at is not None
    assert found.swings_at > 2
    tried = stability.measure(
        plant, plant.matching_config(), MOTOR_ONLY, 20_000.0,
        stiffness_nm_per_rad=[0.5 * stable * found.swings_at],
    )  # fmt: skip
    assert not tried.is_stable.any()


def test_proposal_is_not_true_where_only_it_swings_and_limits_of_options_break_nothing() -> None:
    options = options_of(replace(WALL, stiffness_nm_per_rad=15.0), {"plant": torsio.PlantParams()})
    of = {one.quantity: one for one in stretching.extremes(options, Variant(), 5.0, quick=True)}
    rate, angle = of["control rate"], of["angle"]
    assert (rate.true_to, rate.swings_at, rate.breaks) == (2000, None, "only the proposal swings")
    assert (angle.true_to, angle.breaks, angle.is_bounded) == (1e8, "", False)


def test_search_finds_a_start_that_swings_where_plain_throws_come_to_rest() -> None:
    scene = torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=9.0)
    plant = torsio.PlantParams(brake_hysteresis=torsio.BrakeHysteresis())
    options = Variant(rate_hz=1000).of(options_of(scene, {"plant": plant}))
    assert not stretching.swings(options, 0)
    assert stretching.swings(options, stretching.GENERATIONS)
    soft = replace(options, scene=replace(scene, stiffness_nm_per_rad=1.0))
    assert not stretching.swings(soft, stretching.GENERATIONS)


def test_scene_breaks_nothing_unstretched_and_has_no_stiffness_where_there_is_none() -> None:
    # The motor saturates as it is, at every rate.
    options = options_of(torsio.Constant(torque_nm=5.0), {"plant": torsio.PlantParams()})
    found = stretching.extremes(options, Variant(rate_hz=1000), 10.0, quick=True)
    of = {one.quantity: one for one in found}
    assert of.keys() == stretching._LADDERS.keys() - {"stiffness"}
    assert "motor" not in " ".join(one.breaks for one in found)


def test_wave_after_a_day_is_off_by_the_rounding_of_its_frequency() -> None:
    ticks = 86_400_000
    scene = torsio.Periodic(amplitude_nm=0.02, frequency_hz=8.0001)
    given = {"plant": torsio.PlantParams(), "hand": torsio.PrescribedMotion(angle_rad=0.0)}
    options = options_of(scene, {**given, "control": MOTOR_ONLY})
    rows = simulate(Variant(rate_hz=1000).of(replace(options, first_tick=ticks)), duration_s=1.0)
    # In a day it is 691,208.64 times round.
    ideal = 0.02 * np.sin(2.0 * np.pi * (0.64 + 8.0001e-3 * np.arange(len(rows))))
    off_nm = float(np.abs(rows["desired_torque_nm"] - ideal).max())
    jnds, broken = stretching._at("duration", 24.0, options, Variant(rate_hz=1000), 0)
    assert 1e-4 < off_nm < 1e-3
    assert jnds == pytest.approx(perception.torque_jnds(off_nm), rel=0.05)
    assert not broken


def test_wave_that_is_a_whole_turn_off_at_last_is_not_true_until_then() -> None:
    ticks = 360_000_000_000  # 100,000 hours
    per_tick = 42_949_672  # what the device makes of 10 Hz, in single precision
    frequency_hz = 1e3 * (per_tick / 2**32 + 1 / ticks)
    scene = torsio.Periodic(amplitude_nm=0.02, frequency_hz=frequency_hz)
    given = {"plant": torsio.PlantParams(), "hand": torsio.PrescribedMotion(angle_rad=0.0)}
    options = options_of(scene, {**given, "control": MOTOR_ONLY})
    slow = Variant(rate_hz=1000)
    assert stretching._at("duration", 1e5, options, slow, 0)[0] < 1e-3
    found = stretching._stretch("duration", options, slow, 0.5, 0, (0.0, frozenset()))
    # The difference of two sines: 2 A sin(pi t / 100,000 h).
    true_h = 1e5 / math.pi * math.asin(0.5 / perception.torque_jnds(2 * 0.02))
    assert found.is_bounded
    assert found.true_to is not None
    assert true_h / 1.2 < found.true_to < 1.02 * true_h
    steps = np.array(found.tried)
    assert np.all(steps[1:] < 1.21 * steps[:-1])


def test_whole_device_plays_a_wave_as_the_loop_does() -> None:
    scene = torsio.Periodic(amplitude_nm=0.02, frequency_hz=40.0)
    options = options_of(scene, {"plant": torsio.PlantParams()})
    found, _, wire_bytes_per_s = Runs(options, Kept(None), 1).on_device(Variant(), Visit())
    assert found.jnds < 1e-3
    # Four samples a report of 64 bytes, of 1,000 or more a second.
    assert wire_bytes_per_s >= 64 * 1000 / 4


def test_recording_brings_its_scene_and_motion(tmp_path: Path) -> None:
    file = tmp_path / "visit.mcap"
    hand = torsio.TorqueHand(torque_nm=[(0.0, 0.0), (0.6, 0.05)])
    with (
        torsio.open("emulated", emulator=torsio.EmulatorOptions(hand=hand)) as knob,
        knob.record_to(file),
    ):
        knob.play([WALL, torsio.Constant(torque_nm=-1e-3)])
        knob.arm()
        log = knob.record(1.0)
        knob.play([])
        knob.sleep(0.1)
    options = options_of(file, {})
    assert options.scene == [WALL, torsio.Constant(torque_nm=-1e-3)]
    assert isinstance(options.hand, torsio.PrescribedMotion)
    path = np.asarray(options.hand.angle_rad)
    assert path[-1, 1] == pytest.approx(float(log["angle_rad"][-1]), abs=1e-3)
    assert options.plant.spring_and_brake
    assert options.plant.electrics is not None


def test_recording_that_began_while_a_scene_played_brings_it(tmp_path: Path) -> None:
    file = tmp_path / "visit.mcap"
    with torsio.open("emulated") as knob:
        knob.play(WALL)
        knob.arm()
        with knob.record_to(file):
            knob.sleep(0.5)
        assert options_of(file, {}).scene == options_of(torsio.load(file), {}).scene == [WALL]
        assert [event["kind"] for event in torsio.load(file).events] == ["playing"]
        knob.stop()
        with knob.record_to(file):
            knob.sleep(0.1)
    assert torsio.load(file).events == []


def test_recording_that_cannot_be_traded_says_what_it_lacks(tmp_path: Path) -> None:
    file = tmp_path / "visit.mcap"
    record = ["record", str(file), "--device", "emulated", "--seconds", "0.5"]
    assert CliRunner().invoke(app, record).exit_code == 0
    with pytest.raises(torsio.Error, match="record in the program or page that plays it"):
        options_of(file, {})
    with torsio.open("emulated") as knob:
        recording = knob.record_to(file)
        knob.play(WALL)
        knob.sleep(0.5)
        with pytest.warns(torsio.DisarmedWarning):
            recording.close()
    recorded = torsio.load(file)
    with pytest.raises(torsio.Error, match="not armed in the recording"):
        options_of(recorded, {})
    recorded.telemetry["flags"] = 1
    # A page names effects as the protocol does.
    range_ = {"lower_rad": -1.0, "upper_rad": 1.0, "stiffness_nm_per_rad": 1.0}
    stops = {"type": "end_stops", **range_}
    recorded.events[0]["scene"] = [asdict(WALL) | {"type": "wall"}, stops]
    assert options_of(recorded, {}).scene == [WALL, torsio.EndStops(**range_)]
    stops["type"] = "wail"
    with pytest.raises(torsio.Error, match="record anew: 'wail'"):
        options_of(recorded, {})


def test_command_prints_words_json_and_a_picture(tmp_path: Path) -> None:
    file = tmp_path / "scene.py"
    file.write_text(f"import torsio\nscene = {pasteable(WALL)}\n")
    picture = tmp_path / "trade.png"
    quick = ["trade", str(file), "--quick", "--parts", "cogging,noise", "--picture", str(picture)]
    result = CliRunner().invoke(app, quick)
    assert result.exit_code == 0, result.output
    assert re.search(r"Cogging changes what is felt by [\d.]+ JND and costs", result.stdout)
    assert "torsio.EmulatorOptions(" in result.stdout
    assert "Stiffness stays true to" in result.stdout
    assert picture.stat().st_size > 20_000
    short = CliRunner().invoke(app, [*quick[:5], "--wanted", "1e-9", "--json", "--no-extremes"])
    assert short.exit_code == 1
    told = json.loads(short.stdout)
    assert not told["holds"]
    assert told["rows"][0]["ns_per_tick"] > 0.0
    assert told["on_device"]["wire_bytes_per_s"] > 64.0
    assert told["extremes"] == []
    assert told["swings"] is False
    # Said before a run, and after one that could keep nothing.
    for place, why in (
        ("no/x.png", "its folder does not exist"),
        ("x.jpe", "ends in neither .png"),
    ):
        lost = CliRunner().invoke(app, [*quick[:5], "--picture", f"{tmp_path}/{place}"])
        assert why in " ".join(lost.stderr.split())
    kept = CliRunner().invoke(app, [*quick[:5], "--no-extremes", "--resume", f"{tmp_path}/no/x"])
    assert "nothing more is kept there" in " ".join(kept.stderr.split())
    assert "warn(" not in kept.stderr


@pytest.mark.parametrize(
    ("text", "more", "reason"),
    [
        ("scene = None", [], "sets no `scene`"),
        ("import sys; sys.exit(0)", [], "SystemExit"),
        ("from neighbour import scene", [], "scene must be effects"),
        ("scene = 1 / 0", [], "ZeroDivisionError"),
        ("scene = 7", [], "scene must be effects"),
        ("import torsio; scene = torsio.Wall(stiffness_nm_per_rad=-1.0)", [], "stiffness"),
        ("scene = []", ["--parts", "wings"], "there is no part wings"),
        ("scene = []", [], "scene has no effect"),
        ("scene = []", ["--wanted", "0"], "wanted_jnds must be finite and > 0"),
    ],
)
def test_command_says_what_is_wrong(
    text: str, more: list[str], reason: str, tmp_path: Path
) -> None:
    file = tmp_path / "scene.py"
    file.write_text(text)
    (tmp_path / "neighbour.py").write_text("scene = 7")
    result = CliRunner().invoke(app, ["trade", str(file), "--quick", *more])
    assert result.exit_code == 1
    assert reason in " ".join(result.stderr.split())
    assert result.stderr.startswith("torsio: error: ")


def test_reference_has_every_part() -> None:
    options = options_of([], {})
    assert options.plant == EVERYTHING
    assert perception.torque_jnds(7.62e-3) == pytest.approx(1.0)


def test_inertia_that_was_calibrated_is_the_plant_s() -> None:
    actuator = torsio.ActuatorConfig(brake_inertia_kg_m2=3e-6)
    plant = configured(actuator, torsio.ShaftConfig())
    assert plant.brake_inertia_kg_m2 == pytest.approx(3e-6)


def test_effect_without_a_place_has_no_edges() -> None:
    assert edges_rad([torsio.Constant(torque_nm=0.01), WALL]).tolist() == [WALL.angle_rad]


def test_detents_have_edges_for_two_turns_each_way() -> None:
    crests = edges_rad(torsio.Detents(per_turn=4, torque_nm=0.01))
    assert crests.tolist() == pytest.approx([math.pi / 2 * (k + 0.5) for k in range(-8, 8)])
