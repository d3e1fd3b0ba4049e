"""Every rival actuator in the same scenes: walls, a cut string, a spin into a spring, free motion.

docs/results/actuators.md has the models, their sources and the keys of the results.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from torsio.closed_loop import LoopOptions
from torsio.common import checks
from torsio.demos import wall
from torsio.perception import VIBRATION_NM, vibration_nm
from torsio.printed.hands import Hand, ImpedanceHand, NoHand, TorqueHand
from torsio.printed.plant import PlantParams
from torsio.telemetry import Record
from torsio_studies import _studies, exits
from torsio_studies.common import StudyError
from torsio_studies.exits import Exit, Outcome

Array = npt.NDArray[np.float64]
Parts = dict[str, float]

NM_PER_RAD = math.pi / 180 * 1e3  # mN m/deg in one N m/rad
WALLS_MNM_PER_DEG: Final = (10.0, 30.0, 100.0)
CUT_WALL_MNM_PER_DEG = 25.0
CUT_TORQUE_NM = 50e-3
CUT_S = 1.0
# Rest and a lasting swing can both be stable; which one a spin ends in depends on where it begins.
SPINS_RAD_S: Final = (18.0, 14.0, 10.0)
SPIN_S = 1.5
AT_REST_RAD_S = 1.0  # lasting swings are many times faster
STIFFEST_NM_PER_RAD = 200.0
SOFTEST_NM_PER_RAD = 0.1
FREE_RAD_S = 5.0
PRESS_WALL_MNM_PER_DEG = 10.0
PRESS_TO_NM = 0.4
PRESS_S = 10.0
MOTOR_LIMIT_NM = PlantParams().motor_limit_nm
COUNTS_PER_REV = PlantParams().counts_per_rev
PERIOD_NS = LoopOptions().control_period_ns
FINE: Final = {"counts_per_rev": 32_768, "period_ns": 50_000, "step_ns": 10_000}
"""Options of `simulate`: the rate of a Pico 2 and a finer encoder."""


@dataclass(frozen=True)
class Actuator:
    """One of the rivals.

    Attributes
    ----------
    letter
        Of the paper's Fig. 1, or empty.
    """

    key: str
    letter: str
    title: str


ACTUATORS: Final = (
    Actuator("motor_only", "", "motor only"),
    Actuator("brake_only", "", "brake only"),
    Actuator("parallel", "a", "brake and motor in parallel"),
    Actuator("parallel_torque_sensor", "b", "parallel, with a torque sensor"),
    Actuator("series_elastic_motor", "c", "motor behind a soft spring"),
    Actuator("series_elastic_brake", "c", "brake behind a soft spring"),
    Actuator("differential_clutch", "d", "driven clutch"),
    Actuator("soft_spring", "e", "soft spring, two encoders"),
    Actuator("soft_sensor_paper", "f", "this device, law `paper`"),
    Actuator("soft_sensor_compensated", "f", "this device, law `compensated`"),
    Actuator("soft_sensor_calibrated", "f", "this device, law `calibrated`"),
    Actuator("one_way_brakes", "", "two one-way brakes and a motor"),
    Actuator("transfer_function", "", "brake first, motor later"),
)


FINE_KEYS: Final = (
    "motor_only",
    "soft_spring",
    "soft_sensor_paper",
    "soft_sensor_compensated",
    "soft_sensor_calibrated",
)
"""Actuators that are measured with these options too. Counts and rate limit them most."""


@dataclass(frozen=True)
class WallMeasures:
    """A visit to a wall. RMS errors are shares of the peak of the wall's torque."""

    stiffness_mnm_per_deg: float
    tracking_in: float
    tracking_out: float
    torque_gap_nm: float
    peak_nm: float


@dataclass(frozen=True)
class Measures:
    """One row of the results.

    Attributes
    ----------
    exit_time_s, stuck_torque_nm, outcome
        After the cut of the string, by `exits.measure_exit`.
    stable_stiffness_nm_per_rad
        Of the softest virtual spring that keeps swinging after a spin; None if even the stiffest
        tried comes to rest.
    drag_nm
        Torque that the hand needs to turn the knob steadily in free space.
    peak_torque_nm
        Largest torque in a soft wall that is still within 10 % of what is wanted.
    motor_heat
        Mean square of the motor's torque during the visit to the middle wall, as a share of what
        full torque would make.
    """

    actuator: str
    figure: str
    title: str
    walls: tuple[WallMeasures, ...]
    exit_time_s: float | None
    stuck_torque_nm: float
    outcome: Outcome
    stable_stiffness_nm_per_rad: float | None
    drag_nm: float
    peak_torque_nm: float
    motor_heat: float


