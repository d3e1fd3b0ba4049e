"""Calibration through a current loop: it knows what the motor gives less than it is told."""

from __future__ import annotations

import math
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import torsio
from tests.board import pico
from tests.studies.hidden import board_plant, calibrate_hidden, hidden_board
from torsio.calibration import calibrate, doubts, procedure
from torsio.calibration.drive import Drive, drive_of
from torsio.calibration.quantity import Quantity, Refusal
from torsio_studies.calibration.driven import (
    ALL,
    drawn_electrics,
    measure_driven,
    seen_truth,
)
from torsio_studies.calibration.knobs import hidden_knob, truth_of


@pytest.fixture(autouse=True)
def _model() -> Iterator[None]:
    """Run on a pico2, and leave what other tests had chosen."""
    before = pico.chosen.name
    pico.choose("pico2")
    yield
    pico.choose(before)


def test_torque_that_is_missing_is_that_of_the_current_that_rises_until_it_is_read() -> None:
    # 12 V at 1.5 mH for a microsecond are 8 mA, and half of it at half the voltage.
    drive = Drive(0.05, 2.5, 12.0, 0.0, 0.02, rise_a=12.0 / 1.5e-3 * 1e-6)
    half_nm = 6.0 / 2.5 * 0.05
    told_nm = np.array([half_nm, -half_nm, 0.0, 0.0])
    speed_rad_s = np.array([0.0, 0.0, 60.0, 0.0])  # at a back EMF of 3 V
    expected = [0.05 * 4e-3, -0.05 * 4e-3, 0.05 * 6e-3, 0.0]
    assert drive.missing_nm(told_nm, speed_rad_s) == pytest.approx(expected)


@pytest.mark.parametrize("number", [1003, 1006, 1012])
def test_intervals_hold_the_truth_with_a_current_loop(number: int) -> None:
    found = calibrate_hidden(hidden_knob(number), quick=True, emulated=True)["found"]
    for name in ("coulomb_nm", "stiffness_nm_per_rad", "viscous_nm_s_per_rad"):
        value, sigma, truth = found[name]
        assert abs(value - truth) < 3.0 * sigma, name
        assert sigma < 0.2 * truth


def test_knob_with_drawn_signs_is_refused_where_they_disagree_and_then_measured() -> None:
    # Motor and encoder of the first agree, both the wrong way round; the second's do not.
    for number, agree in ((1202, True), (1203, False)):
        hidden = hidden_knob(number)
        assert (drawn_electrics(number).motor_reversed == hidden.reversed) is agree
        row = measure_driven(hidden)
        assert row["complete"] == row["refused_rightly"] == 1.0
        scores = [
            abs(row[f"{name}_value"] - row[f"{name}_truth"]) / row[f"{name}_sigma"] for name in ALL
        ]
        known = np.array([score for score in scores if np.isfinite(score)])
        assert len(known) > 20
        assert np.mean(known <= 1.96) >= 0.8
        assert max(scores[ALL.index(name)] for name in ("rise_s", "motor_resistance_ohm")) <= 1.96


def test_brake_s_torque_over_its_current_holds_the_truth_with_a_current_loop() -> None:
    hidden = hidden_knob(1012)  # reads its current later than most boards
    assert hidden.plant.brake_hysteresis is not None
    half_nm = hidden.plant.brake_hysteresis.half_width_nm
    with hidden_board(hidden, emulated=True) as knob:
        knob.update(encoder_reversed=False)
        found = calibrate(knob)
    curve = found.brake_curve
    assert curve is not None
    # The board's torque and command when supply and sensor are off.
    board = found.board
    told = torsio.BoardConfig().motor_torque_constant_nm_per_a
    seen = seen_truth(
        board_plant(hidden),
        constant_known=board is not None and board.motor_torque_constant_nm_per_a != told,
    )
    measure = seen["inertia_kg_m2"] / truth_of(hidden.plant)["inertia_kg_m2"]
    command = seen["brake_gain"] / measure
    held_nm = half_nm
    for point in curve.points:
        given_nm = command * point.command_nm
        held_nm = min(max(held_nm, given_nm - half_nm), given_nm + half_nm)
        assert abs(point.torque_nm - measure * held_nm) < 3.0 * point.sigma_nm < 1.5e-3
    assert curve.is_straight


