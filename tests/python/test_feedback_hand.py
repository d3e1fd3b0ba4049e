"""Hands that are functions of the knob's motion."""

from __future__ import annotations

import sys
import threading
import time
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import torsio
from torsio.closed_loop import ClosedLoop, LoopOptions, simulate
from torsio.emulator import Plant

RIGID = torsio.PlantParams(
    spring_and_brake=False, knob_coulomb_nm=0.0, brake_drag_nm=0.0, motor_time_constant_s=0.0
)


def open_knob(hand: torsio.Hand, **more: Any) -> torsio.Knob:
    options = torsio.EmulatorOptions(hand=hand, log_truth=True, **more)
    return torsio.open("emulated", emulator=options)


def test_a_spring_as_a_function_swings_like_one_at_a_short_period() -> None:
    hand = torsio.FeedbackHand(
        torque_nm=lambda _, angle_rad, speed_rad_s: -0.5 * (angle_rad - 0.2) - 2e-3 * speed_rad_s,
        period_s=1e-5,
    )
    plant = Plant(RIGID, hand)
    plant.advance(50_000_000)
    inertia = RIGID.knob_inertia_kg_m2 + RIGID.brake_inertia_kg_m2
    viscous = RIGID.knob_viscous_nm_s_per_rad + RIGID.brake_viscous_nm_s_per_rad + 2e-3
    swing = solve_ivp(
        lambda _, y: [y[1], (-0.5 * (y[0] - 0.2) - viscous * y[1]) / inertia],
        (0.0, 0.05), [0.0, 0.0], rtol=1e-10, atol=1e-12,
    )  # fmt: skip
    assert plant.state["angle_rad"] == pytest.approx(swing.y[0, -1], rel=3e-3)


def test_a_hand_that_seeks_finds_the_wall() -> None:
    def torque_nm(_: float, __: float, speed_rad_s: float) -> float:
        return 0.03 + 0.01 * (0.5 - speed_rad_s)

    with open_knob(torsio.FeedbackHand(torque_nm=torque_nm)) as knob:
        knob.play(torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.4))
        knob.arm()
        log = knob.record(2.0)
        held_nm = knob.emulator.truth()["hand_torque_nm"][-1]
    assert held_nm == pytest.approx(0.035, abs=2e-3)
    assert log["angle_rad"][-1] == pytest.approx(0.1 + 0.03 / 1.4, abs=0.01)


def test_same_in_a_closed_loop_in_one_run_or_several() -> None:
    def torque_nm(_: float, angle_rad: float, speed_rad_s: float) -> float:
        return 0.5 * (0.2 - angle_rad) - 2e-3 * speed_rad_s

    options = LoopOptions(hand=torsio.FeedbackHand(torque_nm=torque_nm, period_s=0.0007))
    whole = simulate(options, duration_s=0.2)
    loop = ClosedLoop(options)
    parts = np.concatenate([loop.run(duration_s=0.05) for _ in range(4)])
    assert all(np.array_equal(whole[name], parts[name]) for name in whole.dtype.names or ())


def test_after_a_failure_the_hand_is_where_the_device_is() -> None:
    def last_angle_rad(fails: bool) -> float:
        def torque_nm(time_s: float, *_: float) -> float:
            if not 0.1055 < time_s < 0.106:  # in the middle of a tick
                return 0.01
            if fails:
                raise ValueError("once")
            return 0.0

        hand = torsio.FeedbackHand(torque_nm=torque_nm, period_s=0.0007)
        with open_knob(hand, plant=RIGID) as knob:
            while knob.emulator.time_s < 0.2:
                try:
                    knob.sleep(0.01)
                except torsio.Error as error:
                    assert fails and "once" in str(error)  # noqa: PT017, PT018
            truth = knob.emulator.truth()
        return float(truth["angle_rad"][190])

    assert last_angle_rad(True) == pytest.approx(last_angle_rad(False), rel=1e-9)