def simulate(
    actuator: str,
    *,
    hand: Hand,
    duration_s: float,
    stiffness_nm_per_rad: float = 0.0,
    angle_rad: float = 0.0,
    both_ways: bool = False,
    initial_speed_rad_s: float = 0.0,
    parts: Parts | None = None,
    counts_per_rev: int = COUNTS_PER_REV,
    period_ns: int = PERIOD_NS,
    step_ns: int = 20_000,
) -> Record:
    """Run one actuator; a structured array, one row per control period.

    Parameters
    ----------
    angle_rad
        Surface of the wall, or centre of the spring if `both_ways`.
    parts
        Parts that differ from the parts of all actuators.
    """
    if not isinstance(hand, NoHand | TorqueHand | ImpedanceHand):
        # A brake fixed to the knob could not answer a prescribed motion with one torque.
        raise StudyError(f"actuator: a hand must have some give, not {type(hand).__name__}")
    return _studies.run_actuator(
        actuator,
        hand=hand,
        duration_ns=round(duration_s * 1e9),
        parts=parts or {},
        stiffness_nm_per_rad=stiffness_nm_per_rad,
        angle_rad=angle_rad,
        both_ways=both_ways,
        initial_speed_rad_s=initial_speed_rad_s,
        counts_per_rev=counts_per_rev,
        period_ns=period_ns,
        step_ns=step_ns,
    )


def visit_wall(actuator: str, stiffness_nm_per_rad: float, **options: Any) -> Record:
    """Press into a wall within a second, hold, and come out within another."""
    checks.positive("stiffness_nm_per_rad", stiffness_nm_per_rad)
    return simulate(
        actuator,
        hand=wall.hand(stiffness_nm_per_rad),
        duration_s=wall.EMULATED_DURATION_S,
        stiffness_nm_per_rad=stiffness_nm_per_rad,
        angle_rad=wall.WALL_ANGLE_RAD,
        **options,
    )


def cut_string(actuator: str, **options: Any) -> Record:
    """Hang a weight on the knob, in a wall from angle 0 on, and cut its string."""
    weight = TorqueHand(
        torque_nm=[(0, 0), (0.5, CUT_TORQUE_NM), (CUT_S, CUT_TORQUE_NM), (CUT_S, 0)]
    )
    return simulate(
        actuator,
        hand=weight,
        duration_s=CUT_S + 2.0,
        stiffness_nm_per_rad=CUT_WALL_MNM_PER_DEG / 1e3 * 180 / math.pi,
        **options,
    )


def spin_into_spring(
    actuator: str, stiffness_nm_per_rad: float, speed_rad_s: float = SPINS_RAD_S[0], **options: Any
) -> Record:
    """Let go of the knob at speed in the middle of a virtual spring."""
    return simulate(
        actuator,
        hand=NoHand(),
        duration_s=SPIN_S,
        stiffness_nm_per_rad=stiffness_nm_per_rad,
        both_ways=True,
        initial_speed_rad_s=speed_rad_s,
        **options,
    )


def turn_freely(actuator: str, **options: Any) -> Record:
    """Turn the knob at a steady speed in free space."""
    hand = wall.fingers([(0.0, 0.0), (1.0, FREE_RAD_S)])
    return simulate(actuator, hand=hand, duration_s=1.0, **options)


def press_hard(actuator: str, **options: Any) -> Record:
    """Press slowly into a soft wall, beyond what any of the actuators can give."""
    stiffness = PRESS_WALL_MNM_PER_DEG / 1e3 * 180 / math.pi
    deepest_rad = PRESS_TO_NM * (1 + 1 / stiffness)
    return simulate(
        actuator,
        hand=wall.fingers([(0.0, 0.0), (PRESS_S, deepest_rad)]),
        duration_s=PRESS_S,
        stiffness_nm_per_rad=stiffness,
        **options,
    )


def measure_wall(log: Record | dict[str, Array], stiffness_nm_per_rad: float) -> WallMeasures:
    """Turn a visit into numbers: felt torque against the wall's at the true angle."""
    ideal, felt, time = log["ideal_torque_nm"], log["rendered_torque_nm"], log["time_s"]
    inside = ideal < 0
    way_in, way_out = inside & (time <= wall.PUSH_S), inside & (time > wall.PUSH_S + wall.HOLD_S)
    peak = float(-ideal.min())
    missing = (felt - ideal)[way_out]
    return WallMeasures(
        stiffness_mnm_per_deg=stiffness_nm_per_rad * NM_PER_RAD,
        tracking_in=wall.rms((felt - ideal)[way_in]) / peak,
        tracking_out=wall.rms((felt - ideal)[way_out]) / peak,
        torque_gap_nm=max(0.0, float(missing.max())) if len(missing) else math.nan,
        peak_nm=peak,
    )


def measure_exit(actuator: str, log: Record | None = None) -> Exit:
    """Measure the way out after the cut; `log` is what `cut_string` gave, if that was run."""
    log = cut_string(actuator) if log is None else log
    count_nm = CUT_WALL_MNM_PER_DEG / 1e3 * 360 / COUNTS_PER_REV
    return exits.measure_exit(
        log["time_s"],
        -log["ideal_torque_nm"],
        let_go_s=CUT_S,
        friction_nm=friction_nm(actuator),
        count_nm=count_nm,
    )


