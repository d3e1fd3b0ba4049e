"""How near the laws come to their aims on the plant with electrics, and what the rest takes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from functools import cache
from itertools import product, starmap
from typing import Final

import numpy as np
from rich.table import Table

import torsio
from torsio import calibration, perception
from torsio.calibration.circuit import MEASURED_OF_BOARD
from torsio.closed_loop import LoopOptions, simulate, simulate_many
from torsio.common import screen
from torsio.printed.config import BoardConfig, ControlConfig, Law
from torsio.printed.hands import ImpedanceHand
from torsio.printed.plant import BrakeHysteresis, Electrics, PlantParams
from torsio_studies.common import Results, Study
from torsio_studies.paper import runs

RATE_HZ, COUNTS, COARSE_COUNTS = 20e3, 32_768, 8192
WALL, SOFT_WALL = 30.0, 10.0  # mN m per degree
CUT_WALLS = (10.0, 25.0, 50.0, 100.0)
LOOP = BrakeHysteresis(half_width_nm=0.1 * runs.BRAKE_NM)
ASSIST_NM = 5.8e-3
TURN_RAD_S = 1.0
PLACES = 16  # within a count
# How hard the hand pushes: where it stops, the brake may slip or not.
PEAKS_NM = tuple(share * runs.PEAK_NM for share in np.linspace(0.9, 1.1, 8))
EXITS_RAD_S = (0.1, 0.25, 0.6, 1.0)
# Of an encoder whose count flickers on, and N m/rad of walls in which the device holds it.
NOISE_COUNTS, NOISY_COUNTS, HOLDING_WALLS = 0.3, (8192, 32_768, 131_072), (30.0, 300.0, 3000.0)
DRAG_SHARES, LAGS_S = (0.5, 1.5), (30e-3, 120e-3)
WRONG_SHARES: Final = (0.8, 1.2)
WRONG_EXIT_RAD_S: Final = 0.25
WRONG_BELIEFS: Final = (
    *("spring_stiffness_nm_per_rad", "brake_time_constant_s", "brake_inertia_kg_m2"),
    *("brake_drag_nm", "knob_coulomb_nm", "brake_hysteresis_nm"),
    *("knob_inertia_kg_m2", "motor_time_constant_s"),
    *("motor_torque_constant_nm_per_a", "brake_torque_constant_nm_per_a", "current_sense_v_per_a"),
)
# A device's beliefs before its calibration, over the truth.
BELIEVED = 1.3
BELIEVED_WRONG = (
    *("knob_inertia_kg_m2", "knob_coulomb_nm", "knob_viscous_nm_s_per_rad", "brake_drag_nm"),
    *("spring_stiffness_nm_per_rad", "brake_time_constant_s"),
)


@dataclass(frozen=True)
class Variant:
    """A law, what its device is told, and what the knob truly is.

    `measured` tells it what its own calibration finds, in place of the truth.
    """

    name: str
    law: Law
    measured: bool = False
    brake_is_known: bool = True
    brake_inertia_kg_m2: float = PlantParams().brake_inertia_kg_m2


VARIANTS: Final = (
    Variant("paper", "paper"),
    Variant("calibrated, brake unknown", "calibrated", brake_is_known=False),
    Variant("calibrated", "calibrated"),
    Variant("calibrated by itself", "calibrated", measured=True),
    Variant("+ light brake side", "calibrated", brake_inertia_kg_m2=1e-6),
)

AIMS: Final = {
    "tracking_out": 0.4e-2,
    "torque_gap_nm": 1.0e-3,
    "soft_torque_gap_nm": 1.3e-3,
    "sensor_rms_nm": 0.25e-3,
    "imperfect_tracking_out": 2.5e-2,
    "slowest_exit_s": 10e-3,
    "drag_nm": 3e-3,
}
"""The aims. `None` in a result is a knob that stays in a wall."""


def _plant(variant: Variant, place: float = 0.0) -> PlantParams:
    """Make a knob that begins at a place within a count, from 0 to 1."""
    return PlantParams(
        counts_per_rev=COUNTS,
        encoder_phase_counts=place,
        electrics=Electrics(),
        brake_inertia_kg_m2=variant.brake_inertia_kg_m2,
    )


def _push(variant: Variant, wall: float, plant: PlantParams) -> runs.Push:
    options = runs.push_options(runs.per_degree(wall), variant.law, rate_hz=RATE_HZ, plant=plant)
    return runs.run_push(_told(options, variant))[1]


@cache
def _found(plant: PlantParams) -> calibration.Calibration:
    """Have a device calibrate itself that takes its parts for others than they are."""
    known = PlantParams(counts_per_rev=plant.counts_per_rev, electrics=Electrics())
    actuator = known.matching_config()
    wrong = {name: BELIEVED * getattr(actuator, name) for name in BELIEVED_WRONG}
    options = torsio.EmulatorOptions(
        plant=plant,
        control_rate_hz=RATE_HZ,
        actuator=replace(actuator, brake_inertia_kg_m2=0.0, **wrong),
    )
    with torsio.open("emulated", emulator=options) as knob:
        return calibration.calibrate(knob)


def _told(options: LoopOptions, variant: Variant) -> LoopOptions:
    if variant.measured:
        found = _found(options.plant)
        board = asdict(found.board) if found.board is not None else {}
        options = replace(
            options,
            actuator=found.actuator,
            shaft=found.shaft,
            board=replace(BoardConfig(), **{name: board[name] for name in MEASURED_OF_BOARD}),
            control=replace(options.control, law=found.law, free_assist_nm=found.free_assist_nm),
        )
        return replace(options, control_period_ns=round(1e9 / RATE_HZ))
    actuator, control = options.plant.matching_config(), options.control
    if variant.brake_is_known:
        control = replace(control, free_assist_nm=ASSIST_NM)
    else:
        actuator = replace(actuator, brake_inertia_kg_m2=0.0, brake_hysteresis_nm=0.0)
    return replace(
        options, actuator=actuator, control=control, control_period_ns=round(1e9 / RATE_HZ)
    )


def _drag_nm(variant: Variant, place: float = 0.0) -> float:
    """Give what it takes to turn the knob where there is nothing, as a mean over a second."""
    hand = ImpedanceHand(
        intended_angle_rad=[(0.0, 0.0), (2.0, 2.0 * TURN_RAD_S)],
        stiffness_nm_per_rad=runs.HAND_NM_PER_RAD,
        damping_nm_s_per_rad=runs.HAND_NM_S_PER_RAD,
        inertia_kg_m2=runs.HAND_KG_M2,
    )
    control = ControlConfig(law=variant.law)
    options = LoopOptions(hand=hand, plant=_plant(variant, place), control=control)
    rows = simulate(_told(options, variant), duration_s=2.0)
    return float(rows["hand_torque_nm"][len(rows) // 2 :].mean())


def _imperfect(variant: Variant, place: float = 0.0) -> float:
    """Give the worst error on the way out with hysteresis, and drag and lag that are known."""
    largest = 0.0
    for drag_share, lag_s in product(DRAG_SHARES, LAGS_S):
        plant, electrics = _plant(variant, place), Electrics()
        # On a plant with electrics the brake's lag is its coil's.
        plant = replace(
            plant,
            brake_drag_nm=drag_share * plant.brake_drag_nm,
            brake_time_constant_s=lag_s,
            electrics=replace(electrics, coil_inductance_h=lag_s * electrics.coil_resistance_ohm),
            brake_hysteresis=LOOP,
        )
        largest = max(largest, _push(variant, WALL, plant).tracking_rms_out)
    return largest


def _exits(variant: Variant, place: float = 0.0) -> list[Results]:
    rows = []
    for wall in CUT_WALLS:
        options = runs.cut_options(runs.per_degree(wall), variant.law, plant=_plant(variant, place))
        _, cut = runs.run_cut(_told(options, variant))
        rows.append(
            {
                "wall_mnm_per_deg": wall,
                "outcome": cut.outcome,
                "exit_s": cut.exit_s,
                "stuck_torque_nm": cut.stuck_torque_nm,
            }
        )
    return rows


def _slowest_s(left: list[Results]) -> float | None:
    times = [row["exit_s"] for row in left]
    return None if None in times else max(times)


def _coarse(variant: Variant) -> Results:
    """Give the visit to the wall with a coarse encoder."""
    plant = replace(_plant(variant), counts_per_rev=COARSE_COUNTS)
    push = _push(variant, WALL, plant)
    return {
        "variant": variant.name,
        "tracking_in": push.tracking_rms_in,
        "tracking_out": push.tracking_rms_out,
        "torque_gap_nm": push.torque_gap_nm,
        "sensor_rms_nm": push.sensor_rms_nm,
    }


def _with_wrong(options: LoopOptions, name: str, factor: float) -> LoopOptions:
    """Make a device believe another value of an actuator's or a board's field."""
    board = BoardConfig()
    if hasattr(board, name):
        board = replace(board, motor_current_continuous_a=board.motor_current_max_a)
        return replace(options, board=replace(board, **{name: factor * getattr(board, name)}))
    told = options.actuator or options.plant.matching_config()
    return replace(options, actuator=replace(told, **{name: factor * getattr(told, name)}))


def _places(number: int) -> list[float]:
    return [place / number for place in range(number)]


def worst(
    variant: Variant,
    exit_rad_s: float,
    places: Iterable[tuple[float, float]],
    wrong: dict[str, float] | None = None,
) -> Results:
    """Give the worst of visits where knob and wall begin at different places within a count.

    At each place the hand pushes to several depths, each with other noise of the current sensor.
    Beside the worst stands what 95 of 100 visits keep. `wrong` are factors on what the device is
    told.
    """
    stiffness, told = runs.per_degree(WALL), wrong or {}
    visits, walls_rad, longest_s = [], [], 0.0
    for (place, wall_place), (seed, peak_nm) in product(places, enumerate(PEAKS_NM)):
        walls_rad.append(runs.WALL_RAD + wall_place * math.tau / COUNTS)
        plant = _plant(variant, place)
        if "brake_hysteresis_nm" in told:
            plant = replace(plant, brake_hysteresis=LOOP)
        give_rad = (peak_nm + plant.knob_coulomb_nm) / runs.HAND_NM_PER_RAD
        pull_s = (runs.WALL_RAD + peak_nm / stiffness + give_rad) / exit_rad_s
        longest_s = max(longest_s, pull_s)
        visit = runs.push_options(
            stiffness, variant.law, rate_hz=RATE_HZ, plant=plant, pull_s=pull_s,
            peak_nm=peak_nm, wall_rad=walls_rad[-1],
        )  # fmt: skip
        visits.append(replace(_told(visit, variant), seed=seed))
    for name, factor in told.items():
        visits = [_with_wrong(visit, name, factor) for visit in visits]
    duration_s = runs.PUSH_DURATION_S - runs.PULL_S + longest_s
    pushes = [
        runs.measure_push(rows, stiffness, wall_rad)
        for rows, wall_rad in zip(
            simulate_many(visits, duration_s=duration_s), walls_rad, strict=True
        )
    ]
    errors = [push.tracking_rms_out for push in pushes]
    gaps_nm = [push.torque_gap_nm for push in pushes]
    return {
        "variant": variant.name,
        "exit_rad_s": exit_rad_s,
        "tracking_out": max(errors),
        "tracking_out_95": float(np.percentile(errors, 95)),
        "torque_gap_nm": max(gaps_nm),
        "torque_gap_95_nm": float(np.percentile(gaps_nm, 95)),
        "sensor_rms_nm": max(push.sensor_rms_nm for push in pushes),
    }


def _worst_left(variant: Variant, places: int) -> Results:
    """Give the worst of places within a count: what `worst` does not look at."""
    each = _places(places)
    left = [row for place in each for row in _exits(variant, place)]
    drag_nm = max(_drag_nm(variant, place) for place in each)
    soft = [_push(variant, SOFT_WALL, _plant(variant, place)).torque_gap_nm for place in each]
    return {
        "slowest_exit_s": _slowest_s(left),
        "drag_nm": drag_nm,
        "soft_torque_gap_nm": max(soft),
        "imperfect_tracking_out": max(_imperfect(variant, place) for place in each),
    }


def _wrong_belief(variant: Variant, belief: str, places: int) -> Results:
    """Give the worst with a single belief a fifth too small or too large."""
    knobs = [(place, 0.0) for place in _places(places)]
    both = [worst(variant, WRONG_EXIT_RAD_S, knobs, {belief: share}) for share in WRONG_SHARES]
    names = "tracking_out", "torque_gap_nm"
    return {"belief": belief, **{name: max(one[name] for one in both) for name in names}}


def _held_leap_nm(counts: int, wall_nm_per_rad: float) -> float:
    """Give by how much the motor leaps as a hand pushes on from a count that the device holds."""
    held_s, on_s = 2.0, 0.6
    hand = ImpedanceHand(
        stiffness_nm_per_rad=1.0, damping_nm_s_per_rad=0.01, inertia_kg_m2=1e-6,
        intended_angle_rad=[(0.0, 0.0), (0.3, 0.1), (held_s, 0.1), (held_s + on_s, 0.13)],
    )  # fmt: skip
    rows = simulate(
        LoopOptions(
            scene=[torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=wall_nm_per_rad)],
            plant=PlantParams(counts_per_rev=counts, encoder_noise_counts=NOISE_COUNTS),
            hand=hand,
            control=ControlConfig(law="calibrated"),
            control_period_ns=round(1e9 / RATE_HZ),
        ),
        duration_s=held_s + on_s,
    )
    left = np.flatnonzero((np.diff(rows["desired_torque_nm"]) != 0) & (rows["time_s"][1:] > held_s))
    # Four counts come one by one, as the held one leads a play.
    return float(np.max(np.abs(np.diff(rows["motor_command_nm"])[left[:5]])))


def run(study: Study) -> Results:
    """Measure every variant."""
    rows = []
    for variant in study.track(VARIANTS, "aims, on the plant with electrics"):
        plant = _plant(variant)
        push, soft = _push(variant, WALL, plant), _push(variant, SOFT_WALL, plant)
        exits = _exits(variant)
        rows.append(
            {
                "variant": variant.name,
                "law": variant.law,
                "tracking_out": push.tracking_rms_out,
                "torque_gap_nm": push.torque_gap_nm,
                "soft_torque_gap_nm": soft.torque_gap_nm,
                "sensor_rms_nm": push.sensor_rms_nm,
                "imperfect_tracking_out": _imperfect(variant),
                "slowest_exit_s": _slowest_s(exits),
                "drag_nm": _drag_nm(variant),
                "exits": exits,
                "jnds": push.jnds(),
            }
        )
    known = next(variant for variant in VARIANTS if variant.name == "calibrated")
    places = 2 if study.quick else PLACES
    knobs = [(place, 0.0) for place in _places(places)]
    walls = [(0.0, place) for place in _places(places)]
    few = _places(max(2, places // 2))
    step = perception.count_step_nm(runs.per_degree(WALL), COUNTS)
    return {
        "aims": AIMS,
        "rows": rows,
        "control_rate_hz": RATE_HZ,
        "counts_per_rev": COUNTS,
        "at_8192_counts": [_coarse(variant) for variant in VARIANTS if variant.law == "calibrated"],
        "worst": [worst(known, speed, knobs) for speed in EXITS_RAD_S],
        "worst_walls": [worst(known, speed, walls) for speed in EXITS_RAD_S],
        "worst_of_both": worst(known, WRONG_EXIT_RAD_S, product(few, few)),
        "worst_places": _worst_left(known, places),
        "wrong_beliefs": [_wrong_belief(known, belief, places) for belief in WRONG_BELIEFS],
        "count_step_jnds": perception.torque_jnds(step),
        "held_leap_nm": max(starmap(_held_leap_nm, product(NOISY_COUNTS, HOLDING_WALLS))),
    }


def table(results: Results) -> Table:
    """Give the variants beside the aims, for the screen."""
    shown = screen.table(
        "electrics,\n20 kHz, 32,768 counts", "out", "gap\nmN·m", "soft gap\nmN·m",
        "sensor\nmN·m", "imper-\nfect", "exits\nms", "drag\nmN·m", "out\nJND", "gap\nJND",
        words=1,
    )  # fmt: skip
    shown.columns[0].no_wrap = True
    for row in (*results["rows"], {"variant": "aim", **results["aims"]}):
        felt = row.get("jnds")
        slowest = row["slowest_exit_s"]
        shown.add_row(
            row["variant"],
            f"{100 * row['tracking_out']:.2f} %",
            *(
                f"{1e3 * row[name]:.2f}"
                for name in ("torque_gap_nm", "soft_torque_gap_nm", "sensor_rms_nm")
            ),
            f"{100 * row['imperfect_tracking_out']:.1f} %",
            "stays" if slowest is None else f"{1e3 * slowest:.0f}",
            f"{1e3 * row['drag_nm']:.1f}",
            *(f"{felt[name]:.2f}" if felt else "" for name in ("tracking_out", "torque_gap")),
        )
    return shown