def test_what_is_refused_under_a_drive_that_may_be_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*_: Any, **__: Any) -> Any:
        raise Refusal("shaft", "locked", "it does not twist")

    monkeypatch.setattr(procedure, "_under", refuse)
    refused = calibrate_hidden(hidden_knob(1003), quick=True, emulated=True)["refused"]
    assert refused is not None
    assert refused.startswith("locked")


def test_what_is_not_there_under_a_drive_that_may_be_is_uncertain_by_all_of_itself() -> None:
    found = {"knee_rad": Quantity("knee_rad", 0.3, 0.01)}
    for case, expected in (({"knee_rad": Quantity("knee_rad", 0.26, 0.02)}, 0.04), ({}, 0.3)):
        assert abs(doubts.differences(found, case)["knee_rad"]) == pytest.approx(expected)


def test_simple_loop_stays_behind_a_back_emf_that_grows_as_if_there_were_more_inertia() -> None:
    # The loop and the winding, period by period, at a knob that speeds up evenly.
    period_s, ohm, henry, constant = 100e-6, 2.5, 1.5e-3, 0.05
    settled = 1.0 - math.exp(-ohm * period_s / henry)
    push_v_per_a = (1.0 - math.exp(-math.pi / 5.0)) * ohm / settled
    rate_rad_s2, told_a = 400.0, 0.5
    integral_v = current_a = 0.0
    for period in range(3000):
        voltage_v = integral_v + push_v_per_a * (told_a - current_a)
        integral_v += settled * (voltage_v - integral_v)
        emf_v = constant * rate_rad_s2 * period_s * (period + 0.5)
        current_a += settled * ((voltage_v - emf_v) / ohm - current_a)
    missing_nm = constant * (told_a - current_a)

    def drive(current_period_s: float) -> Drive | None:
        config = torsio.BoardConfig(motor_resistance_ohm=ohm, motor_inductance_h=henry)
        knob: Any = SimpleNamespace(
            info=SimpleNamespace(control_rate_hz=10e3),
            board_config=lambda: config,
            motor_current=lambda: SimpleNamespace(measured=True, period_s=current_period_s),
        )
        return drive_of(knob)

    simple, predictive = drive(period_s), drive(25e-6)
    assert simple is not None
    assert predictive is not None
    assert simple.added_kg_m2 == pytest.approx(missing_nm / rate_rad_s2, rel=0.1)
    assert predictive.added_kg_m2 == 0.0


def test_intervals_hold_the_truth_with_a_pico_s_current_loop() -> None:
    pico.choose("pico")
    held = {}
    for number in (1021, 1024, 1030):
        found = calibrate_hidden(hidden_knob(number), quick=False, emulated=True)["found"]
        for name in ("inertia_kg_m2", "knob_inertia_kg_m2", "brake_gain", "offset_nm"):
            value, sigma, truth = found[name]
            held[name, number] = abs(value - truth) <= 1.96 * sigma
    assert all(held.values()), held


@pytest.mark.parametrize(
    ("period_s", "control_rate_hz", "share"),
    [
        # A pico2's, 10 kHz at 40 kHz: 1 - exp(-pi / 2), a third answered and taken back.
        (25e-6, 20e3, math.sqrt(2.0) / 3.0 * 0.79212 / (1.0 - math.exp(-25e-6 / 0.6e-3))),
        # A pico's, held at a tenth of 10 kHz: 1 - exp(-pi / 5).
        (100e-6, 10e3, 0.46651 / (1.0 - math.exp(-100e-6 / 0.6e-3))),
        (0.0, 10e3, None),
    ],
)
def test_bridge_answers_the_noise_as_the_board_s_current_loop_does(
    period_s: float, control_rate_hz: float, share: float | None
) -> None:
    config = torsio.BoardConfig(
        motor_resistance_ohm=2.5,
        motor_inductance_h=1.5e-3,
        current_bandwidth_hz=10_000,
        current_sense_v_per_a=0.5,
        supply_v=12.0,
    )
    knob: Any = SimpleNamespace(
        info=SimpleNamespace(control_rate_hz=control_rate_hz),
        board_config=lambda: config,
        motor_current=lambda: SimpleNamespace(measured=share is not None, period_s=period_s),
    )
    drive = drive_of(knob)
    if share is None:
        assert drive is None
    else:
        assert drive is not None
        assert drive.blur == pytest.approx(share * 2.5 * 2e-3 / 12.0, rel=1e-4)
