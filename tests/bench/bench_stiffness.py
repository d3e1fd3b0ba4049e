"""How stiff a spring stays stable on each board's current loop, as JSON lines.

``./dev bench stiffness`` spins the knob up, lets a virtual spring catch it and looks whether it
comes to rest, for springs from 2 to 300 N m/rad in steps of 3 %, at five speeds from 6 to 22 rad/s.
A line tells for one current loop and one encoder

- ``stable_nm_per_rad``: up to where no spring swings at any speed;
- ``silent_nm_per_rad``: up to where no finger feels the motor of a knob at rest, either;
- ``islands``: what else comes to rest at every speed, as pairs of first and last spring;
- ``by_speed_nm_per_rad``: the first number for each speed alone;

and for each loop what it is like: ``lag_us``, by which the torque trails a small step;
``bandwidth_hz``, where 3 dB are lost; ``full_rise_us``, in which a step to the motor's limit, for
which the supply has too few volts, gets to nine tenths of it; ``noise_nm``, the standard deviation
of a torque that is held; ``off_nm_per_rad``, the first number at 32,768 counts with a winding
whose resistance and inductance are a third off, the worst of four; ``off_bandwidth_hz``, the
least and the most bandwidth of these four; and ``sagging_nm_per_rad``, the first number at as many
counts with 12 V that are 9.2, or have 1 ohm before them, the worse of both. Loops that are a lag,
of no board, have ``predicted_nm_per_rad``, which is what (8) of docs/explanation/theory.md says.

With ``quick`` as argument it takes a coarse scan of one encoder; with names of boards, only those;
with a number, springs that are so many steps stiffer, for a limit that depends on the grid.
"""

from __future__ import annotations

import itertools
import json
import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from torsio import (
    BoardConfig,
    ControlConfig,
    Electrics,
    PlantParams,
    PrescribedMotion,
    Spring,
)
from torsio.closed_loop import ClosedLoop, LoopOptions, SpinUp, simulate_many
from torsio.perception import VIBRATION_NM, vibration_nm

Array = npt.NDArray[np.float64]

SPEEDS_RAD_S = (6.0, 10.0, 14.0, 18.0, 22.0)
COUNTS = (8192, 32768, 131072)
TRIED_S = 2.0
"""Some of those that come to rest do so only after a second."""
AT_REST_RAD = 3e-3
"""Less motion than this, peak to peak over the last fifth of a second, is no oscillation."""


@dataclass(frozen=True)
class Loop:
    """A board's control rate, its electrics, and what it takes them for."""

    name: str
    board: str
    rate_hz: float
    electrics: Electrics | None = None
    config: BoardConfig | None = None
    motor_time_constant_s: float = 0.0
    delay_ticks: int = 0

    def plant(self, counts: int = 8192) -> PlantParams:
        return PlantParams(
            counts_per_rev=counts,
            electrics=self.electrics,
            motor_time_constant_s=self.motor_time_constant_s,
        )


LAG_S = PlantParams().motor_time_constant_s
FAST = Electrics()
SIMPLE = Electrics(predictive=False, current_period_s=0.0)
HALF_KILOHERTZ = BoardConfig(current_bandwidth_hz=500)
LOOPS = (
    Loop("predictive at 40 kHz", "pico2", 20e3, FAST),
    Loop("simple, 500 Hz", "pico2", 20e3, SIMPLE, HALF_KILOHERTZ),
    Loop("simple, 1 kHz", "pico", 10e3, replace(SIMPLE, output_delay_s=50e-6)),
    Loop("simple, 500 Hz", "pico", 10e3, replace(SIMPLE, output_delay_s=50e-6), HALF_KILOHERTZ),
    *(
        Loop(f"a lag of 44 us{', a tick of delay' if delay else ''}", "none", rate_hz,
             motor_time_constant_s=LAG_S, delay_ticks=delay)
        for rate_hz, delay in ((10e3, 0), (10e3, 1), (20e3, 0), (20e3, 1), (1e3, 0))
    ),
)  # fmt: skip


def springs(step: float) -> Array:
    """Stiffnesses from 2 to 300 N m/rad, each so much larger than the one before."""
    steps = math.ceil(math.log(150.0) / math.log(step))
    return np.array([2.0 * step**i for i in range(steps + 1)])


def _options(loop: Loop, counts: int, stiffness: float, speed: float) -> LoopOptions:
    return LoopOptions(
        scene=Spring(angle_rad=0.0, stiffness_nm_per_rad=stiffness, torque_limit_nm=100.0),
        plant=loop.plant(counts),
        board=loop.config,
        control_period_ns=round(1e9 / loop.rate_hz),
        delay_ticks=loop.delay_ticks,
        spin_up=SpinUp(motor_command_nm=40e-3, speed_rad_s=speed),
    )


