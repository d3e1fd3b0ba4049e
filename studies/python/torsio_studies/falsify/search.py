"""One search: CMA-ES over a case, and what is measured of each try."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Final

import cma
import numpy as np
import numpy.typing as npt

from torsio import EmulatorOptions, StiffnessWarning
from torsio import open as open_knob
from torsio.closed_loop import ClosedLoop, LoopOptions
from torsio.perception import VIBRATION_NM, vibration_nm
from torsio.printed.hands import ImpedanceHand, Profile, TorqueHand
from torsio.telemetry import Record
from torsio_studies.falsify.cases import SPACE, Batch, Case, Moved, options_of, values_of

__all__ = [
    "DRIVEN_W",
    "LASTING_RAD",
    "LOUD_NM",
    "Motion",
    "begin",
    "breaks",
    "evaluate_batch",
    "measure",
]

Array = npt.NDArray[np.float64]

LASTING_RAD: Final = 1e-3
REST_COUNTS: Final = 3
"""A knob that moves by more than either, whichever is larger, swings."""
LOUD_NM: Final = VIBRATION_NM
"""Root mean square of the motor's torque at rest, above 20 Hz."""
DRIVEN_W: Final = 1e-5
"""Power of a motor that keeps the knob moving."""
_RATE_HZ: Final = 2500  # at which a window is looked at
_LOOK_S, _WINDOW_S = 0.1, 0.2
_FIRST_S, _CONFIRMED_S = 1.8, 6.0  # after which the window begins
_LASTED_S: Final = 150.0  # by when a knob that was flung far is back, and a wide swing has died
_RESTING_RAD, _RESTING_SHARE = 1e-6, 1e-2  # a knob that moves and sounds by less stays at rest
_NEARLY_NM: Final = 1e-5
_CONSTANT: Final = ("angle_rad", "brake_angle_rad", "motor_command_nm", "brake_command_nm")
_SLOW: Final = 1e-2
_POPULATION: Final = 16


@dataclass(frozen=True)
class Motion:
    """Motion of a knob in the window.

    Attributes
    ----------
    swing_rad
        From its furthest place to the other.
    work_w
        Power that the motor gives to it.
    loud_nm
        Root of the mean square of the motor's torque above 20 Hz.
    before_rad
        The swing at a third of the time before the window.
    """

    swing_rad: float
    work_w: float
    loud_nm: float
    before_rad: float


def measure(options: Sequence[LoopOptions], after_s: float = _FIRST_S) -> list[Motion]:
    """Run each loop alone, and measure its motion from `after_s` on.

    A knob that rests is not watched longer.
    """
    return [_measure(one, after_s) for one in options]


