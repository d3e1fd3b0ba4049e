"""How far a scene may be stretched: where a simulation stops being true, where the knob swings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Final

import numpy as np

from torsio import perception
from torsio.closed_loop import LoopOptions, simulate, simulate_many
from torsio.errors import Error
from torsio.printed.beginnings import InitialState
from torsio.printed.hands import NoHand, TorqueHand
from torsio.printed.scenes import Effect, Periodic, Timing
from torsio.stability import SPEEDS_RAD_S
from torsio.telemetry import Record
from torsio.trading.runs import Variant
from torsio.trading.visits import Visit, effects_of, felt_nm, moved, steady_nm

__all__ = ["GENERATIONS", "Extreme", "extremes", "swings"]

_WEIGHTS: Final = (-0.6, -0.3, 0.3, 0.6)  # shares of the motor's torque
_HOLDABLE: Final = 0.85
GENERATIONS: Final = 3
_VARIED: Final = (6.0, 0.3, 0.3)  # speed in rad/s, weight, place in counts
_SETTLED_S, _WINDOW_S, _LASTING_RAD = 1.0, 0.2, 1e-3
_REST_COUNTS: Final = 3
_REVERSALS: Final = 4
_LADDERS: Final[dict[str, tuple[str, tuple[float, ...]]]] = {
    "stiffness": ("times", (1, 1.5, 2, 3, 5, 10, 30, 100, 1000)),
    # Slower than what is felt is sampled, nobody sees what happens between two ticks.
    "control rate": ("Hz", (20_000, 10_000, 5_000, 2_000, 1_000)),
    "less inertia": ("times", (1, 0.5, 0.2, 0.1, 0.01, 1e-3)),
    "more inertia": ("times", (1, 2, 5, 10, 100, 1000)),
    "angle": ("turns", (1, 1e3, 1e6, 1e8, 1e12)),
    # A wave's phase errs by ever more. Up to half a turn so does its torque, and one of these times
    # is at most a twelfth of a turn before that, whatever the wave.
    "duration": ("hours", tuple(float(f"{0.05 * 1.2**k:.3g}") for k in range(81))),
}
_SWINGS: Final = "the knob swings"
_ONLY: Final = "only the proposal swings", "the proposal does not swing"


@dataclass(frozen=True)
class Extreme:
    """How far one quantity may go.

    Attributes
    ----------
    quantity, unit
        The stretched quantity; stiffness and inertia are stretched by multiples.
    true_to
        The last step up to which the proposal stays within what was wanted, and swings only where
        the scene does; None: not even the first one.
    swings_at
        The first step at which the knob with all parts at the highest rate, thrown into the scene,
        swings; None: none of them.
    breaks, breaks_at
        The first thing that breaks, and the step; "" and None: nothing breaks.
    is_bounded
        False: `true_to` is the last step that was tried; the options may refuse the next.
    tried
        The steps.
    """

    quantity: str
    unit: str
    true_to: float | None
    swings_at: float | None
    breaks: str
    breaks_at: float | None
    is_bounded: bool
    tried: tuple[float, ...]


def extremes(
    options: LoopOptions,
    proposal: Variant,
    wanted: float,
    *,
    quick: bool,
    on_progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> list[Extreme]:
    """Stretch each quantity of a loop, step by step.

    A scene without stiffness has none to stretch. At each step 14 starts are tried whether the knob
    swings, and 42 more unless quick.

    At each step the proposal is compared with all parts at the highest rate, both stretched. Angle
    and duration are compared with the same visit near the zero, and at the beginning.
    """
    found = []
    generations = 0 if quick else GENERATIONS
    unstretched = _at("stiffness", 1, options, proposal, generations)
    for done, quantity in enumerate(_LADDERS):
        if quantity != "stiffness" or _scaled(quantity, options, 2.0).scene != options.scene:
            found.append(_stretch(quantity, options, proposal, wanted, generations, unstretched))
        on_progress(done + 1, len(_LADDERS))
    return found


def _stretch(
    quantity: str,
    options: LoopOptions,
    proposal: Variant,
    wanted: float,
    generations: int,
    unstretched: tuple[float, frozenset[str]],
) -> Extreme:
    unit, _ = _LADDERS[quantity]
    climbed = list(_climb(quantity, options, proposal, wanted, generations, unstretched))
    tried = tuple(step for step, _, _ in climbed)
    true_to = next((step for step, is_true, _ in reversed(climbed) if is_true), None)
    swings_at = next((step for step, _, broken in climbed if _SWINGS in broken), None)
    # What the scene does unstretched does not break.
    news = ((step, broken - unstretched[1]) for step, _, broken in climbed)
    breaks_at, breaks = next(
        ((step, " and ".join(sorted(new))) for step, new in news if new), (None, "")
    )
    bounded = true_to != (tried[-1] if tried else None)
    return Extreme(quantity, unit, true_to, swings_at, breaks, breaks_at, bounded, tried)


def _climb(
    quantity: str,
    options: LoopOptions,
    proposal: Variant,
    wanted: float,
    generations: int,
    unstretched: tuple[float, frozenset[str]],
) -> Iterator[tuple[float, bool, frozenset[str]]]:
    """Give each step, whether the proposal is true up to there, and what is the matter.

    Ends where the options do, and where it only gets worse.
    """
    unit, steps = _LADDERS[quantity]
    is_true, swings = True, False
    for step in steps:
        is_as_before = step == 1 and unit == "times"
        found = (
            unstretched
            if is_as_before
            else _outcome(quantity, step, options, proposal, generations)
        )
        if found is None:
            return
        jnds, broken = found
        is_true = is_true and jnds <= wanted and broken.isdisjoint(_ONLY)
        swings = swings or _SWINGS in broken
        if wanted < jnds < math.inf:
            broken |= {f"the error is {perception.text(jnds)}"}
        yield step, is_true, broken
        if not is_true and (swings or not math.isfinite(jnds)):
            return


def _outcome(
    quantity: str, step: float, options: LoopOptions, proposal: Variant, generations: int
) -> tuple[float, frozenset[str]] | None:
    """Give what `_at` does, or what has failed there; None past the options' own limits."""
    try:
        return _at(quantity, step, options, proposal, generations)
    except (Error, ValueError):
        return None
    except RuntimeError as failure:
        return math.inf, frozenset({str(failure).partition(";")[0]})


