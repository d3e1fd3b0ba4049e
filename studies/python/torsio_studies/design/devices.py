"""The worth of each choice of a designer, from thousands of simulated devices.

Two maps on regular grids, and a sample that fills the space of all seven parameters evenly. Every
device is simulated on its own, so that the work can be spread and interrupted as one likes:
`design_store` keeps what is done, `design_run` spreads the rest. docs/results/design.md has the
keys of the results.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import KW_ONLY, asdict, dataclass, fields, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from torsio.closed_loop import InitialState, LoopOptions, simulate
from torsio.common import checks
from torsio.demos import wall
from torsio.printed.config import ControlConfig, Law
from torsio.printed.hands import PrescribedMotion, TorqueHand
from torsio.printed.plant import PlantParams
from torsio.printed.scenes import Spring, Wall
from torsio.telemetry import Record
from torsio_studies import exits
from torsio_studies.actuators import trials
from torsio_studies.exits import Exit
from torsio_studies.paper.critical import critical_torque
from torsio_studies.paper.runs import ideal_nm, rendered_nm

Array = npt.NDArray[np.float64]

WALL_NM_PER_RAD = 30.0 / trials.NM_PER_RAD
SOFTEST_NM_PER_RAD, STIFFEST_NM_PER_RAD = 0.5, 200.0
FRICTION_NM = 8e-3  # knob and released brake of every device
EVALUATION: Final = 2
"""Raise it when `evaluate` gives other numbers: results of different ones are never mixed."""


@dataclass(frozen=True)
class Design:
    """Choices of a designer. Everything else is the default device."""

    _: KW_ONLY
    beta: float = ControlConfig().beta
    motor_limit_nm: float = PlantParams().motor_limit_nm
    brake_limit_nm: float = PlantParams().brake_limit_nm
    shaft_stiffness_nm_per_rad: float = PlantParams().shaft_stiffness_nm_per_rad
    control_rate_hz: float = 1e9 / LoopOptions().control_period_ns
    counts_per_rev: int = PlantParams().counts_per_rev
    knob_inertia_kg_m2: float = PlantParams().knob_inertia_kg_m2

    def __post_init__(self) -> None:
        """Refuse what no device can have, before hours are spent on others."""
        checks.number("beta", self.beta, 0.0, 1.0)
        for one in fields(self):
            if one.name != "beta":
                checks.positive(one.name, getattr(self, one.name))


@dataclass(frozen=True)
class Range:
    """Where the sample takes a parameter from."""

    title: str
    low: float
    high: float
    logarithmic: bool

    def at(self, share: float) -> float:
        """Give the value at a share of the way, 0 to 1."""
        if self.logarithmic:
            return self.low * math.exp(share * math.log(self.high / self.low))
        return self.low + share * (self.high - self.low)


SPACE: Final = {
    "beta": Range("brake's share β", 0.0, 1.0, False),
    "motor_limit_nm": Range("motor torque", 30e-3, 200e-3, True),
    "brake_limit_nm": Range("brake torque", 30e-3, 300e-3, True),
    "shaft_stiffness_nm_per_rad": Range("shaft stiffness", 0.5, 20.0, True),
    "control_rate_hz": Range("control rate", 500.0, 10_000.0, True),
    "counts_per_rev": Range("encoder counts", 1024, 65_536, True),
    "knob_inertia_kg_m2": Range("knob inertia", 2e-5, 5e-4, True),
}


@dataclass(frozen=True)
class Measures:
    """Abilities of a device.

    Attributes
    ----------
    stable_stiffness_nm_per_rad
        Of the softest virtual spring that keeps swinging after a spin; the stiffest tried if none
        does.
    critical_torque_nm
        Largest torque that the device presses and releases, in a wall of 30 mN m/deg, with a motor
        that never saturates; found by simulation.
    critical_formula_nm
        The same from the formula of docs/explanation/theory.md.
    tracking_in, tracking_out
        RMS error in that wall, as a share of the peak.
    sensor_rms_nm
        RMS error of the sensed torque of the shaft there.
    exit_time_s
        From the cut of a string until the knob has left a wall; NaN if it is still inside at the
        end.
    stuck_torque_nm
        Torque that the wall then asks for; 0 outside.
    stays
        1 if that is more than friction can hold, else 0.
    seconds
        Of one core that it took to find all this.
    """

    stable_stiffness_nm_per_rad: float
    critical_torque_nm: float
    critical_formula_nm: float
    tracking_in: float
    tracking_out: float
    torque_gap_nm: float
    sensor_rms_nm: float
    exit_time_s: float
    stuck_torque_nm: float
    stays: float
    seconds: float


@dataclass(frozen=True)
class Batch:
    """Designs that are computed and stored together."""

    group: str
    index: int
    designs: tuple[Design, ...]
    law: Law = "paper"


def critical_torque_nm(design: Design, wall_nm_per_rad: float) -> float:
    """Give the largest torque that motor and brake can render, by docs/explanation/theory.md."""
    return critical_torque(
        wall_nm_per_rad,
        design.beta,
        shaft=design.shaft_stiffness_nm_per_rad,
        motor=design.motor_limit_nm,
        brake=design.brake_limit_nm,
    )


def _device(design: Design, law: Law) -> LoopOptions:
    return LoopOptions(
        plant=PlantParams(
            knob_inertia_kg_m2=design.knob_inertia_kg_m2,
            shaft_stiffness_nm_per_rad=design.shaft_stiffness_nm_per_rad,
            motor_limit_nm=design.motor_limit_nm,
            brake_limit_nm=design.brake_limit_nm,
            counts_per_rev=design.counts_per_rev,
        ),
        control=ControlConfig(law=law, beta=design.beta),
        control_period_ns=round(1e9 / design.control_rate_hz),
    )


def _run(options: LoopOptions, duration_s: float) -> Record:
    """Simulate, with about a row a millisecond."""
    every = max(1, round(1_000_000 / options.control_period_ns))
    return simulate(options, duration_s=duration_s, record_every=every)


def _is_stable(device: LoopOptions, stiffness_nm_per_rad: float) -> bool:
    spring = replace(device, scene=Spring(stiffness_nm_per_rad=stiffness_nm_per_rad))
    spins = (
        replace(spring, initial=InitialState(speed_rad_s=speed)) for speed in trials.SPINS_RAD_S
    )
    return all(trials.comes_to_rest(_run(spin, trials.SPIN_S)) for spin in spins)


def _saturates(device: LoopOptions, peak_nm: float) -> bool:
    deepest_rad = peak_nm / WALL_NM_PER_RAD
    path = [(0.0, 0.0), (0.75, deepest_rad), (0.85, deepest_rad), (1.6, 0.0)]
    push = replace(
        device,
        scene=Wall(angle_rad=0.0, stiffness_nm_per_rad=WALL_NM_PER_RAD),
        hand=PrescribedMotion(angle_rad=path),
    )
    return bool(np.any(simulate(push, duration_s=1.6)["motor_saturated"]))


def _critical_torque(device: LoopOptions) -> float:
    low, high = 0.0, 1.25 * (device.plant.motor_limit_nm + device.plant.brake_limit_nm)
    for _ in range(7):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _saturates(device, middle) else (middle, high)
    return low


def _visit_wall(device: LoopOptions) -> tuple[trials.WallMeasures, float]:
    visit = replace(
        device,
        scene=Wall(angle_rad=wall.WALL_ANGLE_RAD, stiffness_nm_per_rad=WALL_NM_PER_RAD),
        hand=wall.hand(WALL_NM_PER_RAD),
    )
    log = _run(visit, wall.EMULATED_DURATION_S)
    as_trial = {
        "ideal_torque_nm": ideal_nm(log, WALL_NM_PER_RAD, wall.WALL_ANGLE_RAD),
        "rendered_torque_nm": rendered_nm(log),
        "time_s": log["time_s"],
    }
    sensor_error = log["sensed_spring_torque_nm"] - log["spring_torque_nm"]
    return trials.measure_wall(as_trial, WALL_NM_PER_RAD), wall.rms(sensor_error)


def _cut_string(device: LoopOptions) -> Exit:
    stiffness = trials.CUT_WALL_MNM_PER_DEG / trials.NM_PER_RAD
    weight = trials.CUT_TORQUE_NM
    cut = replace(
        device,
        scene=Wall(angle_rad=0.0, stiffness_nm_per_rad=stiffness),
        hand=TorqueHand(torque_nm=[(0, 0), (0.5, weight), (1, weight), (1, 0)]),
    )
    log = _run(cut, 2.0)
    return exits.measure_exit(
        log["time_s"],
        -ideal_nm(log, stiffness, 0.0),
        let_go_s=trials.CUT_S,
        friction_nm=FRICTION_NM,
        count_nm=stiffness * 2 * math.pi / device.plant.counts_per_rev,
    )


def evaluate(design: Design, law: Law = "paper") -> Measures:
    """Simulate one device in all scenes."""
    begin = time.thread_time()  # other processes on this core do not count
    device = _device(design, law)
    limit = trials.stable_limit(
        lambda stiffness: _is_stable(device, stiffness),
        softest=SOFTEST_NM_PER_RAD,
        stiffest=STIFFEST_NM_PER_RAD,
        coarse_steps=15,
        tolerance=0.06,
    )
    visit, sensor_rms = _visit_wall(device)
    left = _cut_string(device)
    return Measures(
        stable_stiffness_nm_per_rad=STIFFEST_NM_PER_RAD if limit is None else limit,
        critical_torque_nm=_critical_torque(device),
        critical_formula_nm=critical_torque_nm(design, WALL_NM_PER_RAD),
        tracking_in=visit.tracking_in,
        tracking_out=visit.tracking_out,
        torque_gap_nm=visit.torque_gap_nm,
        sensor_rms_nm=sensor_rms,
        exit_time_s=math.nan if left.exit_s is None else left.exit_s,
        stuck_torque_nm=left.stuck_torque_nm,
        stays=float(left.outcome == "stays"),
        seconds=time.thread_time() - begin,
    )


def evaluate_batch(batch: Batch) -> list[dict[str, float]]:
    """Simulate the devices of a batch; a row each, parameters and measures."""
    return [asdict(design) | asdict(evaluate(design, batch.law)) for design in batch.designs]


def sample_design(index: int) -> Design:
    """Give device `index` of the sample.

    Each depends on its number only, and the first n fill the space evenly for every n: the additive
    sequence of Roberts (2018), whose steps are powers of the root of x**8 = x + 1.
    """
    root = 1.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (len(SPACE) + 1))
    values: dict[str, float] = {}
    for power, (name, span) in enumerate(SPACE.items(), start=1):
        values[name] = span.at(math.fmod(0.5 + (index + 1) * root**-power, 1.0))
    return _design(**values)


def _design(**values: float) -> Design:
    counts = round(values.pop("counts_per_rev", Design.counts_per_rev))
    return Design(**values, counts_per_rev=counts)


def map_designs(x: str, y: str, side: int) -> list[Design]:
    """Give a grid of two parameters, row by row of `y`, the others at their defaults."""
    shares = np.linspace(0.0, 1.0, side)
    return [
        _design(**{x: SPACE[x].at(float(a)), y: SPACE[y].at(float(b))})
        for b in shares
        for a in shares
    ]


MAPS: Final = {
    "rate": ("shaft_stiffness_nm_per_rad", "control_rate_hz"),
    "beta": ("shaft_stiffness_nm_per_rad", "beta"),
}


def batches(devices: int, side: int, law: Law, size: int) -> Iterator[Batch]:
    """Cut all the work into batches of at most `size` devices."""
    groups = {"sample": [sample_design(i) for i in range(devices)]}
    for name, (x, y) in MAPS.items():
        groups[f"map_{name}_{side}"] = map_designs(x, y, side)
    for group, designs in groups.items():
        for begin in range(0, len(designs), size):
            yield Batch(group, begin // size, tuple(designs[begin : begin + size]), law)


def columns() -> list[str]:
    """Give the columns of the results, in order."""
    return [field.name for kind in (Design, Measures) for field in fields(kind) if field.init]
