"""Many closed loops at once do what each would do alone."""

from __future__ import annotations

import copy
import hashlib
import os
import pickle
import signal
import threading
import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import torsio
from torsio.batch import ACTION_DTYPE, Knobs, LoopOptions
from torsio.closed_loop import LOOP_DTYPE, ClosedLoop, InitialState, SpinUp, simulate

TICKS = 300
PUSH = torsio.TorqueHand(torque_nm=[(0.0, 0.0), (0.1, 0.05), (0.2, -0.02)])
COLUMNS = [name for name in LOOP_DTYPE.names or () if name != "hand_torque_nm"]


def loops() -> list[LoopOptions]:
    """Give unlike ones: plants, hands, scenes, laws, delays, noise."""
    wall = torsio.Wall(angle_rad=0.02, stiffness_nm_per_rad=1.0)
    noisy = torsio.PlantParams(encoder_noise_counts=0.7)
    held = torsio.ImpedanceHand(
        stiffness_nm_per_rad=0.8, damping_nm_s_per_rad=4e-3, intended_angle_rad=[(0, 0), (0.2, 0.2)]
    )
    driven = torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (0.2, 0.1)])
    belt = torsio.PlantParams(belt=torsio.Belt(), cogging=torsio.Cogging.sine(
        periods_per_rev=12, amplitude_nm=2e-3))  # fmt: skip
    compensated = torsio.ControlConfig(law="compensated")
    detents = [torsio.Detents(per_turn=60, torque_nm=0.02), torsio.Friction(torque_nm=5e-3)]
    return [
        LoopOptions(scene=wall, hand=PUSH),
        LoopOptions(scene=wall, hand=PUSH, plant=noisy),
        LoopOptions(scene=detents, hand=held, plant=noisy, control=compensated),
        LoopOptions(scene=wall, hand=driven, plant=belt, delay_ticks=2),
        LoopOptions(scene=wall, hand=PUSH, initial=InitialState(angle_rad=0.01, speed_rad_s=1.0)),
    ]


def alone(options: LoopOptions, seed: int, ticks: int) -> np.void:
    """Give the row of the moment after so many ticks."""
    rows = simulate(replace(options, seed=seed), duration_s=1e-3 * (ticks + 1))
    row: np.void = rows[ticks]
    return row


def bits(rows: Any) -> bytes:
    """Give the bytes of all columns; what lies between them is not copied everywhere."""
    rows = np.asarray(rows)
    return b"".join(np.ascontiguousarray(rows[name]).tobytes() for name in rows.dtype.names or ())


@pytest.mark.parametrize("threads", [1, 2, 3, 16])
def test_every_knob_does_what_it_would_alone_to_the_bit(threads: int) -> None:
    kinds = loops()
    each = [kinds[i % len(kinds)] for i in range(23)]
    knobs = Knobs(len(each), each, seeds=40, threads=threads)
    for done in (0, 1, 100, TICKS):
        while_s = done - round(1e3 * float(knobs.states["time_s"][0]))
        if while_s:
            knobs.step(while_s)
        for i, options in enumerate(each):
            assert bits(knobs.states[i]) == bits(alone(options, 40 + i, done)), (i, done)


def test_seeds_make_the_noise_and_nothing_else() -> None:
    noisy = LoopOptions(plant=torsio.PlantParams(encoder_noise_counts=2.0))
    quiet = LoopOptions(scene=loops()[0].scene, hand=PUSH)
    knobs = Knobs(4, noisy, seeds=[1, 2, 1, 3])
    knobs.step(50)
    assert bits(knobs.states[0]) == bits(knobs.states[2])
    assert len({int(count) for count in knobs.states["position_counts"]}) > 1
    knobs = Knobs(2, quiet, seeds=5)
    knobs.step(50)
    assert bits(knobs.states[0]) == bits(knobs.states[1])


def test_hands_actions_are_those_of_a_hand_that_takes_over() -> None:
    options = replace(loops()[1], hand=torsio.TorqueHand(torque_nm=0.0))
    torques_nm = [0.03, 0.05, -0.01, 0.0]
    knobs = Knobs(3, options, actions="hand", seeds=[7, 7, 8], threads=2)
    loop = ClosedLoop(replace(options, seed=7))
    for torque_nm in torques_nm:
        knobs.actions["hand_torque_nm"] = torque_nm
        knobs.step(25)
        loop.set_hand(torsio.TorqueHand(torque_nm=torque_nm))
        loop.run(duration_s=0.025)
    last = loop.run(duration_s=1e-3)[0]
    assert bits(knobs.states[COLUMNS][0].copy()) == bits(last[COLUMNS].copy())
    assert knobs.states["hand_torque_nm"][0] == 0.0


