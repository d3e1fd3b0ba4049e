"""Balls that hold the plant's motion: against closed forms in decimals, and the emulator."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal, getcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flint import arb, arb_mat

import torsio
from torsio.closed_loop import LoopOptions, simulate
from torsio.printed.beginnings import InitialState
from torsio.printed.hands import TorqueHand
from torsio.printed.plant import Cogging, PlantParams
from torsio_studies.enclosure import evaluation
from torsio_studies.enclosure.balls import DIGITS, Enclosure, UndecidedError, enclose
from torsio_studies.enclosure.cases import Case, electric_case, emulate, random_case
from torsio_studies.enclosure.evaluation import evaluate
from torsio_studies.enclosure.flows import Mode, matrix_of
from torsio_studies.enclosure.search import SPACE, extreme_case, search
from torsio_studies.enclosure.study import evaluate_once, scenes
from torsio_studies.execution import execute
from torsio_studies.fidelity.truth import hand_torque

PUSH_NM, PUSHED_S = 0.05, 0.25
# A knob alone; every number is exact in binary.
ALONE = torsio.PlantParams(
    knob_inertia_kg_m2=2.0**-14, knob_viscous_nm_s_per_rad=2.0**-12, knob_coulomb_nm=2.0**-7,
    shaft_stiffness_nm_per_rad=0.0, shaft_damping_nm_s_per_rad=0.0,
)  # fmt: skip


def coasted() -> tuple[Decimal, Decimal]:
    """Give where a push ends, and where the knob then comes to rest, in decimals."""
    getcontext().prec = DIGITS + 30
    inertia, losses, friction = Decimal(2) ** -14, Decimal(2) ** -12, Decimal(2) ** -7
    push, pushed = Decimal(PUSH_NM), Decimal(PUSHED_S)
    decay = inertia / losses
    final = (push - friction) / losses
    speed = final * (1 - (-pushed / decay).exp())
    angle = final * pushed - decay * speed
    # J w' = -f - b w, until w is 0.
    stops = decay * (1 + speed * losses / friction).ln()
    return angle, angle + decay * speed - friction / losses * stops


def holds(ball: Any, value: Decimal) -> bool:
    """Say whether all of a ball is within the digits of a decimal that has more of them."""
    return bool(abs(ball - arb(str(value))) < 10.0**-DIGITS)


def test_balls_hold_the_closed_form_of_a_knob_that_is_pushed_and_stops_by_itself() -> None:
    hand = TorqueHand(torque_nm=[(0.0, PUSH_NM), (PUSHED_S, PUSH_NM), (PUSHED_S, 0.0)])
    ticks = 1024
    nothing = np.zeros(ticks)
    balls, run, _ = enclose(
        ALONE, hand_torque(hand), nothing, nothing, period_s=2.0**-10, digits=90
    )
    pushed, rests = coasted()
    assert run.events == ["knob stops"]
    assert holds(balls[255][0], pushed)
    assert holds(balls[-1][0], rests)
    # Nothing else: a unit in the 40th place is outside.
    assert not holds(balls[-1][0], rests + Decimal(10) ** -40)


@pytest.mark.parametrize("number", [2, 5, 8])
def test_emulator_is_within_rounding_of_the_truth_with_every_part(number: int) -> None:
    (row,) = evaluate(random_case(number, 20))
    assert row["decided"]
    assert row["events"] > 0
    assert row["digits"] >= DIGITS
    assert row["error"] < 1e-12
    assert max(row["losses"].values()) < 1e-12


def test_box_that_turns_with_the_flow_keeps_its_digits_through_200_events() -> None:
    case = random_case(4, 45)
    commands = np.array(case.motor_nm), np.array(case.brake_nm)
    balls, run, _ = enclose(
        case.plant, hand_torque(case.hand), *commands, period_s=1e-3, digits=100
    )
    assert len(run.events) > 200
    # A box along the axes loses 180 of them.
    assert max(ball.rad() for some in balls for ball in some) < 1e-70


def test_balls_hold_the_closed_form_of_a_current_against_the_back_emf() -> None:
    """A knob without friction or shaft: i' and w' are linear, and a matrix of two by two."""
    getcontext().prec = DIGITS + 30
    parts = torsio.Electrics(supply_resistance_ohm=0.0)
    plant = replace(ALONE, knob_coulomb_nm=0.0, electrics=parts)
    share = np.full(64, 0.5)
    balls, run, _ = enclose(
        plant, hand_torque(TorqueHand(torque_nm=0.0)), share, 0.0 * share, period_s=2.0**-10,
        digits=90,
    )  # fmt: skip
    inertia, losses, ohm, henry, constant = (
        Decimal(one)
        for one in (2.0**-14, 2.0**-12, parts.winding_resistance_ohm, parts.winding_inductance_h,
                    parts.torque_constant_nm_per_a)
    )  # fmt: skip
    volts = Decimal("0.5") * Decimal(parts.supply_v)
    # i'' + p i' + q i = r by elimination, from i = 0 and i' = V / L.
    total = ohm / henry + losses / inertia
    product = (ohm * losses + constant**2) / (henry * inertia)
    root = (total**2 / 4 - product).sqrt()
    fast, slow = -total / 2 - root, -total / 2 + root
    final = volts * losses / (ohm * losses + constant**2)
    of_slow = (volts / henry + fast * final) / (slow - fast)
    time = Decimal(64) / 1024
    current = final + of_slow * (slow * time).exp() - (final + of_slow) * (fast * time).exp()
    assert holds(balls[-1][2], current)
    assert run.events == ["knob starts"]


@pytest.mark.parametrize("number", [0, 1])
def test_current_of_the_emulator_is_within_rounding_of_the_truth(number: int) -> None:
    (row,) = evaluate(electric_case(number, 20))
    assert row["decided"]
    assert row["digits"] >= DIGITS
    assert row["error"] < 1e-12
    assert row["current_error"] < 1e-12


@pytest.mark.parametrize(
    ("share", "events"), [(-(2.0**-16), []), (0.0, None), (2.0**-16, ["knob starts"])]
)
def test_torque_that_jumps_to_just_the_friction_is_declared_undecided(
    share: float, events: list[str] | None
) -> None:
    # A third of a radian a second, times a damping with a factor of 3: only in truth a whole ball.
    friction = 2.0**-9
    hand = torsio.ImpedanceHand(
        stiffness_nm_per_rad=1.0, damping_nm_s_per_rad=3.0 * friction, inertia_kg_m2=2.0**-14,
        intended_angle_rad=[(0.0, 0.0), (2.0**-10, 0.0), (2.0**-8, 2.0**-10)],
    )  # fmt: skip
    plant = replace(ALONE, knob_coulomb_nm=friction * (1.0 + share))
    nothing = np.zeros(3)
    given: Any = (plant, hand_torque(hand), nothing, nothing)
    if events is None:
        with pytest.raises(UndecidedError, match="too near 0 where a command or a hand jumps"):
            enclose(*given, period_s=2.0**-10, digits=100)
    else:
        run = enclose(*given, period_s=2.0**-10, digits=100)[1]
        assert run.events == events  # it lets go in the jump, or a moment later
        assert run.friction[0] == 1


def test_ball_about_zero_is_never_judged_by_its_middle() -> None:
    case = random_case(0)
    run = Enclosure(case.plant, hand_torque(case.hand), digits=50)
    run.friction[0] = -1
    run._leave_corner()
    assert run.cog == -1  # exactly on the corner
    run.cog, about = 0, arb(0, 1e-40)
    run.state[0, 0] = about
    with pytest.raises(UndecidedError, match="too near 0"):
        run._leave_corner()
    run.play = 1  # and the current may be above the next command, or below it
    run.state[8, 0] = 0.01 + about
    with pytest.raises(UndecidedError, match="too near 0"):
        run.advance(1e-3, 0.0, 0.01)
    # x'' = 1, from 0 with a speed that may be negative.
    mode = Mode(matrix_of([{1: arb(1)}, {2: arb(1)}, *[{}] * 13]), [("x", {0: arb(1)})])
    for speed, verdict in ((arb(0), "none"), (about, "?"), (arb(1e-40), "none")):
        state = arb_mat([[arb(0)], [speed], [arb(1)], *[[arb(0)]] * 12])
        inside = state + arb_mat([[arb(0)], [arb(0).union(1)], *[[arb(0)]] * 13])
        assert mode.stays[0].looks(state, inside, inside, "", is_last=False) == verdict


def test_digits_that_are_proven_stay_where_more_digits_decide_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def few(*given: Any, digits: int, **more: Any) -> Any:
        if digits > 100:
            raise UndecidedError
        return enclose(*given, digits=digits, **more)

    monkeypatch.setattr(evaluation, "enclose", few)
    monkeypatch.setattr(evaluation, "DIGITS", 100)  # wanted, so more are tried
    (row,) = evaluate(random_case(5, 3))
    assert row["decided"]
    assert DIGITS < row["digits"] < 100


def test_ball_tells_a_parameter_from_the_next_one() -> None:
    case = random_case(5, 20)
    inertia = float(np.nextafter(case.plant.knob_inertia_kg_m2, 1.0))
    plants = case.plant, replace(case.plant, knob_inertia_kg_m2=inertia)
    commands = np.array(case.motor_nm), np.array(case.brake_nm)
    torque = hand_torque(case.hand)
    ends = [enclose(p, torque, *commands, period_s=1e-3, digits=150)[0][-1][0] for p in plants]
    assert not ends[0].overlaps(ends[1])
    assert abs(ends[0] - ends[1]) < 1e-12
    assert max(ends[0].rad(), ends[1].rad()) < 10.0**-DIGITS


def test_scene_of_the_study_is_exact_to_rounding_and_scipy_to_its_tolerance() -> None:
    case = scenes(quick=True)[1]
    few = replace(case, motor_nm=case.motor_nm[:100], brake_nm=case.brake_nm[:100])
    (row,) = evaluate(few)
    assert row["digits"] >= DIGITS
    assert row["error"] < 1e-14
    assert row["error"] < row["scipy_error"] < 1e-8


def test_search_at_the_extremes_finds_no_error_beyond_rounding_and_repeats() -> None:
    worst = search(5, 10)
    assert worst["decided"]
    assert worst["digits"] >= DIGITS
    assert 1e-17 < worst["error"] < 1e-12
    assert worst == search(5, 10)
    (row,) = evaluate(extreme_case(5, worst["point"]), 4000)
    assert row["error"] * min(1.0, row["range_rad"]) == worst["error"]


@pytest.mark.parametrize(("push_nm", "most_rad"), [(2e-6, 1e-17), (-2e-6, 1e-12)])
def test_hill_of_cogging_magnifies_what_rounding_there_is(push_nm: float, most_rad: float) -> None:
    """Found by the search. Below zero an angle is rounded to a share of the turn that it ends."""
    hill_nm = 5e-4 * np.sin(2.0 * np.pi * np.arange(16) / 16)
    plant = PlantParams(
        knob_inertia_kg_m2=1e-5,
        knob_coulomb_nm=1e-6,
        brake_inertia_kg_m2=1.0,
        shaft_stiffness_nm_per_rad=1e-3,
        cogging=Cogging(periods_per_rev=800, torque_nm=hill_nm.tolist()),
    )
    hand = TorqueHand(torque_nm=[(0.0, push_nm), (1.0, push_nm)])
    at_rest = (0.0,) * 20
    (row,) = evaluate(Case("hill", plant, hand, at_rest, at_rest, period_ns=1_700_000))
    assert row["decided"]
    assert 1e-3 * most_rad < row["error"] * row["range_rad"] < most_rad


def test_motion_at_1e12_turns_repeats_the_bits_of_that_at_none() -> None:
    case = random_case(5)
    near, far = (
        simulate(
            LoopOptions(
                scene=torsio.Damper(damping_nm_s_per_rad=1e-3), plant=case.plant, hand=case.hand,
                initial=InitialState(revolutions=turns),
            ),
            duration_s=0.06,
        )
        for turns in (0, 10**12)
    )  # fmt: skip
    assert np.ptp(near["speed_rad_s"]) > 0.1
    for name in set(near.dtype.names or ()) - {"angle_rad", "brake_angle_rad"}:
        assert np.array_equal(near[name], far[name]), name


def test_a_case_is_evaluated_once_until_the_emulator_moves_otherwise(tmp_path: Path) -> None:
    kept, case = tmp_path / "kept.jsonl", random_case(5, 3)
    first = evaluate_once((kept, case))
    content = kept.read_bytes()
    assert evaluate_once((kept, case)) == first == evaluate(case)
    assert kept.read_bytes() == content
    evaluate_once((kept, replace(case, plant=replace(case.plant, knob_coulomb_nm=0.0))))
    assert len(kept.read_bytes()) > len(content)


def test_corners_of_the_search_are_plants_that_the_emulator_takes() -> None:
    for corner in (0.0, 1.0):
        for number in (0, 15):
            assert np.isfinite(emulate(extreme_case(number, [corner] * len(SPACE)))).all()


@pytest.mark.slow
def test_study_encloses_its_scenes_and_200_random_plants(tmp_path: Path) -> None:
    results = execute("enclosure", out=tmp_path)
    assert len(results["rows"]) == 202
    assert results["undecided"] == 0
    assert results["least_digits"] >= DIGITS
    assert results["worst"]["error"] < 1e-11
    assert (tmp_path / "enclosure_errors.png").stat().st_size > 10_000
