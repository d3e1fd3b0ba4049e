"""Broken knobs: each must be refused, and for the right reason."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

import torsio
from torsio import calibration
from torsio.printed.hands import ImpedanceHand, PrescribedMotion, TorqueHand
from torsio.printed.plant import PlantParams
from torsio_studies.calibration.knobs import emulated

_FINE = PlantParams()


@dataclass(frozen=True)
class Sabotage:
    """A fault, and the reason of the refusal that names it.

    `plant` is what was built; `do` does something to the open knob, `reversed` configures the
    encoder the wrong way round, and `during` does something when a step begins.
    """

    name: str
    reason: str
    plant: PlantParams = _FINE
    do: Callable[[torsio.Knob], object] | None = None
    reversed: bool = False
    during: dict[str, Callable[[torsio.Knob], object]] | None = None


def _hand(hand: torsio.Hand) -> Callable[[torsio.Knob], None]:
    return lambda knob: knob.emulator.set_hand(hand)


def _holding(stiffness: float, damping: float, inertia: float = 1e-4) -> torsio.Hand:
    return ImpedanceHand(
        stiffness_nm_per_rad=stiffness,
        damping_nm_s_per_rad=damping,
        inertia_kg_m2=inertia,
        intended_angle_rad=0.0,
    )


def _turning(knob: torsio.Knob) -> None:
    now = knob.position_rad()
    knob.emulator.set_hand(PrescribedMotion(angle_rad=[(0.0, now), (100.0, now + 200.0)]))


def _freeze_later(knob: torsio.Knob, after_s: float) -> None:
    """Have the encoder die while a calibration waits for the knob, so long from now."""
    since_s = knob.clock().time_s
    sleep = knob.sleep

    def sleep_and_freeze(duration_s: float) -> None:
        sleep(duration_s)
        if knob.clock().time_s - since_s >= after_s:
            knob.emulator.freeze_encoder(frozen=True)

    knob.sleep = sleep_and_freeze  # type: ignore[method-assign]


SABOTAGES: Final = (
    Sabotage("motor dead", "still", replace(_FINE, motor_limit_nm=0.0)),
    Sabotage("motor gives a tenth", "still", replace(_FINE, motor_limit_nm=8.5e-3)),
    Sabotage("encoder dead", "still", do=lambda knob: knob.emulator.freeze_encoder(frozen=True)),
    Sabotage(
        "encoder dead, and light parts",
        "still",
        replace(
            _FINE,
            knob_inertia_kg_m2=0.5 * _FINE.knob_inertia_kg_m2,
            brake_inertia_kg_m2=0.5 * _FINE.brake_inertia_kg_m2,
            knob_coulomb_nm=0.5 * _FINE.knob_coulomb_nm,
            brake_drag_nm=0.5 * _FINE.brake_drag_nm,
        ),
        do=lambda knob: knob.emulator.freeze_encoder(frozen=True),
    ),
    Sabotage("encoder reversed", "reversed", reversed=True),
    Sabotage(
        "encoder reversed, and a weight",
        "reversed",
        do=_hand(TorqueHand(torque_nm=5e-3)),
        reversed=True,
    ),
    Sabotage(
        "encoder dies before the knob spins",
        "runs_away",
        during={"friction and inertia": lambda knob: knob.emulator.freeze_encoder(frozen=True)},
    ),
    Sabotage(
        "encoder dies as the knob turns slowly",
        "runs_away",
        during={"friction and inertia": lambda knob: _freeze_later(knob, 1.0)},
    ),
    Sabotage(
        "encoder dies as the knob spins",
        "runs_away",
        during={"friction and inertia": lambda knob: _freeze_later(knob, 5.5)},
    ),
    Sabotage("encoder jitters", "noisy", replace(_FINE, encoder_noise_counts=4.0)),
    Sabotage("brake stuck on", "held", replace(_FINE, brake_drag_nm=0.2)),
    Sabotage("brake dead", "does_not_hold", replace(_FINE, brake_limit_nm=0.0)),
    Sabotage("coupling slips at 30 mN m", "does_not_hold", replace(_FINE, brake_limit_nm=0.03)),
    Sabotage("shaft cut", "does_not_hold", replace(_FINE, shaft_stiffness_nm_per_rad=0.0)),
    Sabotage("shaft locked", "rigid", replace(_FINE, shaft_stiffness_nm_per_rad=400.0)),
    Sabotage("knob jammed", "still", replace(_FINE, knob_coulomb_nm=0.5)),
    Sabotage("hand holds the knob", "held", do=_hand(_holding(2.0, 0.02))),
    Sabotage("hand holds it firmly", "still", do=_hand(_holding(100.0, 0.2))),
    Sabotage("hand turns the knob", "moved", do=_turning),
    Sabotage("weight on a string", "pulled", do=_hand(TorqueHand(torque_nm=5e-3))),
    Sabotage("heavy weight", "moved", do=_hand(TorqueHand(torque_nm=40e-3))),
    Sabotage("large flywheel on the knob", "inertia", replace(_FINE, knob_inertia_kg_m2=4e-3)),
    Sabotage("flywheel on the knob", "inertia", replace(_FINE, knob_inertia_kg_m2=2e-3)),
    Sabotage(
        "hand grips it during the pulls",
        "unexplained",
        during={"shaft": lambda knob: knob.emulator.set_hand(_pinching(knob))},
    ),
    Sabotage(
        "emergency stop",
        "fault",
        during={"shaft": lambda knob: knob.emulator.set_emergency_stop(pressed=True)},
    ),
)  # fmt: skip


def _pinching(knob: torsio.Knob) -> torsio.Hand:
    now = knob.position_rad()
    return ImpedanceHand(
        stiffness_nm_per_rad=1.0,
        damping_nm_s_per_rad=5e-3,
        inertia_kg_m2=1e-4,
        intended_angle_rad=[(0.0, now), (2.0, now + 0.05), (2.6, now - 0.06), (3.3, now + 0.06),
                            (4.2, now - 0.03), (5.0, now + 0.05), (8.0, now)],
    )  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """Result of a sabotage.

    Attributes
    ----------
    reason
        Of the refusal; "" if there was none.
    fastest_rad_s
        How fast the knob really was at most, whatever its encoder said.
    """

    reason: str
    fastest_rad_s: float


def try_out(sabotage: Sabotage) -> Outcome:
    """Calibrate what is broken."""
    with emulated(sabotage.plant, reversed=sabotage.reversed, seed=7, log_truth=True) as knob:
        if sabotage.do is not None:
            sabotage.do(knob)

        def step(name: str) -> None:
            if sabotage.during is not None and name in sabotage.during:
                sabotage.during[name](knob)

        reason = ""
        try:
            calibration.calibrate(knob, progress=step)
        except calibration.Refusal as refusal:
            reason = refusal.reason
        except torsio.Refused:
            reason = "fault" if knob.state == "fault" else "refused"
        speed_rad_s = knob.emulator.truth()["speed_rad_s"]
    return Outcome(reason, float(np.abs(speed_rad_s).max()))