def comes_to_rest(log: Record) -> bool:
    """Tell whether a spin has died down by its end, and no finger feels the motor then."""
    end = log[log["time_s"] > SPIN_S - 0.2]
    rate_hz = (len(end) - 1) / float(np.ptp(end["time_s"]))
    return bool(
        np.abs(end["speed_rad_s"]).max() < AT_REST_RAD_S
        and vibration_nm(end["motor_torque_nm"], rate_hz) < VIBRATION_NM
    )


def stable_limit(
    is_stable: Callable[[float], bool],
    *,
    softest: float = SOFTEST_NM_PER_RAD,
    stiffest: float = STIFFEST_NM_PER_RAD,
    coarse_steps: int = 34,
    tolerance: float = 0.01,
) -> float | None:
    """Find the smallest stiffness that is not stable: upward in coarse steps, then by halving.

    Returns
    -------
    float or None
        None if the whole range is stable; `softest` if already that is not.
    """
    last = None
    for stiffness in np.geomspace(softest, stiffest, coarse_steps):
        if not is_stable(float(stiffness)):
            break
        last = float(stiffness)
    else:
        return None
    high = float(stiffness)
    if last is None:
        return high
    while high / last > 1 + tolerance:
        middle = math.sqrt(high * last)
        if is_stable(middle):
            last = middle
        else:
            high = middle
    return high


def measure_peak(log: Record) -> float:
    """Give the largest felt torque up to where it first differs by 10 % from the wall's."""
    ideal, felt = -log["ideal_torque_nm"], -log["rendered_torque_nm"]
    # Close to the surface a count, or the drag of the brake, is already more than 10 %.
    wrong = np.flatnonzero((ideal > 30e-3) & (np.abs(felt - ideal) > 0.1 * ideal))
    end = int(wrong[0]) if len(wrong) else len(log)
    return float(felt[:end].max(initial=0.0))


def friction_nm(actuator: str, parts: Parts | None = None) -> float:
    """Give what the bearings and the released brake can hold together."""
    given = _studies.actuator_parts() | (parts or {})
    total = given["knob_coulomb_nm"]
    if actuator not in ("brake_only", "series_elastic_brake", "differential_clutch"):
        total += given["rotor_coulomb_nm"]
    if actuator not in ("motor_only", "series_elastic_motor"):
        total += given["brake_drag_nm"]
    return total


def measure(actuator: Actuator, *, coarse_steps: int = 34, **options: Any) -> Measures:
    """Put one actuator through all scenes."""
    key = actuator.key
    walls = []
    heat = math.nan
    for stiffness_mnm_per_deg in WALLS_MNM_PER_DEG:
        stiffness = stiffness_mnm_per_deg / NM_PER_RAD
        log = visit_wall(key, stiffness, **options)
        walls.append(measure_wall(log, stiffness))
        if stiffness_mnm_per_deg == WALLS_MNM_PER_DEG[1]:
            heat = float(np.mean(np.square(log["motor_load_nm"] / MOTOR_LIMIT_NM)))
    left = measure_exit(key, cut_string(key, **options))
    limit = stable_limit(
        lambda stiffness: all(
            comes_to_rest(spin_into_spring(key, stiffness, speed, **options))
            for speed in SPINS_RAD_S
        ),
        coarse_steps=coarse_steps,
    )
    free = turn_freely(key, **options)
    steady = free["hand_torque_nm"][len(free) // 2 :]
    return Measures(
        actuator=key,
        figure=actuator.letter,
        title=actuator.title,
        walls=tuple(walls),
        exit_time_s=left.exit_s,
        stuck_torque_nm=left.stuck_torque_nm,
        outcome=left.outcome,
        stable_stiffness_nm_per_rad=limit,
        drag_nm=float(steady.mean()),
        peak_torque_nm=measure_peak(press_hard(key, **options)),
        motor_heat=heat,
    )


def step_error() -> float:
    """Give the largest change of a tracking error, in shares of the peak, when steps are halved."""
    stiffness = WALLS_MNM_PER_DEG[1] / NM_PER_RAD
    worst = 0.0
    for actuator in ACTUATORS:
        whole, half = (
            measure_wall(visit_wall(actuator.key, stiffness, step_ns=step), stiffness)
            for step in (20_000, 10_000)
        )
        worst = max(
            worst,
            abs(whole.tracking_in - half.tracking_in),
            abs(whole.tracking_out - half.tracking_out),
        )
    return worst


def exit_text(outcome: str, exit_s: float | None, stuck_nm: float, unit: str = "") -> str:
    """Say when it has left, or how much the wall still asks for and what keeps the knob there."""
    if exit_s is not None:
        return f"{1e3 * exit_s:.0f}{unit}"
    word = "friction" if outcome == "held by friction" else "sticks"
    return f"{word}, {1e3 * stuck_nm:.0f} mN·m"
