"""How well `Knob.play` knows what swings: random scenes, warned of and tried, as JSON lines.

``./dev bench swings [SCENES] [FIRST_SEED]`` makes scenes of one to four effects at random, at four
control rates, with four encoders, two motors' lags and three laws, plays each on an emulated knob
to see whether it warns, and throws the same knob into it at eleven speeds, hands off, and at four
with a weight that leans on it either way. A line for each mistake has its seed, and the last line
tells

- ``swing``: in how many scenes a knob that was let go, or leant on, still swings after two seconds;
- ``unwarned``: of these, how many without a warning;
- ``hum``, ``hum_unwarned``: the same where friction holds the knob, but a hand feels its motor;
- ``rest``, ``warned``: the others, and how many of these with a warning.
"""

from __future__ import annotations

import json
import math
import random
import sys
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

import torsio
from torsio.closed_loop import InitialState, LoopOptions, simulate_many
from torsio.perception import VIBRATION_NM, vibration_nm
from torsio.printed.config import Law
from torsio.printed.scenes import Effect

SPEEDS_RAD_S = (0.5, 1.5, 3.0, 5.0, 7.0, 10.0, 14.0, 18.0, 22.0, 27.0, 33.0)
LEANING = [(speed, weight) for speed in (0.5, 3.0, 10.0, 22.0) for weight in (-0.015, 0.015)]
PUSHES = [(speed, 0.0) for speed in SPEEDS_RAD_S] + LEANING
"""Speeds in rad/s and torques of a weight in N m."""
AT_REST_RAD = 3e-3
_TRIED_S, _TAIL_S = 2.4, 0.4


@dataclass(frozen=True)
class Case:
    """A scene, and the knob that it is played on."""

    scene: list[Effect]
    plant: torsio.PlantParams
    law: Law
    rate_hz: float

    @property
    def control(self) -> torsio.ControlConfig:
        """How the knob is controlled."""
        return torsio.ControlConfig(law=self.law)


def _effect(r: random.Random) -> Effect:
    def some(low: float, high: float) -> float:
        return math.exp(r.uniform(math.log(low), math.log(high)))

    limit = r.choice([100.0, 100.0, some(3e-3, 0.1)])
    stiffness, angle = some(0.1, 80.0), r.uniform(-0.3, 0.3)
    damping = r.choice([0.0, some(1e-3, 0.2)])
    amplitude = some(5e-3, 0.1)
    makers: list[Callable[[], Effect]] = [
        lambda: torsio.Spring(
            stiffness_nm_per_rad=stiffness, torque_limit_nm=limit,
            angle_rad=r.choice([0.0, angle]), deadband_rad=r.choice([0.0, r.uniform(0.0, 0.1)]),
        ),
        lambda: torsio.Damper(damping_nm_s_per_rad=some(2e-3, 0.5), torque_limit_nm=limit),
        lambda: torsio.Inertia(inertia_kg_m2=some(1e-5, 2e-3), torque_limit_nm=limit),
        lambda: torsio.Friction(torque_nm=some(3e-3, 0.1), stiffness_nm_per_rad=some(0.3, 300.0)),
        lambda: torsio.Detents(
            per_turn=some(8.0, 400.0), torque_nm=amplitude, width=r.uniform(0.1, 1.0),
            profile=r.choice(["sine", "linear", "click"]),
        ),
        lambda: torsio.Wall(
            angle_rad=angle, side=r.choice(["above", "below"]),
            stiffness_nm_per_rad=stiffness, damping_nm_s_per_rad=damping,
        ),
        lambda: torsio.EndStops(
            lower_rad=angle, upper_rad=angle + r.choice([0.0, r.uniform(0.0, 0.5)]),
            stiffness_nm_per_rad=stiffness, damping_nm_s_per_rad=damping,
        ),
        lambda: torsio.Texture(
            grains_per_turn=r.randint(3, 400), torque_nm=0.5 * amplitude, seed=r.randint(0, 99),
            grain=r.choice(["sine", "square", "triangle", "noise"]),
        ),
        lambda: torsio.Curve(
            torque_nm=[r.uniform(-amplitude, amplitude) for _ in range(r.randint(2, 12))],
            span_rad=some(0.05, 3.0), angle_rad=angle, ends=r.choice(["hold", "repeat"]),
        ),
    ]  # fmt: skip
    return r.choice(makers)()


