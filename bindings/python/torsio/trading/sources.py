"""Where the scene of a trade comes from: Python, a file of it, or a recording."""

from __future__ import annotations

import json
import runpy
import sys
from collections.abc import Iterable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from torsio.closed_loop import LoopOptions
from torsio.common import checks
from torsio.common.whole_file import text_of
from torsio.errors import Error, InvalidArgument
from torsio.printed.config import CONFIGS, ActuatorConfig, ShaftConfig
from torsio.printed.hands import Hand, PrescribedMotion
from torsio.printed.plant import (
    Belt,
    BrakeHysteresis,
    Cogging,
    Electrics,
    PlantParams,
    ShaftHardening,
)
from torsio.printed.scenes import Effect, Timing
from torsio.recordings.loading import Recorded, load
from torsio.stability import plant_of
from torsio.telemetry import Record
from torsio.trading.runs import PARTS, WHOLE, present
from torsio.trading.visits import effects_of, usual_hand

__all__ = ["EVERYTHING", "configuration_of", "configured", "options_of", "with_parts"]

EVERYTHING: Final = PlantParams(
    shaft_hardening=ShaftHardening(),
    brake_hysteresis=BrakeHysteresis(),
    belt=Belt(),
    cogging=Cogging.sine(periods_per_rev=12, amplitude_nm=2e-3),
    electrics=Electrics(),
    encoder_noise_counts=0.25,
)
"""The reference actuator with every part."""

_PATH_EVERY_S: Final = 0.01
_LONGEST_S: Final = 3600.0
_WAY_S, _WAY_RAD_S = 0.5, 5.0  # to where a path begins: least time, and speed
_OPTIONS: Final = {field.name for field in fields(LoopOptions)}
_KNOWN: Final[dict[str, Any]] = {
    **{"hand": Hand, "plant": PlantParams},
    **{name: kind for name, kind in CONFIGS.items() if name in _OPTIONS},
}


# A page calls them as the protocol does: end_stops.
_EFFECTS: Final[dict[str, Any]] = {kind.__name__.lower(): kind for kind in Effect.__subclasses__()}


def options_of(
    scene: Any, given: dict[str, Any], parts: Iterable[str] | None = None
) -> LoopOptions:
    """Give the closed loop of a scene with its hand, plant, of it only some parts, and control.

    Raises
    ------
    Error
        If a file has no scene, or a recording too little.
    TypeError
        If something is of another kind than it must be.
    """
    found: dict[str, Any] = {}
    if isinstance(scene, str | Path):
        path = Path(scene)
        found = _from_python(path) if path.suffix == ".py" else _from_recording(load(path))
        scene = found.pop("scene")
    elif isinstance(scene, Recorded):
        found = _from_recording(scene)
        scene = found.pop("scene")
    found |= {name: value for name, value in given.items() if value is not None}
    effects = effects_of(scene)
    for effect in effects:
        checks.kind("scene", effect, Effect, "effects, a file or a recording")
    for name, value in found.items():
        checks.kind(name, value, _KNOWN[name], f"a {_KNOWN[name].__name__}")
    plant = found.pop("plant", EVERYTHING)
    if parts is not None:
        plant = with_parts(plant, parts)
    # The device knows what it was calibrated to, whatever a simulation leaves out.
    beliefs = {"actuator": plant.matching_config(), "shaft": plant.matching_shaft()}
    if isinstance(found.get("hand"), PrescribedMotion):
        found["hand"] = _from_zero(found["hand"])
    return LoopOptions(
        scene=effects, **{"hand": usual_hand(effects), "plant": plant, **beliefs, **found}
    )


def _from_zero(hand: PrescribedMotion) -> PrescribedMotion:
    """Let a path begin at angle 0, where the device's zero is."""
    path = np.asarray(hand.angle_rad, dtype=np.float64)
    begin_rad = path[0, 1]
    if begin_rad == 0.0:
        return hand
    way_s = max(_WAY_S, abs(begin_rad) / _WAY_RAD_S)
    path[:, 0] += way_s - path[0, 0]
    return PrescribedMotion(angle_rad=[(0.0, 0.0), *path])


def _from_python(path: Path) -> dict[str, Any]:
    """Run a file that sets `scene`, and perhaps `hand`, `plant` and configurations."""
    beside = str(path.resolve().parent)
    sys.path.insert(0, beside)  # for its imports
    try:
        found = runpy.run_path(str(path))
    except OSError:
        raise
    except (Exception, SystemExit) as error:  # whatever the file raises
        raise Error(f"{path} fails: {type(error).__name__}: {error}") from error
    finally:
        sys.path.remove(beside)
    if found.get("scene") is None:
        raise Error(f"{path} sets no `scene`: write scene = torsio.Wall(...) in it")
    return {name: found[name] for name in ("scene", *_KNOWN) if found.get(name) is not None}


