"""Whether `doctor` tells a wrong belief from ordinary use, with a hand on the knob, as JSON lines.

``./dev bench beliefs [KNOBS] [FIRST]`` takes plants and hands of ``torsio study falsify``, without
noise. A hand of 0.1 to 10 N m/rad turns the knob to and fro for ten seconds in each of seven
scenes. The device believes the truth, or one value is wrong. A line tells for one belief

- ``sessions``, ``warned``: how many hands, and after how many `doctor` would warn;
- ``counted``: after how many the device had counted any swing.
"""

from __future__ import annotations

import json
import math
import sys
import warnings
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import torsio
from torsio.apps.doctor.examination import UNEXPECTED_SWINGS
from torsio.closed_loop import LoopOptions
from torsio_studies.falsify.cases import SCENES, SPACE, Case, batches, options_of, values_of

TURNED_S = 10.0
TOLD = ("", *(name for name in SPACE if name.startswith("told.") and "torque" not in name))


def turning(random: np.random.Generator, options: LoopOptions) -> torsio.ImpedanceHand:
    """Give the hand that turns to and fro, now and again, by up to a radian."""
    hand = options.hand
    assert isinstance(hand, torsio.ImpedanceHand)
    times_s = np.cumsum(random.uniform(0.1, 1.0, 200))
    widest_rad = math.exp(random.uniform(math.log(0.02), 0.0))
    angles_rad = 0.05 + widest_rad * random.uniform(-1.0, 1.0, len(times_s))
    way = [(0.0, 0.0), *zip(times_s.tolist(), angles_rad.tolist(), strict=True)]
    return replace(hand, intended_angle_rad=way)


def unexpected(case: Case, told: str) -> int:
    """Turn a knob in all scenes; give how many swings its device has counted as unexpected."""
    random = np.random.default_rng([36, case.number])
    value = values_of(random.uniform(size=len(SPACE)))
    low_or_high = SPACE[told][case.number % 2] if told else 1.0
    value |= {name: 1.0 for name in SPACE if name.startswith("told.")} | {told: low_or_high}
    first = options_of(replace(case, hand="held", electrics=False, noisy=False), value)
    assert first.actuator is not None
    options = torsio.EmulatorOptions(plant=first.plant, control_rate_hz=case.rate_hz)
    with torsio.open("emulated", emulator=options) as knob, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        knob.configure(first.actuator)
        knob.configure(first.plant.matching_shaft())
        knob.update(law="calibrated", beta=first.control.beta)
        for scene in SCENES:
            knob.emulator.set_hand(turning(random, first))
            effects = options_of(replace(case, scene=scene, electrics=False), value).scene
            assert effects is not None
            knob.play(effects)
            knob.arm()
            knob.sleep(TURNED_S)
        assert knob.state == "armed"
        return knob.health().unexpected_swings


def main(arguments: Sequence[str]) -> None:
    """Print a line for each belief."""
    knobs, first = (int(each) for each in [*arguments, *("60", "0")[len(arguments) :]])
    cases = [batch.designs[0] for batch in batches(first + knobs, 1, "calibrated")][first:]
    for told in TOLD:
        swings = [unexpected(case, told) for case in cases]
        line = {
            "belief": told or "the truth",
            "sessions": len(swings),
            "counted": sum(one > 0 for one in swings),
            "warned": sum(one >= UNEXPECTED_SWINGS for one in swings),
        }
        print(json.dumps({**line, "most": sorted(swings)[-12:]}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
