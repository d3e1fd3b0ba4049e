"""The paper's experiments on the emulated actuator, each a function that gives rows and numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from torsio import perception
from torsio.closed_loop import ClosedLoop, LoopOptions, SpinUp, simulate
from torsio.common import checks
from torsio.demos.wall import rms
from torsio.perception import VIBRATION_NM, vibration_nm
from torsio.printed.config import ControlConfig, Law
from torsio.printed.hands import ImpedanceHand, TorqueHand
from torsio.printed.plant import PlantParams, ShaftHardening
from torsio.printed.scenes import Spring, Wall
from torsio.telemetry import Record
from torsio_studies import exits
from torsio_studies.exits import Outcome

Array = npt.NDArray[np.float64]

SHAFT_NM_PER_RAD = PlantParams().shaft_stiffness_nm_per_rad
MOTOR_NM = PlantParams().motor_limit_nm
BRAKE_NM = PlantParams().brake_limit_nm
COUNT_RAD = 2.0 * math.pi / PlantParams().counts_per_rev


def per_degree(millinewton_metres: float) -> float:
    """Stiffness in N m/rad from mN m per degree."""
    return math.degrees(1e-3 * millinewton_metres)


# Scenario 1: how stiff before it becomes unstable? ------------------------------------------------

RELEASE_SPEED_RAD_S = 18.0
SPIN_UP_NM = 40e-3
AT_REST_RAD = 3e-3
"""Less motion than this, peak to peak over the last fifth of a second, is no oscillation."""


def bounce_options(
    stiffness: float,
    law: Law = "paper",
    *,
    rate_hz: float = 1000.0,
    delay_ticks: int = 0,
    counts_per_rev: int = PlantParams().counts_per_rev,
    beta: float = 0.5,
) -> LoopOptions:
    """Spin the knob up, let go, and let a virtual spring catch it."""
    return LoopOptions(
        scene=Spring(angle_rad=0.0, stiffness_nm_per_rad=stiffness, torque_limit_nm=100.0),
        plant=PlantParams(counts_per_rev=counts_per_rev),
        control=ControlConfig(law=law, beta=beta),
        control_period_ns=round(1e9 / rate_hz),
        delay_ticks=delay_ticks,
        spin_up=SpinUp(motor_command_nm=SPIN_UP_NM, speed_rad_s=RELEASE_SPEED_RAD_S),
    )


@dataclass(frozen=True)
class Bounces:
    """Result of the second after the release."""

    crossings: int
    oscillation_rad: float
    """Peak to peak in the last fifth of a second."""
    vibration_nm: float
    """Root mean square of the motor's torque then, above 20 Hz."""

    @property
    def at_rest(self) -> bool:
        """Whether the oscillation has died away, and no finger feels the motor."""
        return self.oscillation_rad < AT_REST_RAD and self.vibration_nm < VIBRATION_NM


def count_bounces(rows: Record) -> Bounces:
    """Count how often the knob went through the middle of the spring."""
    angle = rows["angle_rad"]
    side = np.sign(angle[np.abs(angle) > COUNT_RAD])
    tail = rows[rows["time_s"] >= rows["time_s"][-1] - 0.2]
    rate_hz = (len(tail) - 1) / float(np.ptp(tail["time_s"]))
    return Bounces(
        int(np.count_nonzero(side[1:] != side[:-1])),
        float(np.ptp(tail["angle_rad"])),
        float(vibration_nm(tail["motor_torque_nm"], rate_hz)),
    )


def largest_stable(stiffness: Array, bounces: Sequence[Bounces]) -> float:
    """Give the stiffness up to which every one of a rising series comes to rest."""
    stable = 0.0
    for value, outcome in zip(stiffness, bounces, strict=True):
        if not outcome.at_rest:
            break
        stable = float(value)
    return stable


# Scenario 2: into a wall, and out -----------------------------------------------------------------

WALL_RAD = 0.05
PUSH_S, HOLD_S, PULL_S = 1.0, 0.2, 1.0
PEAK_NM = 75e-3
# A hand that goes where it means to: it yields by 7.5 mrad under the peak torque.
HAND_NM_PER_RAD, HAND_NM_S_PER_RAD, HAND_KG_M2 = 10.0, 10e-3, 1e-4


