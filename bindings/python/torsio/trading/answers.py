"""`torsio.trade`: measures which parts of the simulation a scene needs."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Final

from torsio.batch import Knobs
from torsio.closed_loop import LoopOptions, reports
from torsio.common import checks
from torsio.errors import Error
from torsio.printed.config import ActuatorConfig, BoardConfig, ControlConfig, ShaftConfig
from torsio.printed.hands import Hand
from torsio.printed.plant import PlantParams
from torsio.printed.scenes import Scene
from torsio.recordings.loading import Recorded
from torsio.trading.extremes import GENERATIONS, Extreme, extremes, swings
from torsio.trading.found import Row, Trade, board_shares
from torsio.trading.runs import (
    HIGHEST_HZ,
    RATES_HZ,
    WHOLE,
    Kept,
    Runs,
    Variant,
    emulated_options,
    present,
    variants,
)
from torsio.trading.sources import options_of
from torsio.trading.visits import CHOOSE, Difference, Visit, effects_of, verifying

__all__ = ["trade", "trade_loop"]

Progress = Callable[[str, int, int], None]

_TIMED: Final = 6  # of the cheapest proposals, timed again in turns
_ROUNDS: Final = 3
_SAME: Final = 1.1  # times as dear, which a busy machine cannot tell
_TOGETHER: Final = 64
_CONFIGURATION_REPORTS: Final = 3
_REPORT_BYTES: Final = 64


def trade(
    scene: Scene | str | Path | Recorded,
    *,
    hand: Hand | None = None,
    plant: PlantParams | None = None,
    parts: Iterable[str] | None = None,
    wanted_jnds: float = 0.5,
    control: ControlConfig | None = None,
    actuator: ActuatorConfig | None = None,
    shaft: ShaftConfig | None = None,
    board: BoardConfig | None = None,
    quick: bool = False,
    stretch: bool = True,
    resume: str | Path | None = None,
    threads: int | None = None,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> Trade:
    """Find out which parts, and which control rate, the simulation of a scene needs.

    The scene is played with all parts at 20 kHz. Then parts are left out, the rate, the encoder and
    the law are changed, and each run is compared with the first one. Nothing is estimated.

    Parameters
    ----------
    scene
        Effects; a Python file that sets `scene`, and perhaps any of the parameters below; or a
        recording, whose configuration and measured motion then count.
    hand
        The hand that visits the scene. None: fingers that turn through it, press, and come back.
    plant
        The knob with all its parts. None: the reference actuator with every part.
    parts
        Parts that the knob has, such as "belt"; the reference's if `plant` lacks one. None: all.
    wanted_jnds
        How much of the torque that is felt may differ, in JNDs of 7.6 mN m; > 0.
    control, actuator, shaft, board
        The device's configuration. None: its default law, and the plant's true values.
    quick
        Leave out one part, or all of them, in place of every combination.
    stretch
        Find the extremes too.
    resume
        A file for the measurements: an interrupted trade goes on from there. A `FeedbackHand` is
        known by its address in memory, so its trade begins anew.
    on_progress
        Called with the present task, the finished share, and the whole.

    Raises
    ------
    Error, ValueError, TypeError
        Scene, file or options are wrong, or the hand never touches the scene.
    """
    checks.positive("wanted_jnds", wanted_jnds)
    checks.flag("quick", quick)
    checks.flag("stretch", stretch)
    checks.function("on_progress", on_progress)
    options = options_of(
        scene,
        {
            "hand": hand, "plant": plant, "control": control, "actuator": actuator,
            "shaft": shaft, "board": board,
        },
        parts,
    )  # fmt: skip
    if not options.scene:
        raise Error("scene has no effect: give one that can be felt")
    kept = None if resume is None else checks.path("resume", resume)
    return trade_loop(
        options, wanted=wanted_jnds, quick=quick, stretch=stretch, keep=kept, threads=threads,
        on_progress=on_progress,
    )  # fmt: skip


def trade_loop(
    options: LoopOptions,
    *,
    wanted: float,
    quick: bool,
    stretch: bool,
    keep: str | Path | None,
    threads: int | None,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> Trade:
    """Trade a closed loop, which has all of it; else as `trade`."""
    kept = Kept(None if keep is None else checks.path("keep", keep))
    runs = Runs(options, kept, checks.threads(threads))
    if options.scene and not runs.reference(CHOOSE[0])["desired_torque_nm"].any():
        raise Error("the hand never touches the scene: give a hand that does, or another recording")
    tried = variants(options, quick=quick)
    found = runs.measure(tried, CHOOSE, lambda *done: on_progress("trying", *done))
    if quick:
        harmless = _most_harmless(tried, found)
        tried += harmless
        found += runs.measure(harmless, CHOOSE)
    rows = _with_front(
        [_row(one.name, one, runs, *of) for one, of in zip(tried, found, strict=True)]
    )
    generations = 0 if quick else GENERATIONS
    scene_swings = swings(Variant().of(options), generations)

    def alike(variant: Variant) -> bool:
        return swings(variant.of(options), generations) == scene_swings

    proposal, verified, device = _proposed(rows, runs, wanted, alike, on_progress)
    whole = _on_device(Variant(), runs, verifying(0)[0])
    rows += [_in_batch(proposal, runs), *dict.fromkeys((whole, device))]
    stretched: list[Extreme] = []
    if stretch:
        stretched = extremes(
            options, proposal.variant, wanted, quick=quick,
            on_progress=lambda *done: on_progress("stretching", *done),
        )  # fmt: skip
    return Trade(
        wanted_jnds=wanted,
        scene=tuple(effects_of(options.scene)),
        swings=scene_swings,
        rows=tuple(rows),
        proposal=proposal,
        options=emulated_options(proposal.variant.of(options)),
        verified=verified,
        on_device=device,
        boards=board_shares(options.scene, options.control),
        scene_bytes=_REPORT_BYTES * (len(reports(options)) - _CONFIGURATION_REPORTS),
        extremes=tuple(stretched),
    )


def _most_harmless(tried: list[Variant], found: list[tuple[Difference, float]]) -> list[Variant]:
    """Give the two, three, ... parts that change least alone, left out together at low rates."""
    alone = {
        one.left_out[0]: difference.largest_nm
        for one, (difference, _) in zip(tried, found, strict=True)
        if len(one.left_out) == 1 and one.rate_hz == HIGHEST_HZ and one.left_out[0] not in WHOLE
    }
    least = sorted(alone, key=lambda part: alone[part])
    return [
        Variant(left_out=tuple(part for part in alone if part in least[:count]), rate_hz=rate_hz)
        for count in range(2, len(least))
        for rate_hz in (RATES_HZ[-1], RATES_HZ[-2])
    ]


def _row(
    name: str,
    variant: Variant,
    runs: Runs,
    difference: Difference,
    cpu_s: float,
    wire_bytes_per_s: float | None = None,
) -> Row:
    control = variant.of(runs.options).control
    boards = board_shares(runs.options.scene, control, 1e9 / variant.rate_hz)
    return Row(name, variant, difference, cpu_s, boards, wire_bytes_per_s)


def _with_front(rows: list[Row]) -> list[Row]:
    best, front = float("inf"), set[str]()
    may = (row for row in rows if row.variant.may_be_proposed)
    for row in sorted(may, key=lambda row: (row.cpu_s, row.difference.largest_nm)):
        if row.difference.largest_nm < best:
            best = row.difference.largest_nm
            front.add(row.name)
    return [replace(row, is_on_front=row.name in front) for row in rows]


def _proposed(
    rows: list[Row],
    runs: Runs,
    wanted: float,
    swings_alike: Callable[[Variant], bool],
    on_progress: Progress,
) -> tuple[Row, Difference, Row]:
    """Give the cheapest row that holds, how it was verified, and how on the device.

    After a failure what leaves out as much is not tried. The rest must be truer, by as much as the
    verification was worse than the visits before. At last this leaves the reference alone.
    """
    left = _Left(rows, wanted)
    begun = len(left.rows)
    for number in count():
        on_progress("verifying", begun - len(left.rows), begun)
        proposal = left.cheapest(runs.options, swings_alike)
        chosen, visits = proposal.variant, verifying(number)
        ((verified, _),) = runs.measure([chosen], visits)
        device = _on_device(chosen, runs, visits[0])
        worst = max(verified.jnds, device.difference.jnds)
        if worst <= wanted or chosen == Variant():
            break
        left.leave_out(chosen)
        if verified.jnds > wanted:
            left.look_again(runs, visits)
        left.keep_below(wanted * max(left.errors[chosen], verified.jnds) / worst)
    on_progress("verifying", begun, begun)
    return proposal, verified, device


class _Left:
    """Rows that may still be proposed, and the largest error that was seen of each."""

    def __init__(self, rows: Iterable[Row], wanted: float) -> None:
        self.rows = [row for row in rows if row.variant.may_be_proposed]
        self.errors = {row.variant: row.difference.jnds for row in self.rows}
        self.keep_below(wanted)

    def cheapest(self, options: LoopOptions, swings_alike: Callable[[Variant], bool]) -> Row:
        while not swings_alike((proposal := _choose(self.rows, options)).variant):
            self.rows.remove(proposal)
        return proposal

    def leave_out(self, failed: Variant) -> None:
        self.rows = [row for row in self.rows if not row.variant.leaves_out_all_of(failed)]

    def look_again(self, runs: Runs, visits: tuple[Visit, ...]) -> None:
        variants = [row.variant for row in self.rows]
        for one, (seen, _) in zip(variants, runs.measure(variants, visits), strict=True):
            self.errors[one] = max(self.errors[one], seen.jnds)

    def keep_below(self, jnds: float) -> None:
        self.rows = [row for row in self.rows if self.errors[row.variant] <= jnds]


def _choose(rows: list[Row], options: LoopOptions) -> Row:
    """Give the cheapest row; the first ones are timed again, in turns."""
    first = sorted(rows, key=lambda row: row.cpu_s)[:_TIMED]
    times = [[row.cpu_s] for row in first]
    for _ in range(_ROUNDS):
        for row, so_far in zip(first, times, strict=True):
            so_far.append(_batch_cpu_s(row.variant.of(options), 1, 0.5))
    cpu_s = [min(of) for of in times]
    same = [row for row, one in zip(first, cpu_s, strict=True) if one <= _SAME * min(cpu_s)]
    parts = {*present(options.plant)}
    # If several cost the same: the one with the fewest parts, then the truest.
    return min(same, key=lambda row: (len(parts - {*row.variant.lacks}), row.difference.largest_nm))


def _on_device(variant: Variant, runs: Runs, visit: Visit) -> Row:
    return _row(f"whole device, {variant.name}", variant, runs, *runs.on_device(variant, visit))


def _batch_cpu_s(options: LoopOptions, knobs: int, duration_s: float) -> float:
    together = Knobs(knobs, options, threads=1)
    begin_s = time.thread_time()
    together.step(max(1, round(1e9 * duration_s / options.control_period_ns)))
    return (time.thread_time() - begin_s) / duration_s / knobs


def _in_batch(proposal: Row, runs: Runs) -> Row:
    """Play the proposal's first visit in `torsio.batch`, millisecond by millisecond."""
    visit = CHOOSE[0]
    options = proposal.variant.of(visit.of(runs.options))
    knobs = Knobs(1, options, seeds=options.seed, threads=1)
    rows = runs.reference(visit).copy()
    for row in range(len(rows)):
        if row:
            knobs.step(round(1e6 / options.control_period_ns))
        rows[row] = knobs.states[0]
    difference = runs.difference(proposal.variant, visit, rows)
    cpu_s = _batch_cpu_s(options, _TOGETHER, 0.2)
    return _row(f"torsio.batch, {proposal.name}", proposal.variant, runs, difference, cpu_s)