def _at(
    quantity: str, step: float, options: LoopOptions, proposal: Variant, generations: int
) -> tuple[float, frozenset[str]]:
    """Give the proposal's error at a step in JNDs, and what is the matter there."""
    duration_s = Visit().lasts_s(options.hand)
    options = Visit().of(options)
    true, less = Variant().of(options), proposal.of(options)
    turned_rad = 0.0
    if quantity == "control rate":
        less = replace(less, control_period_ns=round(1e9 / step))
    elif quantity == "angle":
        true, less = less, _turned(less, step)
        turned_rad = 2.0 * math.pi * round(step)
    elif quantity == "duration":
        ticks = round(step * 3600 * 1e9 / less.control_period_ns)
        true, less = _later(less, ticks), replace(less, first_tick=ticks)
    else:
        true, less = (_scaled(quantity, one, step) for one in (true, less))
    felt, runs = [], []
    for one, back_rad in ((true, 0.0), (less, turned_rad)):
        every = max(1, round(1_000_000 / one.control_period_ns))
        run = simulate(one, duration_s=duration_s, record_every=every)
        run["angle_rad"] -= back_rad
        runs.append(run)
        felt.append(
            np.interp(_times_s(duration_s), run["time_s"], felt_nm(run, one.plant, one.hand))
        )
    broken = {
        words
        for name, words in (
            ("motor_saturated", "the motor gives all it can"),
            ("brake_saturated", "the brake holds all it can"),
            ("numeric_error", "the scene's torque is no number"),
        )
        if runs[1][name].any()
    }
    if quantity not in ("angle", "duration"):
        scene, lesser = (swings(one, generations) for one in (true, less))
        broken |= {_SWINGS} if scene else set()
        broken |= {_ONLY[scene]} if lesser != scene else set()
    return perception.torque_jnds(steady_nm(felt[1] - felt[0])), frozenset(broken)


def _times_s(duration_s: float) -> np.typing.NDArray[np.float64]:
    return np.asarray(np.arange(round(1e3 * duration_s)) * 1e-3, dtype=np.float64)


def _scaled(quantity: str, options: LoopOptions, factor: float) -> LoopOptions:
    if quantity == "stiffness":
        scene = [_stiffer(effect, factor) for effect in effects_of(options.scene)]
        return replace(options, scene=scene)
    inertia = factor * options.plant.knob_inertia_kg_m2
    return replace(options, plant=replace(options.plant, knob_inertia_kg_m2=inertia))


