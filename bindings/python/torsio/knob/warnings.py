"""Sentences of the warnings that a knob gives."""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable, Iterator
from dataclasses import fields
from functools import cache
from itertools import takewhile
from traceback import walk_stack
from typing import Any

from torsio.errors import DisarmedWarning, HeldLowWarning, NoSpeedLimitWarning, SceneWarning
from torsio.printed.scenes import Detents, Effect, Friction, Texture, Timing
from torsio.printed.told import Disarm, Limits

__all__ = [
    *("armed_late", "disarmed", "held_low", "never_armed", "no_speed_limit", "unlikely", "warn"),
]

# Beyond these an angle is hardly meant: turns of any angle, radians of a whole or half number.
_TURNS = 5.0
_ROUND_RAD = {"pitch_rad": 1.0}
_TORQUES = {"torque_nm", "offset_nm", "start_torque_nm", "end_torque_nm"}
_BOTH_WAYS = (Detents, Friction, Texture)
# Torque of a knob with plausible parts.
_GIVEN_BY_ANY_NM = 0.01
_ROUNDING = 1.0 + 1e-6
_AT_ALL_TIMES = Timing()


def warn(warning: Warning) -> None:
    """Warn of the line of the program, however many of the library's are in between."""
    modules = (frame.f_globals.get("__name__", "") for frame, _ in walk_stack(sys._getframe()))
    own = takewhile(lambda name: name.partition(".")[0] == "torsio", modules)
    warnings.warn(warning, stacklevel=1 + len(list(own)))


def unlikely(effects: list[Effect], limits: Callable[[], Limits]) -> list[SceneWarning]:
    """Say what in a scene is hardly meant; the knob is asked for its limits only if it matters."""
    odd = []
    asking = []
    for of in effects:
        angles, torques = _names(type(of))
        if torques:
            asking.append(of)
        for name in angles:
            given = getattr(of, name)
            if given and not -1.0 <= given <= 1.0 and (found := _degrees(of, name, float(given))):
                odd.append(found)
                break
    if asking:
        odd += _too_much(asking, limits)
    return odd


def _too_much(effects: list[Effect], limits: Callable[[], Limits]) -> Iterator[SceneWarning]:
    asked_nm = _most_nm(effects)
    if asked_nm <= _GIVEN_BY_ANY_NM:
        return
    pushed_nm = _most_nm([of for of in effects if not isinstance(of, Friction)])
    most = limits()
    motor_nm, brake_nm = most.motor_torque_max_nm, most.brake_torque_max_nm
    is_given = pushed_nm <= _ROUNDING * motor_nm and asked_nm <= _ROUNDING * (motor_nm + brake_nm)
    # For a board that is held low, arm() warns.
    if not is_given and not most.held_low:
        yield SceneWarning(
            f"the scene asks for up to {asked_nm:.4g} N m; this knob's motor gives {motor_nm:g}, "
            f"and its brake {brake_nm:g} more against a turning hand alone (Knob.limits()). "
            "Telemetry's desired_torque_nm ends at 0.3277"
        )


def _names_of(kind: Any) -> tuple[list[str], set[str]]:
    """Give the names of an effect's angles and of its torques."""
    names = [of.name for of in fields(kind)]
    angles = [of for of in names if of.endswith("_rad") and not of.endswith("_per_rad")]
    return angles, _TORQUES.intersection(names)


_names: Callable[[Any], tuple[list[str], set[str]]] = cache(_names_of)


def _degrees(of: Effect, name: str, angle_rad: float) -> SceneWarning | None:
    """Tell of an angle that looks as if somebody had written degrees."""
    turns = abs(angle_rad) / math.tau
    is_round = (2.0 * angle_rad).is_integer()
    if (is_round and abs(angle_rad) > _ROUND_RAD.get(name, math.tau)) or turns > _TURNS:
        return SceneWarning(
            f"{type(of).__name__}: {name} is {angle_rad:g} radians, {turns:.3g} turns; if "
            f"degrees are meant, write {name}=torsio.deg({angle_rad:g})"
        )
    return None


def _most_nm(effects: list[Effect]) -> float:
    """Give the most torque either way that effects may have together at one time.

    Those that grow with depth, speed or acceleration have none.
    """
    asking = [(*_span_s(of), *_reach_nm(of)) for of in effects]
    most_nm = 0.0
    for moment_s, *_ in asking:
        plays = [(low, high) for begin_s, end_s, low, high in asking if begin_s <= moment_s < end_s]
        most_nm = max(most_nm, sum(high for _, high in plays), -sum(low for low, _ in plays))
    return most_nm


def _span_s(of: Effect) -> tuple[float, float]:
    timing = getattr(of, "timing", _AT_ALL_TIMES)
    return timing.delay_s, timing.delay_s + (timing.duration_s or math.inf)


def _reach_nm(of: Effect) -> tuple[float, float]:
    if isinstance(of, _BOTH_WAYS):
        return -of.torque_nm, of.torque_nm
    values = [0.0]
    for name in _names(type(of))[1]:
        nm = getattr(of, name)
        values += nm if isinstance(nm, tuple) else [float(nm)]
    wave_nm = getattr(of, "amplitude_nm", 0.0)
    return min(values) - wave_nm, max(values) + wave_nm


def held_low(limits: Limits) -> HeldLowWarning:
    """Tell how little a board with unconfirmed or unknown parts gives, and how to end that."""
    return HeldLowWarning(
        f"nobody has confirmed the parts of this board, or their values are assumed, so it gives "
        f"{1e3 * limits.motor_torque_max_nm:.3g} mN m and {limits.speed_limit_rad_s:g} rad/s at "
        "most. Set the values of motor, brake and encoder (docs/how-to/first-power.md), "
        "call knob.update(confirmed=True) and knob.save(), and calibrate. If you are sure of the "
        "values, call knob.update(values_are='stated') instead"
    )


def no_speed_limit() -> NoSpeedLimitWarning:
    """Say that nothing stops a knob that runs away, and what would."""
    return NoSpeedLimitWarning(
        "this board has no speed limit, so nothing stops a knob that runs away. Set one with "
        "knob.update(speed_limit_rad_s=...) and knob.save() (docs/how-to/first-power.md)"
    )


def disarmed(disarm: Disarm) -> DisarmedWarning:
    """Say when and why the torque went during a recording."""
    return DisarmedWarning(
        f"the torque went during the recording, at tick {disarm.tick} "
        f"({', '.join((disarm.reason, *disarm.faults))}); "
        "must_stay_armed raises an error instead"
    )


def never_armed() -> DisarmedWarning:
    """Say that a scene was recorded or read that nobody could feel."""
    return DisarmedWarning(
        "a scene plays and the knob was disarmed throughout, so nothing was felt: call arm() "
        "before you record or read telemetry"
    )


def armed_late() -> DisarmedWarning:
    """Say that there was no torque at first."""
    return DisarmedWarning(
        "the recording begins without torque and ends armed; "
        "must_stay_armed raises an error instead"
    )