def random_case(seed: int) -> Case:
    """Make a case; the same seed makes the same."""
    r = random.Random(seed)
    return Case(
        scene=[_effect(r) for _ in range(r.choice([1, 1, 1, 2, 2, 3, 4]))],
        plant=torsio.PlantParams(
            counts_per_rev=r.choice([4096, 8192, 8192, 32768]),
            motor_time_constant_s=r.choice([4.4e-5, 1.6e-4]),
        ),
        law=r.choice(["paper", "motor_only", "compensated"]),
        rate_hz=r.choice([1e3, 1e3, 4e3, 1e4, 2e4]),
    )


def warning_of(case: Case) -> str:
    """Play it; give what was warned of, or nothing."""
    options = torsio.EmulatorOptions(control_rate_hz=case.rate_hz)
    with (
        torsio.open("emulated", emulator=options) as knob,
        warnings.catch_warnings(record=True) as caught,
    ):
        warnings.simplefilter("always")
        knob.configure(case.plant.matching_config())
        knob.configure(case.control)
        knob.play(case.scene)
    swings = [each.message for each in caught if each.category is torsio.StiffnessWarning]
    return "".join(map(str, swings))


def motion_of(
    case: Case, pushes: Sequence[tuple[float, float]] = tuple(PUSHES)
) -> tuple[float, float]:
    """Push the knob; give how far it still swings long after, peak to peak, the worst push's.

    And the motor's torque above 20 Hz. A knob that runs on one way, as one does that a weight or a
    curve drives, does not swing.
    """
    runs = [
        LoopOptions(
            scene=case.scene,
            plant=case.plant,
            control=case.control,
            control_period_ns=round(1e9 / case.rate_hz),
            hand=torsio.TorqueHand(torque_nm=weight_nm) if weight_nm else torsio.NoHand(),
            initial=InitialState(speed_rad_s=speed),
        )
        for speed, weight_nm in pushes
    ]
    every = round(case.rate_hz / 1e3)
    widest = loudest = 0.0
    for rows in simulate_many(runs, duration_s=_TRIED_S, record_every=every):
        tail = rows[rows["time_s"] >= _TRIED_S - _TAIL_S]
        speed = tail["speed_rad_s"]
        if abs(np.mean(speed)) <= 0.5 * math.sqrt(np.mean(speed**2)):
            widest = max(widest, float(np.ptp(tail["angle_rad"])))
            loudest = max(loudest, float(vibration_nm(tail["motor_torque_nm"], 1e3)))
    return widest, loudest


def main(arguments: Sequence[str]) -> None:
    """Print a line for each mistake, and how many there are."""
    scenes, first = (int(each) for each in [*arguments, *("400", "0")[len(arguments) :]])
    told = dict.fromkeys(("swing", "unwarned", "hum", "hum_unwarned", "rest", "warned"), 0)
    for seed in range(first, first + scenes):
        case = random_case(seed)
        warned, (wide, loud) = bool(warning_of(case)), motion_of(case)
        kind, mistake = "rest", "warned"
        if wide > AT_REST_RAD:
            kind, mistake = "swing", "unwarned"
        elif loud > VIBRATION_NM:
            kind, mistake = "hum", "hum_unwarned"
        told[kind] += 1
        if warned == (kind == "rest"):
            told[mistake] += 1
            moved = {"swing_rad": wide, "vibration_nm": loud}
            print(json.dumps({"seed": seed, "mistake": mistake, **moved}), flush=True)
    print(json.dumps({"first_seed": first, **told}))


if __name__ == "__main__":
    main(sys.argv[1:])
