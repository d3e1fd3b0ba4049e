"""Choices of the search: plant, beliefs, scene, hand, rate and encoder.

A case fixes each choice among several. The optimiser moves the rest, each between 0 and 1.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, replace
from typing import Final, Literal, NamedTuple, get_args

import numpy as np

from torsio import (
    ActuatorConfig,
    BoardConfig,
    Constant,
    ControlConfig,
    Curve,
    Damper,
    Detents,
    EndStops,
    Friction,
    Impact,
    Inertia,
    Periodic,
    Ramp,
    Spring,
    Texture,
    Timing,
    Wall,
)
from torsio.closed_loop import InitialState, LoopOptions
from torsio.printed.config import Law
from torsio.printed.hands import Hand, ImpedanceHand, NoHand, TorqueHand
from torsio.printed.plant import (
    Belt,
    BrakeHysteresis,
    Cogging,
    Electrics,
    PlantParams,
    ShaftHardening,
)
from torsio.printed.scenes import Effect

__all__ = [
    "HANDS",
    "SCENES",
    "SPACE",
    "Batch",
    "Case",
    "Moved",
    "SceneName",
    "batches",
    "options_of",
]

SceneName = Literal["wall", "spring", "limited spring", "facing walls", "stops", "detents", "sum"]
HandName = Literal["thrown", "weight", "released", "held"]
SCENES: Final[tuple[SceneName, ...]] = get_args(SceneName)
HANDS: Final[tuple[HandName, ...]] = get_args(HandName)
ExtraName = Literal["nothing", "damper", "damped wall", "inertia", "texture", "impact"]
EXTRAS: Final[tuple[ExtraName, ...]] = get_args(ExtraName)
AlsoName = Literal["nothing", "constant", "ramp", "periodic", "friction", "stream"]
ALSO: Final[tuple[AlsoName, ...]] = get_args(AlsoName)
FRAMES_S: Final = (1e-3, 4e-3, 16e-3)
RATES_HZ: Final = (10_000, 20_000)
COUNTS: Final = (2048, 8192, 32_768, 131_072)
GAPS_RAD: Final = (0.04, 0.4, 4.0, 12.0)  # the first is a search's own, less for stiff walls

_HOLDABLE: Final = 0.85  # share of the largest torque that a weight may have
_HOLDABLE_BY_DETENTS: Final = 0.5  # a weight that comes quickly overshoots, and then rolls on
_AT_RAD: Final = 0.05
_SIMPLE_LOOP: Final = Electrics(predictive=False, current_period_s=0.0, output_delay_s=100e-6)
_ALSO_NM: Final = 50e-3
_MOST_NM_S_PER_RAD: Final = 0.06
_PUSHED_S: Final = 0.1  # by then a weight hangs, and a scene begins to move
_SETTLED_S: Final = 0.3  # by then a hand and a scene that moves are done
_LEFT_S: Final = 0.5  # the same, for one that leaves

# A hidden knob's values over the reference actuator, and its device's beliefs over the truth.
_TRUE: Final = (
    *("knob_inertia_kg_m2", "knob_viscous_nm_s_per_rad", "knob_coulomb_nm", "brake_inertia_kg_m2"),
    *("brake_drag_nm", "shaft_stiffness_nm_per_rad", "shaft_damping_nm_s_per_rad"),
    "brake_time_constant_s",
)
_NEARLY: Final = (0.7, 1.3)
_TOLD: Final = {
    "knob_inertia_kg_m2": _NEARLY,
    "knob_coulomb_nm": _NEARLY,
    "brake_inertia_kg_m2": _NEARLY,
    "spring_stiffness_nm_per_rad": _NEARLY,
    "brake_hysteresis_nm": _NEARLY,
    "motor_time_constant_s": _NEARLY,
    "brake_drag_nm": (0.5, 2.0),
    "brake_time_constant_s": (0.5, 2.0),
}
_GAINS: Final = ("motor_torque_constant_nm_per_a", "brake_torque_constant_nm_per_a")

SPACE: Final[dict[str, tuple[float, float]]] = {
    **{f"true.{name}": (0.5, 2.0) for name in _TRUE},
    **{f"told.{name}": bounds for name, bounds in _TOLD.items()},
    "loop_nm": (1e-4, 11e-3),
    "knee_rad": (3e-3, 50e-3),
    "knee_factor": (0.5, 2.0),
    "cogging_nm": (1e-5, 3e-3),
    "stiffness_nm_per_rad": (0.3, 1000.0),
    "limit_nm": (20e-3, 200e-3),
    "beta": (0.3, 0.9),
    "place_counts": (1.0, 2.0),
    "weight": (0.05, 1.0),
    "speed_rad_s": (0.3, 18.0),
    "hand_nm_per_rad": (0.1, 10.0),
    "hand_kg_m2": (5e-7, 5e-6),
    "hand_damping": (0.02, 2.0),
    **{f"told.{name}": _NEARLY for name in _GAINS},
    "encoder_noise_counts": (0.01, 0.3),
    "extra_share": (0.01, 1.0),
    "back_nm": (5e-3, 40e-3),
    "help": (0.1, 1.0),
    "also_share": (0.01, 1.0),
    "also_hz": (2.0, 500.0),
    "move_rad": (1e-3, 1.0),
}
"""Bounds of the optimiser's variables, which move evenly in the logarithm.

