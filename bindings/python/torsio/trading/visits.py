"""Visits to a scene, and how two of them differ for the hand."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from torsio import perception
from torsio.closed_loop import LoopOptions
from torsio.demos import wall
from torsio.printed.hands import Hand, ImpedanceHand, PrescribedMotion, TorqueHand
from torsio.printed.plant import PlantParams
from torsio.printed.scenes import Effect, Scene
from torsio.telemetry import Record

__all__ = [
    "CHOOSE",
    "PATHS",
    "Difference",
    "Visit",
    "differ",
    "edges_rad",
    "effects_of",
    "felt_nm",
    "moved",
    "steady_nm",
    "usual_hand",
    "verifying",
]

Array = npt.NDArray[np.float64]

_AFTER_S: Final = 0.2
_STEADY: Final = 10
PATHS: Final[dict[type[Hand], str]] = {
    ImpedanceHand: "intended_angle_rad",
    PrescribedMotion: "angle_rad",
    TorqueHand: "torque_nm",
}
"""The field that has the path of each kind of hand that has one."""


@dataclass(frozen=True)
class Visit:
    """How the hand's path is changed.

    Attributes
    ----------
    pace
        The path is so many times as fast.
    phase_counts
        Where within a count of the encoder the knob starts; 0 to 1.
    """

    pace: float = 1.0
    phase_counts: float = 0.0

    def of(self, options: LoopOptions) -> LoopOptions:
        """Give a loop this visit."""
        hand = moved(options.hand, lambda at_s, value: (at_s / self.pace, value))
        plant = replace(
            options.plant,
            encoder_phase_counts=options.plant.encoder_phase_counts + self.phase_counts,
        )
        return replace(options, hand=hand, plant=plant)

    def lasts_s(self, hand: Hand) -> float:
        """Give how long a visit takes, to a whole millisecond."""
        name = PATHS.get(type(hand))
        last_s = getattr(hand, name)[-1][0] if name else 0.0
        return round((last_s / self.pace if last_s > 0.0 else 1.0) + _AFTER_S, 3)


def moved(hand: Any, change: Callable[[float, float], tuple[float, float]]) -> Hand:
    """Change each knot (time_s, value) of a hand's path, if it has one."""
    result: Hand = hand
    if name := PATHS.get(type(hand)):
        result = replace(hand, **{name: [change(*knot) for knot in getattr(hand, name)]})
    return result


CHOOSE: Final = (Visit(), Visit(0.8, 0.37))
"""Visits that a proposal is chosen by."""
_VERIFY: Final = Visit(1.25, 0.71), Visit(0.9, 0.13), Visit(0.65, 0.55)


def verifying(number: int) -> tuple[Visit, ...]:
    """Give visits to verify a proposal on; each number has its own, and `CHOOSE` none of them."""
    slower, further = 1.0 - 0.1 * (0.618 * number % 1.0), 0.382 * number
    return tuple(
        Visit(round(slower * of.pace, 3), round((of.phase_counts + further) % 1.0, 3))
        for of in _VERIFY
    )


def effects_of(scene: Scene | None) -> list[Effect]:
    """Give a scene as a list."""
    if scene is None:
        return []
    return list(scene) if isinstance(scene, Iterable) else [scene]


def edges_rad(scene: Scene | None) -> Array:
    """Give the angles at which a scene begins or ends to push, shape (n,).

    For detents these are the crests within two turns, for a curve both ends.
    """
    edges: list[float] = []
    for effect in effects_of(scene):
        at = getattr(effect, "angle_rad", None)
        edges += [
            getattr(effect, end) for end in ("lower_rad", "upper_rad") if hasattr(effect, end)
        ]
        if at is None:
            continue
        per_turn = getattr(effect, "per_turn", None)
        if pitch := 2.0 * math.pi / per_turn if per_turn else getattr(effect, "pitch_rad", None):
            count = math.ceil(4.0 * math.pi / pitch)
            edges += [at + (k + 0.5) * pitch for k in range(-count, count)]
        else:
            edges += [at, *([at + effect.span_rad] if hasattr(effect, "span_rad") else [])]
    return np.unique(np.array(edges, dtype=np.float64))


def usual_hand(scene: Scene | None) -> ImpedanceHand:
    """Give fingers that turn the knob through the scene, press, hold and come back.

    The grip is the same as in `torsio demo wall`. They press with 50 mN m at the scene's furthest
    edge within a turn.
    """
    edges = edges_rad(scene)
    near = edges[np.abs(edges) <= 2.0 * math.pi]
    furthest = float(near[np.argmax(np.abs(near))]) if len(near) else 0.3
    press = 50e-3 / wall.HAND_STIFFNESS_NM_PER_RAD
    target = furthest + math.copysign(press, furthest)
    back_s = wall.PUSH_S + wall.HOLD_S
    return ImpedanceHand(
        stiffness_nm_per_rad=wall.HAND_STIFFNESS_NM_PER_RAD,
        damping_nm_s_per_rad=wall.HAND_DAMPING_NM_S_PER_RAD,
        inertia_kg_m2=wall.HAND_INERTIA_KG_M2,
        intended_angle_rad=[
            (0.0, 0.0), (wall.PUSH_S, target), (back_s, target), (back_s + wall.PULL_S, 0.0),
        ],
    )  # fmt: skip