def test_what_the_function_raises_is_told_and_time_goes_on_without_a_torque() -> None:
    def torque_nm(time_s: float, *_: float) -> float:
        if 0.1 <= time_s < 0.102:
            raise ZeroDivisionError("by hand")
        return 0.01

    with open_knob(torsio.FeedbackHand(torque_nm=torque_nm)) as knob:
        with pytest.raises(
            torsio.Error, match="the hand's function raised ZeroDivisionError: by hand"
        ):
            knob.sleep(0.2)
        for _ in range(3):
            try:
                knob.sleep(0.05)
            except torsio.Error:
                continue
        assert knob.emulator.truth()["hand_torque_nm"][-1] == 0.01


@pytest.mark.parametrize(("paced", "ends"), [(False, SystemExit), (True, torsio.Disconnected)])
def test_exit_of_the_function_ends_the_call_or_the_world_of_its_own(
    paced: bool, ends: type[BaseException]
) -> None:
    def torque_nm(time_s: float, *_: float) -> float:
        if time_s > 0.1:
            sys.exit(7)
        return 0.0

    hand = torsio.FeedbackHand(torque_nm=torque_nm)
    with open_knob(hand, paced=paced) as knob, pytest.raises(ends, match="7"):
        knob.sleep(5.0)


def test_an_answer_that_is_no_number_is_refused() -> None:
    hand = torsio.FeedbackHand(torque_nm=lambda *_: "strong")  # type: ignore[arg-type]
    with pytest.raises(torsio.Error, match="the hand's function raised TypeError"):
        open_knob(hand)


def test_only_a_function_is_taken() -> None:
    with pytest.raises(TypeError, match=r"torque_nm must be a function, is 0\.1"):
        torsio.FeedbackHand(torque_nm=0.1)  # type: ignore[arg-type]


def test_function_that_uses_the_knob_is_told_instead_of_waiting_for_ever() -> None:
    knobs: list[torsio.Knob] = []

    def torque_nm(*_: float) -> float:
        return knobs[0].position_rad() if knobs else 0.0

    with open_knob(torsio.FeedbackHand(torque_nm=torque_nm)) as knob:
        knobs.append(knob)
        with pytest.raises(torsio.Error, match="the function of a hand cannot use a knob"):
            knob.sleep(0.01)


def test_state_can_be_asked_while_another_thread_lets_time_pass() -> None:
    with open_knob(torsio.FeedbackHand(torque_nm=lambda *_: 0.0, period_s=1e-4)) as knob:
        sleeper = threading.Thread(target=knob.sleep, args=(2.0,))
        sleeper.start()
        while sleeper.is_alive():
            assert knob.state == "disarmed"
            knob.statistics()
            assert knob.last_disarm is None
        sleeper.join()


def test_paced_knob_asks_while_python_goes_on() -> None:
    asked = threading.Event()

    def torque_nm(*_: float) -> float:
        asked.set()
        return 0.01

    with open_knob(torsio.NoHand(), paced=True) as knob:
        knob.emulator.set_hand(torsio.FeedbackHand(torque_nm=torque_nm, period_s=1e-3))
        end_s = time.monotonic() + 0.5
        while time.monotonic() < end_s:
            knob.emulator.game.read()
            knob.statistics()
            assert knob.state == "disarmed"
        assert asked.is_set()
        knob.position_rad()


def test_paced_knob_tells_of_a_function_that_failed() -> None:
    def torque_nm(time_s: float, *_: float) -> float:
        if time_s > 0.02:
            raise ValueError("enough")
        return 0.0

    def ask_on(knob: torsio.Knob) -> None:
        for _ in range(100):
            knob.sleep(0.01)
            knob.position_rad()

    hand = torsio.FeedbackHand(torque_nm=torque_nm)
    with (
        open_knob(hand, paced=True) as knob,
        pytest.raises(torsio.Error, match="raised ValueError: enough"),
    ):
        ask_on(knob)