def _stiffer(effect: Any, factor: float) -> Effect:
    """Scale a stiffness, or else the torque of an effect along the turn, which is as stiff."""
    values, changes = vars(effect), dict[str, Any]()
    if "stiffness_nm_per_rad" in values:
        changes["stiffness_nm_per_rad"] = factor * values["stiffness_nm_per_rad"]
    elif "torque_nm" in values and "timing" not in values:
        torque = values["torque_nm"]
        several = isinstance(torque, tuple)
        changes["torque_nm"] = [factor * one for one in torque] if several else factor * torque
    scaled: Effect = replace(effect, **changes)
    return scaled


def _turned(options: LoopOptions, turns: float) -> LoopOptions:
    """Begin whole turns away, where the device's zero then is; the hand goes there too."""
    hand = options.hand
    if not isinstance(hand, TorqueHand):
        hand = moved(hand, lambda at_s, rad: (at_s, rad + 2.0 * math.pi * turns))
    initial = replace(options.initial or InitialState(), revolutions=round(turns))
    return replace(options, hand=hand, initial=initial)


def _later(options: LoopOptions, ticks: int) -> LoopOptions:
    """Give the scene as it is after so many ticks, with waves put there in whole numbers."""
    passed_s = Fraction(ticks * options.control_period_ns, 10**9)
    scene: list[Any] = []
    effect: Any
    for effect in effects_of(options.scene):
        values = vars(effect)
        if "timing" not in values:
            scene.append(effect)
        elif values["timing"].duration_s == 0.0:
            changes: dict[str, Any] = {"timing": Timing()}
            if isinstance(effect, Periodic):
                waves = passed_s * Fraction(effect.frequency_hz)
                changes["phase_turns"] = float((Fraction(effect.phase_turns) + waves) % 1)
            scene.append(replace(effect, **changes))
    return replace(options, scene=scene)


def swings(options: LoopOptions, generations: int) -> bool:
    """Throw the knob into the scene and press it, both ways; say whether it swings for ever.

    Each further generation varies the start after which it swung most.
    """
    starts = [(way * speed, 0.0, 0.0) for speed in SPEEDS_RAD_S for way in (-1.0, 1.0)]
    starts += [(0.0, share, 0.0) for share in _WEIGHTS]
    random = np.random.default_rng(1)
    for _ in range(1 + generations):
        thrown = [_thrown(options, *start) for start in starts]
        runs = simulate_many(thrown, duration_s=_SETTLED_S + _WINDOW_S)
        if any(_lasts(run, options) for run in runs):
            return True
        worst = starts[int(np.argmax([_swing_rad(run) for run in runs]))]
        varied = worst + random.normal(0.0, _VARIED, (len(starts), 3))
        starts = [(float(speed), float(share), float(place)) for speed, share, place in varied]
    return False


def _thrown(
    options: LoopOptions, speed_rad_s: float, share: float, place_counts: float
) -> LoopOptions:
    weight_nm = max(-_HOLDABLE, min(share, _HOLDABLE)) * options.plant.motor_limit_nm
    phase = options.plant.encoder_phase_counts + place_counts % 1.0
    return replace(
        options,
        hand=TorqueHand(torque_nm=weight_nm) if weight_nm else NoHand(),
        initial=InitialState(speed_rad_s=speed_rad_s),
        plant=replace(options.plant, encoder_phase_counts=phase),
    )


def _swing_rad(run: Record) -> float:
    """Give by how much a knob turns to and fro late, not away."""
    angle = run["angle_rad"][run["time_s"] >= _SETTLED_S]
    return float(np.ptp(angle) - abs(angle[-1] - angle[0]))


def _lasts(run: Record, options: LoopOptions) -> bool:
    late = run[run["time_s"] >= _SETTLED_S]
    speed = late["speed_rad_s"][late["speed_rad_s"] != 0.0]
    reversals = np.count_nonzero(np.diff(np.sign(speed)))
    least_rad = max(_LASTING_RAD, _REST_COUNTS * 2.0 * math.pi / options.plant.counts_per_rev)
    return bool(reversals >= _REVERSALS and np.ptp(late["angle_rad"]) > least_rad)