def test_commands_are_those_that_a_loop_is_told_to_hold() -> None:
    options = loops()[2]
    knobs = Knobs(2, options, actions="commands", seeds=[3, 4])
    loop = ClosedLoop(replace(options, seed=3))
    for motor_nm, brake_nm in ((0.02, 0.0), (0.0, 0.1), (-0.05, 0.03)):
        knobs.actions["motor_command_nm"] = motor_nm
        knobs.actions["brake_command_nm"] = brake_nm
        knobs.step(40)
        loop.hold_command(motor_command_nm=motor_nm, brake_command_nm=brake_nm)
        loop.run(duration_s=0.04)
    assert bits(knobs.states[0]) == bits(loop.run(duration_s=1e-3)[0])
    assert knobs.states["motor_torque_nm"][0] == pytest.approx(-0.05, abs=1e-6)


def test_reset_begins_some_anew_and_leaves_the_others() -> None:
    knobs = Knobs(5, loops(), seeds=11)
    first = knobs.states.copy()
    knobs.step(60)
    others = knobs.states.copy()
    knobs.reset([1, 2], seeds=[90, 91])
    assert bits(knobs.states[[0, 3, 4]]) == bits(others[[0, 3, 4]])
    knobs.step(10)
    assert bits(knobs.states[1]) == bits(alone(loops()[1], 90, 10))
    assert bits(knobs.states[2]) == bits(alone(loops()[2], 91, 10))
    knobs.reset(np.array([True, False, True, True, False]))
    assert bits(knobs.states[[0, 2, 3]]) == bits(first[[0, 2, 3]])
    knobs.reset()
    assert bits(knobs.states) == bits(first)


def test_knobs_whose_state_is_set_go_on_to_the_bit() -> None:
    knobs, others = (Knobs(5, loops(), seeds=3, threads=n) for n in (1, 3))
    knobs.step(151)  # odd, and behind a corner of the hand
    state = knobs.state()
    others.set_state(state)
    pickled, copied = pickle.loads(pickle.dumps(others)), copy.copy(knobs)
    every = (knobs, others, pickled, copied)
    for same in every:
        same.step(49)
    assert len({bits(same.states) for same in every}) == 1
    assert bits(knobs.states[0]) == bits(alone(loops()[0], 3, 200))
    for bad, said in (
        (state[:-1] + bytes([state[-1] ^ 1]), "the state is damaged, or not of version"),
        (b"torsio 0.0.0" + state, "the state is damaged, or not of version"),
        (Knobs(4).state(), "the state is of other knobs"),
    ):
        with pytest.raises(ValueError, match=said):
            knobs.set_state(bad)
    assert bits(knobs.states) == bits(others.states)
    electric = LoopOptions(plant=torsio.PlantParams(electrics=torsio.Electrics()))
    with pytest.raises(ValueError, match="a plant with electrics cannot be saved"):
        Knobs(1, electric).state()


def test_states_and_actions_are_the_knobs_own_memory() -> None:
    knobs = Knobs(3, loops()[0])
    states, actions = knobs.states, knobs.actions
    assert states is knobs.states
    before_s = states["time_s"].copy()
    knobs.step()
    assert np.all(states["time_s"] > before_s)
    assert states.dtype == LOOP_DTYPE
    assert actions.dtype == ACTION_DTYPE
    assert actions.view(float).reshape(-1, 3).base is not None
    with pytest.raises(ValueError, match="read-only"):
        states["time_s"] = 0.0
    del knobs
    assert states["time_s"][0] == 1e-3  # the arrays keep the memory


def test_failure_names_the_knob_and_lets_the_others_go_on() -> None:
    options = LoopOptions(hand=torsio.TorqueHand(torque_nm=0.0))
    knobs = Knobs(6, options, actions="hand", threads=3)
    knobs.actions["hand_torque_nm"][[2, 5]] = np.nan
    with pytest.raises(ValueError, match="loop 2: plant: hand_torque_nm must be within -100"):
        knobs.step(3)
    assert list(knobs.states["time_s"]) == [3e-3, 3e-3, 0.0, 3e-3, 3e-3, 0.0]


def test_failure_in_a_long_step_leaves_all_others_at_its_end() -> None:
    """However many parts it is cut in; and who failed does not go on in a later part."""
    asked: list[float] = []

    def torque_nm(time_s: float, *_: float) -> float:
        asked.append(time_s)
        if time_s == 0.5:
            raise ValueError("once")
        return 0.0

    failing = LoopOptions(hand=torsio.FeedbackHand(torque_nm, period_s=0.1))
    knobs = Knobs(3, [LoopOptions(), failing, LoopOptions()], threads=1)
    with pytest.raises(RuntimeError, match=r"loop 1: .* ValueError: once"):
        knobs.step(1_000_000)
    assert knobs.states["time_s"][[0, 2]] == pytest.approx(1000.0)
    assert max(asked) == 0.5
    knobs.step(200)
    assert max(asked) > 0.5


def test_hands_that_are_functions_run_in_any_thread_one_at_a_time() -> None:
    called_by: set[int] = set()

    def torque_nm(_time_s: float, angle_rad: float, *_: float) -> float:
        called_by.add(threading.get_ident())
        time.sleep(1e-3)  # lets go of Python's lock, so that others get it
        return 0.03 - 0.1 * angle_rad

    options = LoopOptions(hand=torsio.FeedbackHand(torque_nm=torque_nm))
    many, one = (Knobs(8, options, threads=threads) for threads in (4, 1))
    many.step(200)  # worth 9 threads
    assert len(called_by) > 1
    one.step(200)
    assert bits(many.states) == bits(one.states)