def push_options(
    stiffness: float,
    law: Law = "paper",
    *,
    beta: float = 0.5,
    rate_hz: float = 1000.0,
    counts_per_rev: int = PlantParams().counts_per_rev,
    pull_s: float = PULL_S,
    peak_nm: float = PEAK_NM,
    plant: PlantParams | None = None,
    wall_rad: float = WALL_RAD,
) -> LoopOptions:
    """Push into a wall until it asks for the peak torque, hold, and come out."""
    checks.positive("stiffness", stiffness)
    plant = plant or PlantParams(counts_per_rev=counts_per_rev)
    give_rad = (peak_nm + plant.knob_coulomb_nm) / HAND_NM_PER_RAD
    deepest = wall_rad + peak_nm / stiffness + give_rad
    arrive, leave = PUSH_S, PUSH_S + HOLD_S
    return LoopOptions(
        scene=Wall(angle_rad=wall_rad, stiffness_nm_per_rad=stiffness),
        hand=ImpedanceHand(
            intended_angle_rad=[(0, 0), (arrive, deepest), (leave, deepest), (leave + pull_s, 0)],
            stiffness_nm_per_rad=HAND_NM_PER_RAD,
            damping_nm_s_per_rad=HAND_NM_S_PER_RAD,
            inertia_kg_m2=HAND_KG_M2,
        ),
        plant=plant,
        control=ControlConfig(law=law, beta=beta),
        control_period_ns=round(1e9 / rate_hz),
    )


PUSH_DURATION_S = PUSH_S + HOLD_S + PULL_S + 0.2


@dataclass(frozen=True)
class Push:
    """A visit to the wall in numbers. Torques in N m, errors as fractions of the peak."""

    peak_torque_nm: float
    tracking_rms_in: float
    tracking_rms_out: float
    torque_gap_nm: float
    sensor_rms_nm: float
    brake_for_spring_rms: float
    """Between Tb + Tm, as the paper has it, and what is felt, Tk + Tm; both ways."""
    zero_crossing: float
    """Depth where the sensed torque changes sign on the way out, as a fraction of the deepest."""
    in_end: int
    """Row at the end of the way in, and at the begin of the way out; first and last row inside."""
    out_begin: int
    first: int
    last: int

    def jnds(self) -> dict[str, float]:
        """Give the errors in just noticeable differences."""
        return perception.wall_jnds(
            peak_nm=self.peak_torque_nm,
            tracking_in=self.tracking_rms_in,
            tracking_out=self.tracking_rms_out,
            torque_gap_nm=self.torque_gap_nm,
        ) | {"sensor": perception.torque_jnds(self.sensor_rms_nm)}


def rendered_nm(rows: Record) -> Array:
    """Give what the hand feels: spring and motor together."""
    return np.asarray(rows["spring_torque_nm"] + rows["motor_torque_nm"])


def ideal_nm(rows: Record, stiffness: float, surface_rad: float = WALL_RAD) -> Array:
    """Give what a perfect wall would where the knob truly is."""
    return np.asarray(-stiffness * np.maximum(rows["angle_rad"] - surface_rad, 0.0))


def measure_push(rows: Record, stiffness: float, wall_rad: float = WALL_RAD) -> Push:
    """Measure a visit to the wall."""
    asked = np.abs(rows["desired_torque_nm"])
    peak = float(asked.max())
    inside = np.flatnonzero(asked > 0)
    top = np.flatnonzero(asked >= 0.98 * peak)
    first, last = int(inside[0]), int(inside[-1])
    in_end, out_begin = int(top[0]), int(top[-1])
    ideal, rendered = ideal_nm(rows, stiffness, wall_rad), rendered_nm(rows)
    error = rendered - ideal
    way_out = slice(out_begin, last + 1)
    depth = rows["angle_rad"] - wall_rad
    held = rows["brake_capacity_nm"]
    against = np.flatnonzero(rows["sensed_spring_torque_nm"][way_out] > 0)
    crossing = float(depth[out_begin + against[0]] / depth.max()) if len(against) else 0.0
    return Push(
        peak_torque_nm=peak,
        tracking_rms_in=rms(error[first : in_end + 1]) / peak,
        tracking_rms_out=rms(error[way_out]) / peak,
        torque_gap_nm=float((np.abs(ideal) - rendered * np.sign(ideal))[way_out].max()),
        brake_for_spring_rms=rms((held - np.abs(rows["spring_torque_nm"]))[inside]) / peak,
        sensor_rms_nm=rms(rows["sensed_spring_torque_nm"] - rows["spring_torque_nm"]),
        zero_crossing=crossing,
        in_end=in_end,
        out_begin=out_begin,
        first=first,
        last=last,
    )


WALL_EVENTS = (
    "the brake slips along",
    "it meets the wall",
    "the motor makes up most",
    "at rest",
    "the hand turns round",
    "the shaft is empty",
    "the brake has let go",
    "out of the wall",
)
RELEASED_NM = 5e-3
"""The brake's 2 mN m of drag, and little more."""