def rests(
    loop: Loop, counts: int, stiffness: Sequence[float] | Array, most_nm: float = math.inf
) -> npt.NDArray[np.bool_]:
    """Whether the knob swings in no spring after that time, shape (springs, speeds).

    Nor may its motor vibrate by `most_nm`.
    """
    runs = [_options(loop, counts, k, v) for k in stiffness for v in SPEEDS_RAD_S]
    rows = simulate_many(runs, duration_s=TRIED_S, record_every=round(loop.rate_hz / 1000.0))
    tails = (one[one["time_s"] >= TRIED_S - 0.2] for one in rows)
    calm = [
        float(np.ptp(tail["angle_rad"])) < AT_REST_RAD
        and bool(vibration_nm(tail["motor_torque_nm"], 1000.0) < most_nm)
        for tail in tails
    ]
    return np.reshape(calm, (len(stiffness), len(SPEEDS_RAD_S)))


def stable_to(stiffness: Array, calm: Iterable[bool]) -> float:
    """Up to where every one of a rising series comes to rest."""
    passed = itertools.takewhile(lambda one: one[1], zip(stiffness, calm, strict=True))
    return float(max((k for k, _ in passed), default=0.0))


def islands(stiffness: Array, calm: Sequence[bool]) -> list[tuple[float, float]]:
    """Springs that rest although a softer one does not."""
    found = []
    for is_calm, group in itertools.groupby(zip(stiffness, calm, strict=True), lambda x: x[1]):
        values = [round(float(k), 1) for k, _ in group]
        if is_calm:
            found.append((values[0], values[-1]))
    return found[1:] if calm[0] else found


