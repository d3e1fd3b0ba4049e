"""Findings of the steps, one by one and put together as quantities."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TypedDict

from torsio.calibration.brake import Brake
from torsio.calibration.drive import Drive
from torsio.calibration.electric import Circuit
from torsio.calibration.free import Free
from torsio.calibration.play import Run
from torsio.calibration.quantity import Quantity
from torsio.calibration.shaft import Shaft

__all__ = ["Findings", "Quantities", "Runs", "flexible_s2", "knob_inertia_kg_m2", "quantities_of"]

# The brake's side has from none up to this share of all viscous friction, each value as likely.
# Knob and brake turn alike in every experiment, so nothing tells them apart.
_BRAKE_VISCOUS = 0.25


class Findings(TypedDict, total=False):
    """Findings of the steps that are done.

    Attributes
    ----------
    turns
        Run of the free knob, which later steps read again.
    brake
        Missing after a look for drift.
    circuit
        Missing where the device measures no current.
    drive
        Always there: source of the motor's torque; None if the motor gives what it is told.
    """

    turns: Run
    free: Free
    shaft: Shaft
    brake: Brake
    circuit: Circuit
    drive: Drive | None


def knob_inertia_kg_m2(found: Findings) -> float:
    """Give the inertia of the knob's side alone, a guess after a look for drift."""
    known = found["shaft"].knob_inertia
    return 0.6 * found["free"].inertia.value if known is None else known.value


def flexible_s2(found: Findings) -> float:
    """Give the brake's inertia over the shaft's stiffness."""
    brake_kg_m2 = max(found["free"].inertia.value - knob_inertia_kg_m2(found), 0.0)
    return brake_kg_m2 / found["shaft"].stiffness.value


Runs = tuple[Run, ...]
Quantities = dict[str, Quantity]
"""By name."""


def _knob_viscous(viscous: Quantity) -> Quantity:
    """Give the knob's share of the viscous friction."""
    share = 1.0 - 0.5 * _BRAKE_VISCOUS
    return Quantity(
        "knob_viscous_nm_s_per_rad",
        share * viscous.value,
        math.hypot(
            share * viscous.standard_uncertainty, _BRAKE_VISCOUS / math.sqrt(12.0) * viscous.value
        ),
        f"of the knob's side, if the brake's has {100 * _BRAKE_VISCOUS:.0f} % of it at most",
    )


def quantities_of(
    found: Findings, doubted: Callable[[Quantity], Quantity] = lambda of: of
) -> Quantities:
    """Give all quantities by name.

    Parameters
    ----------
    doubted
        Gives a fit's quantity with what the fit does not know. What is left when one is taken off
        another then has the doubts of both.
    """
    free, shaft, brake, drive = found["free"], found["shaft"], found.get("brake"), found["drive"]
    added = 0.0 if drive is None else drive.added_kg_m2

    def without_added(inertia: Quantity) -> Quantity:
        return doubted(replace(inertia, value=inertia.value - added))

    inertia, coulomb, viscous = (
        without_added(free.inertia),
        *map(doubted, (free.coulomb, free.viscous)),
    )
    knob_coulomb = doubted(shaft.knob_coulomb)
    quantities = [
        *(inertia, coulomb, viscous, doubted(free.offset), _knob_viscous(viscous)),
        *(doubted(shaft.stiffness), doubted(shaft.backlash), knob_coulomb),
        *(doubted(of) for of in (shaft.knee, shaft.factor, shaft.damping) if of is not None),
    ]
    if shaft.knob_inertia is not None:
        knob_inertia = without_added(shaft.knob_inertia)
        quantities += [
            knob_inertia,
            inertia.less("brake_inertia_kg_m2", knob_inertia, "of pulleys and brake"),
        ]
    if brake is not None:
        quantities.append(
            coulomb.less("", knob_coulomb, "").less(
                "brake_drag_nm", brake.left, "what the brake holds with no current, its loop aside"
            )
        )
        fits = (free.amplitude, brake.gain, brake.hysteresis, brake.rise, brake.release)
        quantities += map(doubted, fits)
    return {of.name: of for of in quantities}
