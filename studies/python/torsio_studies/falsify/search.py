"""One search: CMA-ES over a case, and what is measured of each try."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Final

import cma
import numpy as np
import numpy.typing as npt

from torsio.batch import Knobs
from torsio.closed_loop import LoopOptions
from torsio.perception import VIBRATION_NM, vibration_nm
from torsio_studies.falsify.cases import SPACE, Batch, Case, options_of, values_of

__all__ = ["LASTING_RAD", "LOUD_NM", "Motion", "breaks", "evaluate_batch", "measure"]

Array = npt.NDArray[np.float64]

LASTING_RAD: Final = 1e-3
REST_COUNTS: Final = 3
"""A knob that moves by more than either, whichever is larger, swings."""
LOUD_NM: Final = VIBRATION_NM
"""Root mean square of the motor's torque at rest, above 20 Hz."""
_RATE_HZ: Final = 2500  # at which a window is looked at
_WINDOW_S: Final = 0.2
_FIRST_S, _CONFIRMED_S = 1.8, 6.0  # after which the window begins
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
        What the motor gives to it.
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
    """Run loops of one control period, and measure each from `after_s` on."""
    rate_hz = round(1e9 / options[0].control_period_ns)
    knobs = Knobs(len(options), list(options), threads=1)
    knobs.step(round(after_s / 3.0 * rate_hz))
    before, _ = _watch(knobs, rate_hz)
    knobs.step(round((after_s * 2.0 / 3.0) * rate_hz))
    angle, torque = _watch(knobs, rate_hz)
    loud = vibration_nm(torque, _RATE_HZ)
    work = np.sum(torque[:-1] * np.diff(angle, axis=0), axis=0) / _WINDOW_S
    swing, slow = np.ptp(angle, axis=0), np.ptp(before, axis=0)
    return [Motion(*map(float, one)) for one in zip(swing, work, loud, slow, strict=True)]


def _watch(knobs: Knobs, rate_hz: int) -> tuple[Array, Array]:
    angle, torque = (np.empty((round(_WINDOW_S * _RATE_HZ), len(knobs))) for _ in range(2))
    for row in range(len(angle)):
        knobs.step(rate_hz // _RATE_HZ)
        angle[row], torque[row] = knobs.states["angle_rad"], knobs.states["motor_torque_nm"]
    return angle, torque


def swings(case: Case, motion: Motion) -> bool:
    """Say whether a motion is a swing and no flicker of the encoder."""
    return motion.swing_rad > max(LASTING_RAD, REST_COUNTS * 2.0 * math.pi / case.counts)


def breaks(case: Case, motion: Motion) -> bool:
    """Say whether a motion that lasts is a counter-example."""
    return swings(case, motion) or motion.loud_nm > LOUD_NM


def _cost(case: Case, motion: Motion) -> float:
    """Give less for what is worse.

    The logarithm lets the optimiser see the smallest swing, and what dies slowly is a step on the
    way to what does not.
    """
    count_rad = 2.0 * math.pi / case.counts
    wide = (motion.swing_rad + _SLOW * motion.before_rad) / max(
        LASTING_RAD, REST_COUNTS * count_rad
    )
    return -math.log(1e-6 + wide + motion.loud_nm / LOUD_NM + max(0.0, motion.work_w) / 1e-3)


def search(case: Case, tries: int) -> dict[str, float]:
    """Look for the worst of a case; give it with what it did, and how many tries it took."""
    random = np.random.default_rng([36, case.number])

    def begin() -> cma.CMAEvolutionStrategy:
        return cma.CMAEvolutionStrategy(
            random.uniform(0.2, 0.8, len(SPACE)), 0.3,
            {"bounds": [0, 1], "popsize": _POPULATION, "seed": case.number + 1, "verbose": -9},
        )  # fmt: skip

    strategy = begin()
    done, best, least = 0, np.full(len(SPACE), 0.5), math.inf
    while done < tries:
        if strategy.stop():  # such as where every knob of a generation rests
            strategy = begin()
        points = strategy.ask()
        motions = measure([options_of(case, values_of(point)) for point in points])
        costs = [_cost(case, motion) for motion in motions]
        strategy.tell(points, costs)
        done += len(points)
        if min(costs) < least:
            least, best = min(costs), points[int(np.argmin(costs))]
    value = values_of(best)
    lasting = measure([options_of(case, value)], _CONFIRMED_S)[0]
    return {
        "number": case.number, "tries": done, "breaks": float(breaks(case, lasting)),
        **asdict(lasting), **value,
    }  # fmt: skip


def evaluate_batch(batch: Batch) -> list[dict[str, float]]:
    """Search the cases of a batch; a row each."""
    return [search(case, batch.tries) for case in batch.designs]
