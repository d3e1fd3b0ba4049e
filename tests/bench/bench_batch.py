"""The cost of many knobs at once: control ticks and environment steps a second, one JSON line each.

Closed loops with a wall and a hand at 1 kHz: by themselves, together with the same plant and with
one of their own each, and with actions every step; the Gymnasium environment; and how much of that
more threads bring, in one long step and in steps of a tick: by the clock, so other programs matter
(`load` is how many wanted a processor), and in processor time, which is what one thread takes to
what several take together. Else processor time of one thread; the least of several repeats.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

import torsio
from torsio.batch import Knobs, LoopOptions
from torsio.closed_loop import ClosedLoop

GOAL_TICKS_PER_S = 1e7
GOAL_STEPS_PER_S = 1e6
GOAL_SCALING = 0.9

HAND = torsio.ImpedanceHand(
    inertia_kg_m2=1e-4,
    stiffness_nm_per_rad=0.8,
    damping_nm_s_per_rad=4e-3,
    intended_angle_rad=[(0.0, 0.0), (0.5, 0.25), (1.0, 0.0)],
)
OPTIONS = LoopOptions(scene=torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=1.4), hand=HAND)


def shortest_s(run: Callable[[], object], repeats: int) -> float:
    """Time a run that has been warm before."""
    run()
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        run()
        times.append(time.process_time() - begin)
    return min(times)


def together(n: int, ticks: int, options: Any) -> Callable[[], None]:
    """Give a run of so many ticks, each time from the beginning."""
    knobs = Knobs(n, options, threads=1)

    def run() -> None:
        knobs.reset()
        knobs.step(ticks)

    return run


def measure(n: int, ticks: int, repeats: int) -> list[dict[str, Any]]:
    """Give a line for each measurement."""
    rng = np.random.default_rng(1)
    lines: list[dict[str, Any]] = []

    def add(what: str, count: int, seconds: float, **more: Any) -> None:
        lines.append(
            {
                "benchmark": "batch",
                "what": what,
                "knobs": n,
                "per_s": round(count / seconds),
                "ns": round(1e9 * seconds / count, 1),
                **more,
            }
        )

    alone = ClosedLoop(OPTIONS)
    add(
        "ticks, one loop by itself",
        n * ticks,
        shortest_s(lambda: alone.run(duration_s=1e-3 * n * ticks, record_every=2**31), repeats),
    )
    same_s = shortest_s(together(n, ticks, OPTIONS), repeats)
    add("ticks, same plant", n * ticks, same_s, goal=GOAL_TICKS_PER_S)
    own = [
        replace(OPTIONS, plant=torsio.PlantParams(knob_coulomb_nm=float(friction)))
        for friction in rng.uniform(4e-3, 8e-3, n)
    ]
    add("ticks, a plant of their own", n * ticks, shortest_s(together(n, ticks, own), repeats))

    pushed = Knobs(n, replace(OPTIONS, hand=torsio.TorqueHand(torque_nm=0.0)), actions="hand",
                   threads=1)  # fmt: skip

    def push() -> None:
        pushed.reset()
        for _ in range(ticks):
            pushed.actions["hand_torque_nm"] = 0.03
            pushed.step()

    add("steps of 1 ms with an action", n * ticks, shortest_s(push, repeats), goal=GOAL_STEPS_PER_S)
    lines += environment(n, ticks, repeats)

    for threads in range(2, (os.cpu_count() or 1) + 1):
        for at_once, steps in ((ticks, "long steps"), (1, "steps of one tick")):
            clock_s, processor_s = one_and_many(n, ticks, at_once, threads, repeats)
            add(f"ticks, threads, {steps}", n * ticks, clock_s[1], threads=threads,
                scaling=round(clock_s[0] / clock_s[1] / threads, 3),
                processor_scaling=round(processor_s[0] / processor_s[1], 3),
                goal_scaling=GOAL_SCALING, load=round(os.getloadavg()[0], 1))  # fmt: skip
    return lines


def one_and_many(
    n: int, ticks: int, at_once: int, threads: int, repeats: int
) -> tuple[list[float], list[float]]:
    """Time one thread and several by turns, so that a busy moment meets both.

    Returns
    -------
    By the clock and in processor time, the least of one thread and of several.
    """
    knobs = [Knobs(n, OPTIONS, threads=count) for count in (1, threads)]
    clock_s, processor_s = [np.inf, np.inf], [np.inf, np.inf]
    for _ in range(repeats + 1):
        for i, some in enumerate(knobs):
            some.reset()
            begin_s, processor_begin_s = time.perf_counter(), time.process_time()
            for _ in range(ticks // at_once):
                some.step(at_once)
            clock_s[i] = min(clock_s[i], time.perf_counter() - begin_s)
            processor_s[i] = min(processor_s[i], time.process_time() - processor_begin_s)
    return clock_s, processor_s


def environment(n: int, ticks: int, repeats: int) -> list[dict[str, Any]]:
    """Time the Gymnasium environment, if Gymnasium is there."""
    try:
        from torsio.gym import KnobVectorEnv, RenderWall
    except ModuleNotFoundError:
        return []
    env = KnobVectorEnv(RenderWall(), n, threads=1)
    env.reset(seed=1)
    actions = np.zeros(env.action_space.shape or (), dtype=np.float32)

    def run() -> None:
        for _ in range(ticks):
            env.step(actions)

    seconds = shortest_s(run, repeats)
    return [
        {
            "benchmark": "batch",
            "what": "steps of 1 ms of RenderWall in Gymnasium",
            "knobs": n,
            "per_s": round(n * ticks / seconds),
            "ns": round(1e9 * seconds / (n * ticks), 1),
        }
    ]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--knobs", type=int, default=1024)
    parser.add_argument("--ticks", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    for line in measure(arguments.knobs, arguments.ticks, arguments.repeats):
        print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
