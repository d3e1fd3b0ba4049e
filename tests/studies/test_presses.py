"""A wall is no ratchet: a knob that is pressed repeatedly comes back, and keeps its springs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from torsio import ControlConfig, EndStops, PlantParams, Spring, TorqueHand, Wall
from torsio.closed_loop import ClosedLoop, LoopOptions
from torsio.printed.scenes import Effect

AT_RAD = 0.05
PRESS_NM = 75e-3
FRICTION_NM = 6e-3
HELD_NM = 8e-3  # with the drag


def presses(
    scene: list[Effect], counts: int, rate_hz: int, press_nm: float = PRESS_NM, times: int = 8
) -> tuple[list[float], list[float]]:
    """@returns where the knob is at the end of each press, and once it is let off"""
    knots, marks_s, now_s = [(0.0, 0.0)], [], 0.0
    for _ in range(times):
        knots += [(now_s + 1.0, press_nm), (now_s + 1.3, press_nm), (now_s + 1.5, 0.0)]
        marks_s += [now_s + 1.25, now_s + 1.79]
        now_s += 1.8
        knots.append((now_s, 0.0))
    plant = PlantParams(counts_per_rev=counts)
    loop = ClosedLoop(
        LoopOptions(
            scene=scene,
            hand=TorqueHand(torque_nm=knots),
            plant=plant,
            actuator=plant.matching_config(),
            control=ControlConfig(law="calibrated"),
            control_period_ns=round(1e9 / rate_hz),
        )
    )
    rows = loop.run(duration_s=now_s, record_every=rate_hz // 1000)
    angles = [float(rows["angle_rad"][round(1000 * mark_s)]) for mark_s in marks_s]
    return angles[::2], angles[1::2]


@pytest.mark.parametrize("rate_hz", [10_000, 20_000])
@pytest.mark.parametrize("counts", [2048, 8192, 32_768])
@pytest.mark.parametrize(
    "effect",
    [
        Wall(angle_rad=AT_RAD, stiffness_nm_per_rad=300.0),
        Wall(angle_rad=AT_RAD, stiffness_nm_per_rad=30.0),
        EndStops(lower_rad=-1.0, upper_rad=AT_RAD, stiffness_nm_per_rad=30.0),
        Spring(angle_rad=0.0, stiffness_nm_per_rad=300.0),
    ],
    ids=["wall 300", "wall 30", "end stops", "spring"],
)
def test_press_after_press_goes_no_deeper_than_the_softest_spring_and_the_knob_comes_back(
    effect: Effect, counts: int, rate_hz: int
) -> None:
    surface_rad = 0.0 if isinstance(effect, Spring) else AT_RAD
    count_rad = 2 * math.pi / counts
    pressed, let_off = presses([effect], counts, rate_hz)
    # No flicker makes it softer than where a count switches half of what friction holds.
    softest_nm_per_rad = 0.5 * FRICTION_NM / count_rad
    assert max(pressed) - surface_rad < PRESS_NM / softest_nm_per_rad + PRESS_NM / 30.0
    assert max(let_off) - surface_rad < HELD_NM / 30.0 + 2 * count_rad


@pytest.mark.parametrize("counts", [8192, 32_768])
def test_a_spring_draws_the_knob_back_from_a_wall(counts: int) -> None:
    spring = Spring(angle_rad=0.0, stiffness_nm_per_rad=1.0)
    wall = Wall(angle_rad=AT_RAD, stiffness_nm_per_rad=300.0)
    pressed, let_off = presses([spring, wall], counts, 20_000, press_nm=0.1, times=2)
    assert np.all(np.array(pressed) > AT_RAD)
    assert np.all(np.abs(let_off) < HELD_NM / 1.0)
