"""Sentences of the warnings that a knob gives."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from torsio.errors import DisarmedWarning, HeldLowWarning, NoSpeedLimitWarning, SceneWarning
from torsio.printed.scenes import Effect
from torsio.printed.told import Disarm, Limits

__all__ = ["armed_late", "disarmed", "held_low", "never_armed", "no_speed_limit", "unlikely"]

_TORQUES = ("torque_nm", "amplitude_nm", "offset_nm", "start_torque_nm", "end_torque_nm")
_ANGLES = ("angle_rad", "lower_rad", "upper_rad")
_TURNS = 5.0
# Torque of a knob with plausible parts.
_GIVEN_BY_ANY_NM = 0.1


def unlikely(effects: list[Effect], limits: Callable[[], Limits]) -> Iterator[SceneWarning]:
    """Say what in a scene is hardly meant; the knob is asked for its limits only if it matters."""
    for of in effects:
        for name in _ANGLES:
            angle_rad = float(getattr(of, name, 0.0))
            turns = abs(angle_rad) / math.tau
            if turns > _TURNS:
                yield SceneWarning(
                    f"{type(of).__name__}: {name} is {angle_rad:g} rad, {turns:.3g} turns away; if "
                    f"degrees are meant, write {name}=torsio.deg({angle_rad:g})"
                )
                break
    torques = (np.abs(getattr(of, name, 0.0)).max() for of in effects for name in _TORQUES)
    torque_nm = float(max(torques, default=0.0))
    if torque_nm <= _GIVEN_BY_ANY_NM:
        return
    most = limits()
    # For a board that is held low, arm() warns.
    if torque_nm > most.motor_torque_max_nm + most.brake_torque_max_nm and not most.held_low:
        yield SceneWarning(
            f"the scene asks for {torque_nm:g} N m; this knob's motor gives "
            f"{most.motor_torque_max_nm:g} and its brake {most.brake_torque_max_nm:g} "
            "(Knob.limits()). Telemetry's desired_torque_nm ends at 0.3277"
        )


def held_low(limits: Limits) -> HeldLowWarning:
    """Tell how little a board with unconfirmed or unknown parts gives, and how to end that."""
    return HeldLowWarning(
        f"nobody has confirmed the parts of this board, or their values are assumed, so it gives "
        f"{1e3 * limits.motor_torque_max_nm:.3g} mN m and {limits.speed_limit_rad_s:g} rad/s at "
        "most. Set the values of motor, brake and encoder (docs/how-to/hardware.md, first power), "
        "call knob.update(confirmed=True) and knob.save(), and calibrate. If you are sure of the "
        "values, call knob.update(values_are='stated') instead"
    )


def no_speed_limit() -> NoSpeedLimitWarning:
    """Say that nothing stops a knob that runs away, and what would."""
    return NoSpeedLimitWarning(
        "this board has no speed limit, so nothing stops a knob that runs away. Set one with "
        "knob.update(speed_limit_rad_s=...) and knob.save() (docs/how-to/hardware.md, first power)"
    )


def disarmed(disarm: Disarm) -> DisarmedWarning:
    """Say when and why the torque went during a recording."""
    return DisarmedWarning(
        f"the torque went during the recording, at tick {disarm.tick} "
        f"({', '.join((disarm.reason, *disarm.faults))}); "
        "must_stay_armed raises an error instead"
    )


def never_armed() -> DisarmedWarning:
    """Say that a scene was recorded that nobody could feel."""
    return DisarmedWarning(
        "a scene plays and the knob was disarmed throughout the recording, so nothing was felt: "
        "call arm() before record()"
    )


def armed_late() -> DisarmedWarning:
    """Say that there was no torque at first."""
    return DisarmedWarning(
        "the recording begins without torque and ends armed; "
        "must_stay_armed raises an error instead"
    )