def _from_recording(recorded: Recorded) -> dict[str, Any]:
    """Take the last scene that is not empty, the configuration, and the motion until it ended."""
    orders = [of for of in recorded.events if of["kind"] in ("play", "playing", "stop")]
    played = [number for number, of in enumerate(orders) if of.get("scene")]
    if not played:
        raise Error("the recording has no scene: record in the program or page that plays it")
    last, *after = orders[played[-1] :]
    path = _path(recorded.telemetry, after[0]["device_time_s"] if after else np.inf)
    kept = recorded.metadata["configuration"]
    try:
        known = {
            name: kind(**kept[kind.__name__])
            for name, kind in _KNOWN.items()
            if kind.__name__ in kept
        }
        return {
            "scene": [_effect(one) for one in last["scene"]],
            "hand": PrescribedMotion(angle_rad=path),
            "plant": configured(known["actuator"], known["shaft"]),
            **known,
        }
    except (KeyError, TypeError) as error:
        raise Error(f"this version cannot read the recording, record anew: {error}") from None


def _path(telemetry: Record, until_s: float) -> Any:
    """Give time and angle of the armed knob until then, shape (n, 2)."""
    armed = telemetry[(telemetry["flags"] & 3 == 1) & (telemetry["time_s"] < until_s)]
    if len(armed) < 2:
        raise Error("the knob is not armed in the recording: arm it while you record")
    every = max(1, round(_PATH_EVERY_S / float(np.median(np.diff(armed["time_s"])))))
    # The mean of a hundredth of a second: steps of the encoder are no motion of the hand.
    whole = len(armed) // every * every
    rows = [armed[name][:whole].reshape(-1, every).mean(axis=1) for name in ("time_s", "angle_rad")]
    if len(rows[0]) < 2:
        lasts_s = armed["time_s"][-1] - armed["time_s"][0]
        raise Error(f"the knob is armed for {lasts_s:.3g} s in the recording: record a whole visit")
    if armed["time_s"][-1] - armed["time_s"][0] > _LONGEST_S:
        raise Error("the knob is armed for more than an hour in the recording: record one visit")
    return np.column_stack([rows[0] - rows[0][0], rows[1]])


def configured(actuator: ActuatorConfig, shaft: ShaftConfig) -> PlantParams:
    """Give the plant that a calibrated configuration tells of, with the parts that it cannot."""
    told = plant_of(actuator)
    knee = None
    if shaft.knee_1_rad > 0.0:  # a plant has one
        factor = shaft.knee_1_nm_per_rad / actuator.spring_stiffness_nm_per_rad
        knee = ShaftHardening(knee_rad=shaft.knee_1_rad, stiffness_factor=factor)
    width = actuator.brake_hysteresis_nm
    return replace(
        told,
        brake_inertia_kg_m2=actuator.brake_inertia_kg_m2 or told.brake_inertia_kg_m2,
        shaft_hardening=knee,
        brake_hysteresis=BrakeHysteresis(half_width_nm=width) if width > 0.0 else None,
        belt=EVERYTHING.belt,
        cogging=EVERYTHING.cogging,
        electrics=EVERYTHING.electrics,
        encoder_noise_counts=EVERYTHING.encoder_noise_counts,
    )


def with_parts(plant: PlantParams, names: Iterable[str]) -> PlantParams:
    """Leave a plant these parts. If it lacks one, `EVERYTHING` has it."""
    wanted, known = {*checks.each("parts", names, "several names")}, set(PARTS) - set(WHOLE)
    if unknown := wanted - known:
        raise InvalidArgument(
            f"there is no part {', '.join(sorted(unknown))}; there are {', '.join(sorted(known))}"
        )
    changes: dict[str, Any] = {}
    for name in known - wanted:
        changes |= PARTS[name]
    for name in wanted - {*present(plant)}:
        changes |= {field: getattr(EVERYTHING, field) for field in PARTS[name]}
    return replace(plant, **changes)


def configuration_of(path: Path) -> dict[str, Any]:
    """Read the text of `torsio config dump`: configurations, and the plant that they tell of."""
    text = text_of(path)
    try:
        read = json.loads(text)
        found: dict[str, Any] = {
            name: kind(**read.get(f"{name}_config", {}))
            for name, kind in _KNOWN.items()
            if name not in ("hand", "plant")
        }
        plant = configured(found["actuator"], found["shaft"])
    except (ValueError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
        reason = str(error).partition("; ")[0]  # without all names that there are
        raise InvalidArgument(f"{path} is no configuration of a knob: {reason}") from None
    return {**found, "plant": plant}


def _effect(values: dict[str, Any]) -> Effect:
    kind = _EFFECTS[str(values["type"]).replace("_", "").lower()]
    known = {field.name for field in fields(kind)}
    timing = {"timing": Timing(**values["timing"])} if "timing" in values else {}
    made: Effect = kind(**{k: v for k, v in values.items() if k in known} | timing)
    return made