def _measure(options: LoopOptions, after_s: float) -> Motion:
    rate_hz = round(1e9 / options.control_period_ns)
    loop, now_s = begin(options)
    early_s, hand_s = after_s / 3.0, max(now_s, _hand_ends_s(options))
    if now_s < min(hand_s, early_s):
        loop.run(duration_s=min(hand_s, early_s) - now_s, record_every=rate_hz)
        now_s = min(hand_s, early_s)
    before_rad = None
    while now_s < after_s - 0.5 * _LOOK_S:
        rows = loop.run(duration_s=_LOOK_S, record_every=rate_hz // _RATE_HZ)
        is_late = now_s > early_s - 0.5 * _LOOK_S
        if is_late and before_rad is None:
            before_rad = float(np.ptp(rows["angle_rad"]))
        if now_s >= hand_s and (_is_held(options, rows) or (is_late and _creeps(rows))):
            rows = rows[len(rows) // 4 :]  # before, the current may still follow
            break
        now_s += _LOOK_S
    else:
        rows = loop.run(duration_s=_WINDOW_S, record_every=rate_hz // _RATE_HZ)
    angle, torque = rows["angle_rad"], rows["motor_torque_nm"]
    steps = np.diff(angle)
    return Motion(
        swing_rad=float(np.ptp(angle)),
        work_w=float(np.sum(torque[:-1] * steps)) * _RATE_HZ / len(rows),
        loud_nm=float(vibration_nm(torque[:, None], _RATE_HZ)[0]),
        before_rad=before_rad or 0.0,
    )


def begin(options: LoopOptions) -> tuple[ClosedLoop, float]:
    """Set a loop up, and run it until its host changes no more; say when that is."""
    loop, now_s = ClosedLoop(options), 0.0
    for change in options.changes if isinstance(options, Moved) else ():
        loop.run(duration_s=change.begins_s - now_s, record_every=1000)
        now_s = change.begins_s
        if change.scene is not None:
            loop.set_scene(change.scene)
        if change.model is not None:
            loop.stream_local_model(**change.model)
    return loop, now_s


def _hand_ends_s(options: LoopOptions) -> float:
    """Say from when on a hand does not change."""
    hand = options.hand
    path: Profile = 0.0
    if isinstance(hand, TorqueHand):
        path = hand.torque_nm
    elif isinstance(hand, ImpedanceHand):
        path = hand.intended_angle_rad
    return max(knot[0] for knot in path) if isinstance(path, Iterable) else 0.0


def _is_held(options: LoopOptions, rows: Record) -> bool:
    """Say whether friction holds knob and brake for ever: nothing changes, nor will the brake fall.

    The law's inputs are then constant, and so is the torque that it asks for. A brake ends within
    half its loop of what it is told, so one that holds no more than that keeps what it holds.
    """
    if options.plant.encoder_noise_counts:  # it may change what no row shows, and any time
        return False
    if any(np.any(rows[name] != rows[name][0]) for name in _CONSTANT):
        return False
    told_nm = float(rows["brake_command_nm"][-1]) + _NEARLY_NM
    plant, actuator = options.plant, options.actuator or options.plant.matching_config()
    half_nm = plant.brake_hysteresis.half_width_nm if plant.brake_hysteresis else 0.0
    true_nm = rows["brake_capacity_nm"][-1] - plant.brake_drag_nm
    sensed_nm = rows["sensed_brake_capacity_nm"][-1]
    return bool(
        true_nm <= told_nm + half_nm and sensed_nm <= told_nm + actuator.brake_hysteresis_nm
    )


def _creeps(rows: Record) -> bool:
    """Say whether a knob neither moves nor is made to, though the brake may still slip a little.

    The current of real electrics is never still: only the law's torque counts.
    """
    if np.ptp(rows["angle_rad"]) >= _RESTING_RAD:
        return False
    asked_nm = rows["motor_command_nm"][:, None].astype(float)
    return bool(vibration_nm(asked_nm, _RATE_HZ)[0] < _RESTING_SHARE * LOUD_NM)


def swings(case: Case, motion: Motion) -> bool:
    """Say whether a motion is a swing and no flicker of the encoder."""
    return motion.swing_rad > max(LASTING_RAD, REST_COUNTS * 2.0 * math.pi / case.counts)


def breaks(case: Case, motion: Motion) -> bool:
    """Say whether a motion that lasts is a counter-example."""
    return swings(case, motion) or motion.loud_nm > LOUD_NM or motion.work_w > DRIVEN_W


def confirm(case: Case, options: LoopOptions) -> Motion:
    """Measure again, after longer; what breaks the law still, once more.

    A knob that was flung far may slide back for long, or swing widely until friction has stopped
    it.
    """
    motion = _measure(options, _CONFIRMED_S)
    return _measure(options, _LASTED_S) if breaks(case, motion) else motion


def is_warned_of(options: LoopOptions) -> bool:
    """Say whether `play` warns of a scene on a knob with these beliefs."""
    emulator = EmulatorOptions(
        plant=options.plant,
        control_rate_hz=1e9 / options.control_period_ns,
        actuator=options.actuator,
        board=options.board,
        control=options.control,
    )
    with (
        warnings.catch_warnings(record=True) as caught,
        open_knob("emulated", emulator=emulator) as knob,
    ):
        warnings.simplefilter("always")
        knob.play(options.scene or ())
        last = options.changes[-1].model if isinstance(options, Moved) and options.changes else None
        if last is not None:
            knob.arm()
            knob.stream_local_model(**last)
    return any(one.category is StiffnessWarning for one in caught)


def _cost(case: Case, motion: Motion) -> float:
    """Give less for a worse knob.

    The logarithm lets the optimiser see the smallest swing, and a swing that dies slowly is a step
    towards one that does not.
    """
    count_rad = 2.0 * math.pi / case.counts
    wide = (motion.swing_rad + _SLOW * motion.before_rad) / max(
        LASTING_RAD, REST_COUNTS * count_rad
    )
    return -math.log(1e-6 + wide + motion.loud_nm / LOUD_NM + max(0.0, motion.work_w) / 1e-3)


def _worst_lasting(
    case: Case, values: Sequence[dict[str, float]]
) -> tuple[Motion, dict[str, float], bool]:
    """Give the first values that break the law for long unwarned, or else warned, or the first.

    They come with what they do and whether `play` warns of them.
    """
    found = [(confirm(case, options_of(case, value)), value) for value in values]
    lasting = [
        (motion, value, is_warned_of(options_of(case, value)))
        for motion, value in found
        if breaks(case, motion)
    ]
    return min(lasting, key=lambda one: one[2], default=(*found[0], False))


def search(case: Case, tries: int) -> dict[str, float]:
    """Look for the worst of a case; give it with what it did, and how many tries it took."""
    random = np.random.default_rng([38, case.number])

    def start() -> cma.CMAEvolutionStrategy:
        return cma.CMAEvolutionStrategy(
            random.uniform(0.2, 0.8, len(SPACE)), 0.3,
            {"bounds": [0, 1], "popsize": _POPULATION, "seed": case.number + 1, "verbose": -9},
        )  # fmt: skip

    strategy = start()
    done, worst = 0, []
    while done < tries:
        if strategy.stop():  # such as where every knob of a generation rests
            strategy = start()
        points = strategy.ask()
        motions = measure([options_of(case, values_of(point)) for point in points])
        costs = [_cost(case, motion) for motion in motions]
        strategy.tell(points, costs)
        done += len(points)
        least = int(np.argmin(costs))
        worst.append((costs[least], points[least], breaks(case, motions[least])))
    # A wide swing that dies may hide a smaller one that lasts, so each that broke runs again.
    worst.sort(key=lambda one: one[0])
    broke = [point for _, point, broke in worst if broke]
    values = [values_of(point) for point in broke or [worst[0][1]]]
    motion, value, warned = _worst_lasting(case, values)
    return {
        "number": case.number, "tries": done, "breaks": float(breaks(case, motion)),
        "warned": float(warned), "broke_early": len(broke), **asdict(motion), **value,
    }  # fmt: skip


def evaluate_batch(batch: Batch) -> list[dict[str, float]]:
    """Search the cases of a batch; a row each."""
    return [search(case, batch.tries) for case in batch.designs]