def felt_nm(rows: Record, plant: PlantParams, hand: Hand) -> Array:
    """Give the knob's torque on the hand, without the part of its own inertia.

    It is (JA + Jh) alpha - Thand. By Newton's law the torques of shaft, motor, cogging and friction
    on the knob add up to it, so nothing is differentiated.
    """
    speed = rows["speed_rad_s"]
    on_knob = rows["spring_torque_nm"] + rows["motor_torque_nm"] + cogging_nm(rows, plant)
    if "knob_friction_torque_nm" not in (rows.dtype.names or ()):
        return np.asarray(on_knob)  # the whole device's truth has no friction in it
    on_knob = on_knob + rows["knob_friction_torque_nm"] - plant.knob_viscous_nm_s_per_rad * speed
    if plant.spring_and_brake:
        return np.asarray(on_knob)
    # Knob and brake are one body: the shaft carries the torque of the brake's side.
    if isinstance(hand, PrescribedMotion):
        return np.asarray(-rows["hand_torque_nm"])
    knob = plant.knob_inertia_kg_m2 + getattr(hand, "inertia_kg_m2", 0.0)
    total = on_knob + rows["hand_torque_nm"] - plant.brake_viscous_nm_s_per_rad * speed
    share = knob / (knob + plant.brake_inertia_kg_m2)
    return np.asarray(share * total - rows["hand_torque_nm"])


def cogging_nm(rows: Record, plant: PlantParams) -> Array:
    """Give the cogging's torque where the knob is, shape (n,)."""
    if plant.cogging is None:
        return np.zeros(len(rows))
    wave = np.array([*plant.cogging.torque_nm], dtype=np.float64)
    turned = rows["angle_rad"] * (plant.cogging.periods_per_rev / (2.0 * math.pi))
    along = np.mod(turned, 1.0) * len(wave)
    return np.asarray(np.interp(along, np.arange(len(wave) + 1), np.append(wave, wave[0])))


@dataclass(frozen=True)
class Difference:
    """By how much a visit differs from the reference, for the hand.

    Attributes
    ----------
    largest_nm
        Largest error of the felt torque, as a mean over 10 ms: a JND is for a steady torque.
    spike_nm, rms_nm
        The largest and the root mean square without that mean, sampled once a millisecond.
    angle_rad
        The largest, of the knob.
    contact_s
        The largest shift of a moment at which the knob crosses an edge of the scene.
    missed
        Edges that one crosses more often than the other, which no shift tells of.
    """

    largest_nm: float = 0.0
    spike_nm: float = 0.0
    rms_nm: float = 0.0
    angle_rad: float = 0.0
    contact_s: float = 0.0
    missed: int = 0

    @property
    def jnds(self) -> float:
        """The largest difference of torque in JNDs; `wanted` is about this."""
        return perception.torque_jnds(self.largest_nm)

    def worse(self, other: Difference) -> Difference:
        """Give the larger of each."""
        return Difference(**{k: max(v, getattr(other, k)) for k, v in vars(self).items()})

    def as_dict(self) -> dict[str, Any]:
        """Give the fields, and the torques in JNDs too."""
        rms = perception.torque_jnds(self.rms_nm)
        return {**vars(self), "largest_jnds": self.jnds, "rms_jnds": rms}


def differ(
    reference: Record, rows: Record, felt: tuple[Array, Array], scene: Scene | None
) -> Difference:
    """Compare two visits, sampled at the same moments, whose hands felt these torques."""
    error = felt[1] - felt[0]
    shift_s, missed = 0.0, 0
    for edge in edges_rad(scene):
        one, other = (_crossings_s(run, float(edge)) for run in (reference, rows))
        if len(one) != len(other):
            missed += abs(len(one) - len(other))
        elif len(one):
            shift_s = max(shift_s, float(np.abs(one - other).max()))
    return Difference(
        largest_nm=steady_nm(error),
        spike_nm=float(np.abs(error).max()),
        rms_nm=float(np.sqrt(np.mean(np.square(error)))),
        angle_rad=float(np.abs(rows["angle_rad"] - reference["angle_rad"]).max()),
        contact_s=shift_s,
        missed=missed,
    )


def steady_nm(error_nm: Array) -> float:
    """Give the largest mean over 10 ms of a difference that was sampled once a millisecond."""
    return float(np.abs(np.convolve(error_nm, np.full(_STEADY, 1.0 / _STEADY), "valid")).max())


def _crossings_s(rows: Record, edge_rad: float) -> Array:
    """Give when the knob crosses an angle, on straight lines between the rows."""
    beyond = rows["angle_rad"] - edge_rad
    at = np.flatnonzero((beyond[:-1] < 0.0) != (beyond[1:] < 0.0))
    share = beyond[at] / (beyond[at] - beyond[at + 1])
    return np.asarray(rows["time_s"][at] + share * np.diff(rows["time_s"])[at])