def wall_events(rows: Record, push: Push, beta: float) -> tuple[int, ...]:
    """Find the rows at which a visit to a soft wall has its WALL_EVENTS, one by one.

    Raises
    ------
    ValueError
        If one of them does not happen, as in walls stiffer than the shaft.
    """

    def first(begin: int, holds: npt.NDArray[np.bool_]) -> int:
        found = np.flatnonzero(holds[begin:])
        if not len(found):
            raise ValueError("the visit does not have all of its events")
        return begin + int(found[0])

    inward = slice(push.first, push.in_end)
    own_share = (1.0 - beta) * np.abs(rows["desired_torque_nm"][inward])
    extra = np.abs(rows["motor_torque_nm"][inward]) - own_share
    speed = np.abs(rows["speed_rad_s"])
    empty = first(push.out_begin, rows["sensed_spring_torque_nm"] > 0)
    return (
        first(0, ~rows["brake_sticks"].astype(bool)),
        push.first,
        push.first + int(np.argmax(extra)),
        first(push.in_end, speed < 0.01 * speed[inward].max()),
        push.out_begin,
        empty,
        first(empty, rows["brake_capacity_nm"] < RELEASED_NM),
        push.last,
    )


# Scenario 3: the string is cut --------------------------------------------------------------------

WEIGHT_NM = 50e-3
CUT_S = 1.2


def cut_options(
    stiffness: float, law: Law = "paper", *, plant: PlantParams | None = None, beta: float = 0.5
) -> LoopOptions:
    """Hang a weight on the knob, which sinks into the wall; then cut the string."""
    plant = plant or PlantParams()
    return LoopOptions(
        scene=Wall(angle_rad=WALL_RAD, stiffness_nm_per_rad=stiffness),
        hand=TorqueHand(torque_nm=[(0, 0), (0.8, WEIGHT_NM), (CUT_S, WEIGHT_NM), (CUT_S, 0)]),
        plant=plant,
        control=ControlConfig(law=law, beta=beta),
    )


@dataclass(frozen=True)
class Cut:
    """The knob's end. Depths are positive inside the wall."""

    depth_at_cut_rad: float
    final_depth_rad: float
    exit_s: float | None
    """As in `exits.Exit`, like the next two."""
    stuck_torque_nm: float
    outcome: Outcome


def measure_cut(rows: Record, stiffness: float, plant: PlantParams) -> Cut:
    """Measure what came after the cut."""
    time, depth = rows["time_s"], rows["angle_rad"] - WALL_RAD
    left = exits.measure_exit(
        time,
        -ideal_nm(rows, stiffness),
        let_go_s=CUT_S,
        friction_nm=plant.knob_coulomb_nm + plant.brake_drag_nm,
        count_nm=stiffness * 2.0 * math.pi / plant.counts_per_rev,
    )
    return Cut(
        depth_at_cut_rad=float(depth[np.searchsorted(time, CUT_S)]),
        final_depth_rad=float(depth[-1]),
        exit_s=left.exit_s,
        stuck_torque_nm=left.stuck_torque_nm,
        outcome=left.outcome,
    )


# Fig. 6: characterisation of the shaft ------------------------------------------------------------

RAMP_S = 4.0
LINEAR_RAD = 0.015


@dataclass(frozen=True)
class Characterisation:
    """The motor's torque over the measured angle while the brake holds."""

    torque_nm: Array
    measured_rad: Array
    slope_nm_per_rad: float
    """The linear range on the way up, from the torques at which the encoder counted."""
    offset_nm: float


def characterise(hardening: ShaftHardening | None = None) -> Characterisation:
    """Hold the brake at its limit, and ramp the motor's torque up and down again."""
    loop = ClosedLoop(LoopOptions(plant=PlantParams(shaft_hardening=hardening)))
    loop.hold_command(brake_command_nm=BRAKE_NM)
    loop.run(duration_s=0.5)  # until the brake holds
    rows = []
    for share in np.linspace(0, 2, round(1000 * RAMP_S)):
        wanted = float(MOTOR_NM * min(share, 2.0 - share))
        loop.hold_command(motor_command_nm=wanted, brake_command_nm=BRAKE_NM)
        rows.append(loop.run(duration_s=1e-3))
    log = np.concatenate(rows)
    counts = log["position_counts"]
    angle = counts * COUNT_RAD
    torque = log["motor_torque_nm"]
    # Where the count has just changed the angle is known better than to a count.
    edges = np.flatnonzero(np.diff(counts[: len(log) // 2]) > 0) + 1
    edges = edges[(angle[edges] > 1e-3) & (angle[edges] < LINEAR_RAD)]
    slope, offset = np.polyfit(angle[edges], torque[edges], 1)
    return Characterisation(torque, angle, float(slope), float(offset))


def _stiffness(options: LoopOptions) -> float:
    if not isinstance(options.scene, Wall):
        raise TypeError("the scene must be a wall")
    return options.scene.stiffness_nm_per_rad


def run_push(options: LoopOptions, *, extra_s: float = 0.0) -> tuple[Record, Push]:
    """Simulate and measure a visit to the wall of `push_options`."""
    rows = simulate(options, duration_s=PUSH_DURATION_S + extra_s)
    return rows, measure_push(rows, _stiffness(options))


def run_cut(options: LoopOptions) -> tuple[Record, Cut]:
    """Simulate and measure the cut string of `cut_options`."""
    rows = simulate(options, duration_s=CUT_S + 1.0)
    return rows, measure_cut(rows, _stiffness(options), options.plant)