def test_what_a_hand_raises_in_another_thread_reaches_the_caller() -> None:
    def torque_nm(time_s: float, *_: float) -> float:
        if time_s > 0.01 and threading.current_thread() is not threading.main_thread():
            raise ValueError("tired")
        time.sleep(1e-4)
        return 0.0

    knobs = Knobs(8, LoopOptions(hand=torsio.FeedbackHand(torque_nm=torque_nm)), threads=4)
    with pytest.raises(RuntimeError, match="the hand's function raised ValueError: tired"):
        knobs.step(400)


def test_forked_child_goes_on_with_the_same_knobs() -> None:
    knobs = Knobs(23, loops()[1], threads=3)
    knobs.step(TICKS)
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            signal.alarm(30)
            knobs.step(TICKS)
            os.write(write, hashlib.sha256(bits(knobs.states)).digest())
        finally:
            os._exit(0)
    os.close(write)
    with os.fdopen(read, "rb") as told:
        digest = told.read()
    _, status = os.waitpid(child, 0)
    assert status == 0
    knobs.step(TICKS)
    assert digest == hashlib.sha256(bits(knobs.states)).digest()


def test_a_step_within_a_step_is_told() -> None:
    told: list[str] = []

    def torque_nm(time_s: float, *_: float) -> float:
        if time_s > 0.0:
            with pytest.raises(torsio.Error) as caught:
                knobs.step()
            told.append(str(caught.value))
        return 0.0

    knobs = Knobs(1, LoopOptions(hand=torsio.FeedbackHand(torque_nm=torque_nm)))
    knobs.step(3)
    assert "these knobs are in the middle of a step" in told[0]


@pytest.mark.parametrize(
    ("n", "options", "more", "message"),
    [
        (0, None, {}, "n is 0, allowed are 1 to"),
        (2, [LoopOptions()], {}, "options are 1, and n is 2: one for each knob"),
        (2, None, {"actions": "law"}, "actions is 'law', allowed are 'none', 'hand'"),
        (2, None, {"actions": "hand"}, "so the hand must be a TorqueHand"),
        (2, None, {"seeds": [1]}, "seeds must be a whole number, or 2 of them"),
        (2, None, {"seeds": -1}, "seeds is -1, allowed are 0"),
        (2, None, {"seeds": [0, 2**64]}, "seeds is 18446744073709551616, allowed are 0"),
        (2, None, {"seeds": [0.0, 1.0]}, "seeds must be a whole number, or 2 of them"),
        (2, None, {"threads": 0}, "threads is 0, allowed are 1"),
        (1, LoopOptions(spin_up=SpinUp(motor_command_nm=0.08, speed_rad_s=5.0)), {}, "no spin-up"),
        (1, LoopOptions(delay_ticks=1001), {}, "delay_ticks must be at most 1000"),
    ],
)
def test_what_is_wrong_is_told_in_a_sentence(
    n: int, options: Any, more: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        Knobs(n, options, **{"threads": 1, **more})


@pytest.mark.parametrize("which", [[0, 0], [3], [-1], [0.5], [[0]], np.ones(2, dtype=bool)])
def test_reset_refuses_what_are_no_knobs(which: Any) -> None:
    with pytest.raises(torsio.InvalidArgument, match="which"):
        Knobs(3).reset(which)


@pytest.mark.parametrize(
    ("column", "torque_nm", "message"),
    [
        ("motor_command_nm", -100.1, "loop 1: motor_command_nm must be within -100 and 100"),
        ("motor_command_nm", np.nan, "loop 1: motor_command_nm must be within -100 and 100"),
        ("brake_command_nm", 1e9, "loop 1: brake_command_nm must be 0 to 100"),
        ("brake_command_nm", -5.0, "loop 1: brake_command_nm must be 0 to 100"),
        ("brake_command_nm", np.nan, "loop 1: brake_command_nm must be 0 to 100"),
    ],
)
def test_command_that_no_actuator_takes_is_told(
    column: str, torque_nm: float, message: str
) -> None:
    knobs = Knobs(3, actions="commands")
    knobs.actions[column][1] = torque_nm
    with pytest.raises(ValueError, match=message):
        knobs.step()
    knobs.actions[column][1] = 0.0
    knobs.step()


def test_interrupt_is_heard_within_a_step_of_knobs_that_take_long() -> None:
    driven = torsio.PlantParams(electrics=torsio.Electrics())
    knobs = Knobs(4, LoopOptions(plant=driven, control_period_ns=50_000), threads=1)
    before_s: list[float] = []

    def interrupt() -> None:
        before_s.append(float(knobs.states["time_s"][0]))
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.2, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        knobs.step(2**40)
    timer.join()
    # The first part is 1.25 s of knob time, each later one at most eight times as long. The signal
    # is heard at the end of a part. A part of 125 s would show.
    assert 0.0 < knobs.states["time_s"][0] < 100.0 * max(before_s[0], 0.5)
