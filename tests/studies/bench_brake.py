"""The effect of a driven brake coil on a wall, as JSON lines: gap, exit, sensor, and buzz.

``./dev bench brake`` runs the paper's push into a wall of 30 mN m a degree on a plant with
electrics, at 20 kHz with 32,768 counts. A line tells for one law and one way to drive the coil

- ``torque_gap_nm``: the most that the wall lacks on the way out;
- ``exit_error``: the error on the way out, root of the mean square as a share of the peak;
- ``exit_s``: when the knob has left a wall of 25 mN m a degree into which a weight had pulled it,
  after the string was cut; none if friction holds it there;
- ``sensor_nm``: the error of the sensed torque, root of the mean square;
- ``stable_nm_per_rad``: up to where a spring that catches the knob comes to rest, the worst of five
  speeds, in steps of 6 %; what is stiffer buzzes;
- ``fall_ms``: how long the brake takes from 80 mN m to a tenth of it once it is told to let go;
- ``left_nm``: what is left of them then in a brake with hysteresis.

A lag of 60 ms is the coil's own. A shorter one is made by overdriving it where it rises and
reversing it where it falls, as far as the supply goes.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace

import numpy as np

from tests.bench.bench_stiffness import SPEEDS_RAD_S, TRIED_S, Array, islands, springs, stable_to
from torsio import BoardConfig, BrakeHysteresis, Electrics, PlantParams, PrescribedMotion
from torsio.closed_loop import ClosedLoop, LoopOptions, simulate, simulate_many
from torsio.printed.config import Law
from torsio_studies.paper import runs

RATE_HZ = 20e3
COUNTS = 32768
STEP = 1.06  # from spring to spring
PLANT = PlantParams(electrics=Electrics(), counts_per_rev=COUNTS)


@dataclass(frozen=True)
class Way:
    """A way to drive the coil."""

    name: str
    lag_s: float
    inductance_h: float = 2.4


WAYS = (
    Way("voltage alone", 60e-3, 0.0),
    Way("driven, 60 ms", 60e-3),
    Way("driven, 30 ms", 30e-3),
    Way("driven, 15 ms", 15e-3),
    Way("driven, 5 ms", 5e-3),
)


def _told(options: LoopOptions, way: Way) -> LoopOptions:
    actuator = replace(PLANT.matching_config(), brake_time_constant_s=way.lag_s)
    board = BoardConfig(brake_inductance_h=way.inductance_h)
    return replace(options, plant=PLANT, actuator=actuator, board=board)


def fall_s(way: Way) -> float:
    """How long the brake takes to let go of nine tenths of 80 mN m."""
    still = PrescribedMotion(angle_rad=[(0.0, 0.0)])
    loop = ClosedLoop(_told(LoopOptions(hand=still, control_period_ns=50_000), way))
    loop.hold_command(brake_command_nm=80e-3)
    loop.run(duration_s=0.6, record_every=1000)
    loop.hold_command()
    held = loop.run(duration_s=0.6)["brake_capacity_nm"] - PLANT.brake_drag_nm
    return 50e-6 * float(np.argmax(held < 0.1 * held[0]))


def left_nm(way: Way) -> float:
    """The torque that a brake with hysteresis still holds half a second after 80 mN m."""
    plant = replace(PLANT, brake_hysteresis=BrakeHysteresis())
    still = PrescribedMotion(angle_rad=[(0.0, 0.0)])
    told = _told(LoopOptions(hand=still, control_period_ns=50_000), way)
    loop = ClosedLoop(replace(told, plant=plant))
    loop.hold_command(brake_command_nm=80e-3)
    loop.run(duration_s=0.6, record_every=1000)
    loop.hold_command()
    held = loop.run(duration_s=0.6, record_every=1000)["brake_capacity_nm"]
    return float(held[-1]) - PLANT.brake_drag_nm


def rest(law: Law, way: Way, stiffness: Array) -> list[bool]:
    """The springs that come to rest at every speed."""
    cases = []
    for k in stiffness:
        one = _told(runs.bounce_options(float(k), law, rate_hz=RATE_HZ), way)
        assert one.spin_up is not None
        cases += [replace(one, spin_up=replace(one.spin_up, speed_rad_s=v)) for v in SPEEDS_RAD_S]
    rows = simulate_many(cases, duration_s=TRIED_S, record_every=20)
    calm = np.reshape([runs.count_bounces(one).at_rest for one in rows], (len(stiffness), -1))
    return [all(row) for row in calm]


def stable(law: Law, way: Way) -> tuple[float, list[tuple[float, float]]]:
    """Up to where springs come to rest, and what else does."""
    stiffness = springs(STEP)
    calm = rest(law, way, stiffness)
    return stable_to(stiffness, calm), islands(stiffness, calm)


def pushed(law: Law, way: Way) -> runs.Push:
    """Push into a wall of 30 mN m a degree and come out again."""
    wall = math.degrees(30e-3)
    options = _told(runs.push_options(wall, law, rate_hz=RATE_HZ), way)
    return runs.measure_push(simulate(options, duration_s=runs.PUSH_DURATION_S), wall)


def exit_s(law: Law, way: Way) -> float | None:
    """When the knob has left a wall after the string of a weight was cut."""
    options = _told(runs.cut_options(math.degrees(25e-3), law), way)
    _, cut = runs.run_cut(replace(options, control_period_ns=round(1e9 / RATE_HZ)))
    return cut.exit_s


def main() -> None:
    """Print a line for each law and way."""
    laws: tuple[Law, ...] = ("paper", "compensated", "calibrated")
    for law in laws:
        for way in WAYS:
            push = pushed(law, way)
            stiffness, found = stable(law, way)
            line = {
                "law": law,
                "coil": way.name,
                "torque_gap_nm": float(f"{push.torque_gap_nm:.3g}"),
                "exit_error": float(f"{push.tracking_rms_out:.3g}"),
                "exit_s": exit_s(law, way),
                "sensor_nm": float(f"{push.sensor_rms_nm:.3g}"),
                "stable_nm_per_rad": round(stiffness, 1),
                "islands": found,
                "fall_ms": round(1e3 * fall_s(way), 1),
                "left_nm": float(f"{left_nm(way):.2g}"),
            }
            print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