`weight` is a share of what can be held, `hand_damping` a share of the critical one. The gains move
with electrics only, and the noise of a noisy encoder. `extra_share` is a share of the strongest
effect that comes to the scene's. With `back_nm` a hand that leaves draws the knob back. `help` is a
share of the most that the law gives in free air. `also_share` is one of 50 mN m, or of half of what
the scene holds; a periodic torque has `also_hz`. A host moves the scene by `move_rad`.
"""


@dataclass(frozen=True)
class Case:
    """One search: what is fixed in it."""

    _: KW_ONLY
    number: int
    law: Law
    scene: SceneName
    hand: HandName
    rate_hz: int
    counts: int
    electrics: bool
    belt: bool
    noisy: bool
    extra: ExtraName = "nothing"
    leaves: bool = False  # the hand draws the knob back to where the scene begins
    helps: bool = False  # in free air, as calibration proposes it
    simple: bool = False  # the RP2040's current loop, with electrics at its rate
    gap_rad: float = GAPS_RAD[0]  # at most, between walls or stops
    also: AlsoName = "nothing"
    frame_s: float = 0.0  # of a host that moves the scene; 0: of none
    comes: bool = False  # the scene moves towards the knob


class Change(NamedTuple):
    """A change by the host."""

    begins_s: float
    scene: tuple[Effect, ...] | None = None
    model: Mapping[str, float] | None = None


@dataclass(frozen=True, repr=False)
class Moved(LoopOptions):
    """A loop with a host that changes it."""

    changes: tuple[Change, ...] = ()


@dataclass(frozen=True)
class Batch:
    """Cases that are searched and stored together."""

    group: str
    index: int
    designs: tuple[Case, ...]
    tries: int


def batches(cases: int, tries: int, law: Law) -> Iterator[Batch]:
    """Give each case a batch of its own; every pair of scene and hand comes before one repeats."""
    pairs = list(itertools.product(SCENES, HANDS))
    for number in range(cases):
        random = np.random.default_rng([35, number])
        # Any step prime to 28 visits each pair once.
        scene, hand = pairs[number * 13 % len(pairs)]
        rate_hz, counts = int(random.choice(RATES_HZ)), int(random.choice(COUNTS))
        electrics, belt, noisy = (bool(random.random() < share) for share in (0.3, 0.2, 0.3))
        extra = EXTRAS[max(0, int(random.integers(-3, len(EXTRAS))))]
        case = Case(
            number=number, law=law, scene=scene, hand=hand,
            rate_hz=rate_hz, counts=counts, electrics=electrics, belt=belt, extra=extra,
            noisy=noisy and extra != "inertia",  # which noise would shake
            leaves=bool(random.random() < 0.5), helps=bool(random.random() < 0.5),
            simple=bool(random.random() < 0.5) and electrics and rate_hz == RATES_HZ[0],
            gap_rad=float(random.choice(GAPS_RAD)),
        )  # fmt: skip
        yield Batch(law, number, (_moved(case, random),), tries)


def _moved(case: Case, random: np.random.Generator) -> Case:
    """Draw what plays in time, and how a host moves the scene."""
    also = ALSO[max(0, int(random.integers(-3, len(ALSO))))]
    # A push rolls a knob over detents, unless a hand holds it.
    rolls = case.scene == "detents" and case.hand in {"weight", "released"}
    goes_on = case.scene == "detents" and case.hand == "thrown" and also == "constant"
    moves = bool(random.random() < 0.3) and not rolls
    return replace(
        case,
        also="nothing" if goes_on or (rolls and also not in {"friction", "stream"}) else also,
        frame_s=float(random.choice(FRAMES_S)) if moves else 0.0,
        comes=bool(random.random() < 0.5),
    )


def values_of(point: np.typing.NDArray[np.float64]) -> dict[str, float]:
    """Give what a point of the unit cube stands for."""
    return {
        name: low * math.exp(float(share) * math.log(high / low))
        for share, (name, (low, high)) in zip(point, SPACE.items(), strict=True)
    }


def options_of(case: Case, value: Mapping[str, float]) -> LoopOptions:
    """Give the loop that a case and its values make; a gain that is not named is right."""
    plant = _plant(case, value)
    actuator = _told(plant, value)
    hand, initial = _hand(case, value, plant)
    scene, changes = _host(case, value)
    return Moved(
        scene=scene,
        changes=changes,
        hand=hand,
        initial=initial,
        plant=plant,
        actuator=actuator,
        board=_board(value) if case.electrics else None,
        control=ControlConfig(
            law=case.law,
            beta=value["beta"],
            free_assist_nm=value["help"] * _most_help_nm(actuator) if case.helps else 0.0,
        ),
        control_period_ns=round(1e9 / case.rate_hz),
        seed=case.number,
    )


def _most_help_nm(told: ActuatorConfig) -> float:
    friction_nm = told.knob_coulomb_nm + told.brake_drag_nm
    return min(0.75 * friction_nm, told.knob_coulomb_nm)


def _plant(case: Case, value: Mapping[str, float]) -> PlantParams:
    reference = PlantParams()
    true = {name: value[f"true.{name}"] * getattr(reference, name) for name in _TRUE}
    lag_s, electrics = true["brake_time_constant_s"], None
    if case.electrics:
        electrics = replace(
            _SIMPLE_LOOP if case.simple else Electrics(),
            coil_inductance_h=lag_s * Electrics().coil_resistance_ohm,
        )
    inertia = true["brake_inertia_kg_m2"]
    loop_nm = value["loop_nm"]
    return PlantParams(
        **true,
        counts_per_rev=case.counts,
        encoder_noise_counts=value["encoder_noise_counts"] if case.noisy else 0.0,
        shaft_hardening=ShaftHardening(
            knee_rad=value["knee_rad"], stiffness_factor=value["knee_factor"]
        ),
        brake_hysteresis=BrakeHysteresis(half_width_nm=loop_nm),
        belt=Belt(pulley_inertia_kg_m2=0.25 * inertia) if case.belt else None,
        cogging=Cogging.sine(periods_per_rev=12, amplitude_nm=value["cogging_nm"], points=16),
        electrics=electrics,
    )


def _told(plant: PlantParams, value: Mapping[str, float]) -> ActuatorConfig:
    right = plant.matching_config()
    return replace(right, **{name: value[f"told.{name}"] * getattr(right, name) for name in _TOLD})


def _board(value: Mapping[str, float]) -> BoardConfig:
    right = BoardConfig()
    gains = {name: value.get(f"told.{name}", 1.0) * getattr(right, name) for name in _GAINS}
    # Nothing is held back, as where a board is told nothing.
    return replace(right, motor_current_continuous_a=right.motor_current_max_a, **gains)


def _host(case: Case, value: Mapping[str, float]) -> tuple[tuple[Effect, ...], tuple[Change, ...]]:
    """Give what plays first, and what a host changes. What moves ends where others stand."""
    places = list(_places(case, value))
    streams = case.also == "stream"
    scenes = [_scene(case, value, at_rad) for _, _, at_rad in places]
    if streams:
        return scenes[-1], tuple(
            Change(begins_s, model=_model(value, left, at_rad)) for begins_s, left, at_rad in places
        )
    others = zip(places[1:], scenes[1:], strict=True)
    return scenes[0], tuple(Change(place[0], scene=scene) for place, scene in others)


def _places(case: Case, value: Mapping[str, float]) -> Iterator[tuple[float, float, float]]:
    """Give from when on what moves is where, with the share of its way that is left."""
    end_rad = _AT_RAD + value["place_counts"] * 2.0 * math.pi / case.counts
    frames = round((_SETTLED_S - _PUSHED_S) / case.frame_s) if case.frame_s else 0
    way_rad = value.get("move_rad", 0.0)
    way_rad = way_rad if case.comes else -min(way_rad, _AT_RAD)
    for left in range(frames, -1, -1):
        begins_s = _SETTLED_S - left * case.frame_s if left < frames else 0.0
        share = left / max(1, frames)
        yield begins_s, share, end_rad + share * way_rad


def _scene(case: Case, value: Mapping[str, float], at_rad: float) -> tuple[Effect, ...]:
    return (
        *_springs(case, value, at_rad), *_extra(case, value, at_rad), *_also(case, value),
    )  # fmt: skip


def _model(value: Mapping[str, float], left: float, at_rad: float) -> dict[str, float]:
    """Give a streamed spring with a damper, and a torque that ends with the way."""
    return {
        "torque_nm": left * _also_nm(value),
        "angle_rad": at_rad,
        "stiffness_nm_per_rad": value["stiffness_nm_per_rad"],
        "damping_nm_s_per_rad": value.get("also_share", 0.0) * _MOST_NM_S_PER_RAD,
    }


def _also_nm(value: Mapping[str, float]) -> float:
    return value.get("also_share", 0.0) * min(0.5 * value["limit_nm"], _ALSO_NM)


def _also(case: Case, value: Mapping[str, float]) -> tuple[Effect, ...]:
    """Give a torque that plays in time, or friction. A streamed spring is no effect."""
    torque_nm, ends = _also_nm(value), Timing(duration_s=_SETTLED_S)
    effects: dict[AlsoName, tuple[Effect, ...]] = {
        "nothing": (),
        "stream": (),
        "constant": (Constant(torque_nm=torque_nm),),
        "ramp": (Ramp(start_torque_nm=-torque_nm, end_torque_nm=torque_nm, timing=ends),),
        "periodic": (
            Periodic(amplitude_nm=torque_nm, frequency_hz=value.get("also_hz", 0.0), timing=ends),
        ),
        "friction": (
            Friction(torque_nm=torque_nm, stiffness_nm_per_rad=value["stiffness_nm_per_rad"]),
        ),
    }
    return effects[case.also]


def _extra(case: Case, value: Mapping[str, float], at_rad: float) -> tuple[Effect, ...]:
    """Give what comes to the scene; of most of it `play` does not warn."""
    share = value.get("extra_share", 0.0)
    damping = share * _MOST_NM_S_PER_RAD
    # A texture takes from detents what a weight leans on.
    most_nm = 0.5 * value["limit_nm"] if case.scene == "detents" and case.hand != "thrown" else 0.1
    extras: dict[ExtraName, tuple[Effect, ...]] = {
        "nothing": (),
        "damper": (Damper(damping_nm_s_per_rad=damping),),
        "damped wall": (
            Wall(angle_rad=at_rad, stiffness_nm_per_rad=0.1, damping_nm_s_per_rad=damping),
        ),
        "inertia": (Inertia(inertia_kg_m2=share * 2e-4),),
        "texture": (
            Texture(
                grains_per_turn=min(500, case.counts // 8), torque_nm=share * min(most_nm, 0.1)
            ),
        ),
        "impact": (
            Impact(angle_rad=at_rad, strength_nm_s_per_rad=share, pulse_nm_s_per_rad=share),
        ),
    }
    return extras[case.extra]


def _springs(case: Case, value: Mapping[str, float], at_rad: float) -> tuple[Effect, ...]:
    stiffness, limit_nm = value["stiffness_nm_per_rad"], value["limit_nm"]
    wall = Wall(angle_rad=at_rad, stiffness_nm_per_rad=stiffness)
    narrow_rad = min(GAPS_RAD[0], limit_nm / stiffness)
    far_rad = at_rad - (narrow_rad if case.gap_rad == GAPS_RAD[0] else case.gap_rad)
    scenes: dict[SceneName, tuple[Effect, ...]] = {
        "wall": (wall,),
        "spring": (Spring(angle_rad=at_rad, stiffness_nm_per_rad=stiffness),),
        "limited spring": (
            Spring(angle_rad=at_rad, stiffness_nm_per_rad=stiffness, torque_limit_nm=limit_nm),
        ),
        "facing walls": (
            wall,
            Wall(angle_rad=far_rad, side="below", stiffness_nm_per_rad=0.5 * stiffness),
        ),
        "stops": (
            EndStops(lower_rad=far_rad, upper_rad=at_rad, stiffness_nm_per_rad=stiffness),
            Friction(torque_nm=0.1 * limit_nm),
        ),
        "detents": (Detents(angle_rad=at_rad, torque_nm=limit_nm, pitch_rad=0.3),),
        "sum": (
            wall,
            Curve(
                angle_rad=at_rad - 0.1, span_rad=0.3,
                torque_nm=[0.1 * limit_nm, -0.3 * limit_nm, 0.0, -0.5 * limit_nm],
            ),
        ),
    }  # fmt: skip
    return scenes[case.scene]


def _hand(
    case: Case, value: Mapping[str, float], plant: PlantParams
) -> tuple[Hand, InitialState | None]:
    if case.hand == "thrown":
        return NoHand(), InitialState(speed_rad_s=value["speed_rad_s"])
    if case.hand == "held":
        stiffness, inertia = value["hand_nm_per_rad"], value["hand_kg_m2"]
        push_nm = value["weight"] * plant.motor_limit_nm
        moving = inertia + plant.knob_inertia_kg_m2
        path = [(0.0, 0.0), (_SETTLED_S, _AT_RAD + push_nm / stiffness)]
        if case.leaves:  # its force at the edge is up to 20 mN m, either way
            path += [(_LEFT_S, _AT_RAD + (value["back_nm"] - 20e-3) / stiffness)]
        return ImpedanceHand(
            stiffness_nm_per_rad=stiffness,
            damping_nm_s_per_rad=2.0 * value["hand_damping"] * math.sqrt(stiffness * moving),
            inertia_kg_m2=inertia,
            intended_angle_rad=path,
        ), None
    # A motor that gives less than the device believes holds less.
    gives_less = max(1.0, value.get(f"told.{_GAINS[0]}", 1.0)) if case.electrics else 1.0
    holds_nm = min(plant.motor_limit_nm, value["limit_nm"]) / gives_less
    if case.also == "constant":
        holds_nm -= _also_nm(value)
    holdable = _HOLDABLE_BY_DETENTS if case.scene == "detents" else _HOLDABLE
    weight_nm = holdable * value["weight"] * holds_nm
    path = [(0.0, 0.0), (_PUSHED_S, weight_nm)]
    if case.hand == "released" and case.leaves:
        left_s = _SETTLED_S + 0.1 * value["hand_damping"]
        back_nm = -value["back_nm"]
        path += [(_SETTLED_S, weight_nm), (_SETTLED_S, back_nm), (left_s, back_nm), (left_s, 0.0)]
    elif case.hand == "released":
        path += [(_SETTLED_S, weight_nm), (_SETTLED_S, 0.2 * weight_nm)]
    return TorqueHand(torque_nm=path), None