def step_response(loop: Loop, torque_nm: float = 5e-3) -> tuple[Array, Array]:
    """Time after a step of the command, small or not, and the share that the torque has reached."""
    # The control period is the current loop's, the only loop that counts here.
    fast = loop.electrics is not None and loop.electrics.predictive
    period_ns = 25_000 if fast else round(1e9 / loop.rate_hz)
    electrics = loop.electrics and replace(loop.electrics, sensor_noise_v=0.0, sensor_bits=24)
    quiet = replace(loop, electrics=electrics)
    loop_ = ClosedLoop(
        LoopOptions(
            plant=quiet.plant(), board=loop.config, control_period_ns=period_ns,
            hand=PrescribedMotion(angle_rad=[(0.0, 0.0)]),
        )
    )  # fmt: skip
    loop_.hold_command()
    loop_.run(duration_s=1e-3)
    loop_.hold_command(motor_command_nm=torque_nm)
    torque = loop_.run(duration_s=20e-3)["motor_torque_nm"]
    time_s = np.array([1e-9 * period_ns * i for i in range(len(torque))])
    # In the end it goes to and fro between two steps of the PWM.
    return time_s, np.asarray(torque / np.mean(torque[len(torque) // 2 :]))


def bandwidth_hz(time_s: Array, response: Array) -> float:
    """Where a loop with this step response has lost 3 dB."""
    # Straight lines between the points: their slopes are the pulse response.
    slope, step = np.diff(response), time_s[1]
    frequency = np.arange(10.0, 0.5 / step, 10.0)
    middle = time_s[:-1] + 0.5 * step
    gain = np.abs(np.exp(-2j * np.pi * np.outer(frequency, middle)) @ slope)
    gain *= np.sinc(frequency * step)
    below = np.flatnonzero(gain < math.sqrt(0.5))
    return float(frequency[below[0]]) if len(below) else float(frequency[-1])


def lag_s(time_s: Array, response: Array) -> float:
    """By how much a torque with this step response trails."""
    return float(time_s[1] * (np.sum(1 - response) - 0.5 * (1 - response[0])))


def rise_s(loop: Loop) -> float:
    """How long a step to the motor's limit takes to nine tenths of it."""
    time_s, response = step_response(loop, loop.plant().motor_limit_nm)
    above = int(np.flatnonzero(response >= 0.9)[0])
    share = (0.9 - response[above - 1]) / (response[above] - response[above - 1]) if above else 1.0
    return float(time_s[above] - (1 - share) * time_s[1])


def noise_nm(loop: Loop) -> float:
    """Standard deviation of a torque of 40 mN m that is held."""
    one = ClosedLoop(
        LoopOptions(
            plant=loop.plant(), board=loop.config, seed=1,
            control_period_ns=round(1e9 / loop.rate_hz),
            hand=PrescribedMotion(angle_rad=[(0.0, 0.0)]),
        )
    )  # fmt: skip
    one.hold_command(motor_command_nm=40e-3)
    one.run(duration_s=0.1)
    return float(np.std(one.run(duration_s=0.5)["motor_torque_nm"]))


def wrong_windings(loop: Loop) -> list[Loop]:
    """Give the same loop with windings that are not what the board takes them for."""
    assert loop.electrics is not None
    return [
        replace(
            loop,
            config=loop.config or BoardConfig(),
            electrics=replace(
                loop.electrics,
                winding_resistance_ohm=2.5 * resistance,
                winding_inductance_h=1.5e-3 * inductance,
            ),
        )
        for resistance, inductance in itertools.product((0.7, 1.3), repeat=2)
    ]


def weak_supplies(loop: Loop) -> list[Loop]:
    """Give the same loop with supplies that are less than the board takes its own for."""
    assert loop.electrics is not None
    supplies = (
        replace(loop.electrics, supply_v=9.2),
        replace(loop.electrics, supply_resistance_ohm=1.0),
    )
    config = loop.config or BoardConfig()
    return [replace(loop, config=config, electrics=electrics) for electrics in supplies]


def least_nm_per_rad(loops: Iterable[Loop], stiffness: Array) -> float:
    """The least stable stiffness of these."""
    calm = (rests(loop, 32768, stiffness) for loop in loops)
    return min(stable_to(stiffness, [all(row) for row in one]) for one in calm)


def predicted_nm_per_rad(loop: Loop) -> float:
    """Equation (8) of docs/explanation/theory.md, for a loop that is a lag."""
    plant, beta = loop.plant(), ControlConfig().beta
    late_s = (0.5 + loop.delay_ticks) / loop.rate_hz + loop.motor_time_constant_s
    swing = math.sqrt(plant.knob_inertia_kg_m2) / plant.motor_limit_nm
    friction = 0.8 * 4.0 * plant.knob_coulomb_nm / math.pi * swing

    def stiffest(late: float, carried: float) -> float:
        losses = plant.knob_viscous_nm_s_per_rad + late * carried
        root = (friction + math.sqrt(friction**2 + 4.0 * late * losses)) / (2.0 * late)
        return root * root

    # The brake carries its share, but never more than the shaft's spring winds up.
    shaft = plant.shaft_stiffness_nm_per_rad
    found = stiffest(late_s, shaft)
    if beta * found >= shaft:
        return found
    return min(stiffest(late_s * (1.0 - beta), 0.0), shaft / beta)


def main(arguments: list[str]) -> None:
    """Print a line for each loop and encoder, and one for each loop."""
    quick = "quick" in arguments
    shifts = {one for one in arguments if one[0].isdigit()}
    boards = set(arguments) - {"quick"} - shifts or {loop.board for loop in LOOPS}
    step = 1.2 if quick else 1.03
    stiffness = springs(step) * step ** float(min(shifts, default=0))
    for loop in (loop for loop in LOOPS if loop.board in boards):
        known = {"loop": loop.name, "board": loop.board, "rate_hz": loop.rate_hz}
        for counts in (32768,) if quick else COUNTS:
            calm = rests(loop, counts, stiffness)
            worst = [all(row) for row in calm]
            silent = [all(row) for row in rests(loop, counts, stiffness, VIBRATION_NM)]
            line = {
                **known,
                "counts_per_rev": counts,
                "stable_nm_per_rad": round(stable_to(stiffness, worst), 1),
                "silent_nm_per_rad": round(stable_to(stiffness, silent), 1),
                "islands": islands(stiffness, worst),
                "by_speed_nm_per_rad": [round(stable_to(stiffness, c), 1) for c in calm.T],
            }
            print(json.dumps(line), flush=True)
        time_s, response = step_response(loop)
        line = {
            **known,
            "lag_us": round(1e6 * lag_s(time_s, response), 1),
            "bandwidth_hz": round(bandwidth_hz(time_s, response)),
            "full_rise_us": round(1e6 * rise_s(loop)),
            "noise_nm": float(f"{noise_nm(loop):.2g}"),
        }
        if loop.electrics is None:
            line["predicted_nm_per_rad"] = round(predicted_nm_per_rad(loop), 1)
        elif not quick:
            bands = [bandwidth_hz(*step_response(wrong)) for wrong in wrong_windings(loop)]
            line["off_bandwidth_hz"] = [round(min(bands)), round(max(bands))]
            for name, loops in (
                ("off_nm_per_rad", wrong_windings(loop)),
                ("sagging_nm_per_rad", weak_supplies(loop)),
            ):
                line[name] = round(least_nm_per_rad(loops, springs(1.06)), 1)
        print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
