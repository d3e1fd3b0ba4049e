"""Findings of the steps, one by one and put together as quantities."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from torsio.calibration.brake import Brake
from torsio.calibration.drive import Drive
from torsio.calibration.electric import Circuit
from torsio.calibration.free import Free
from torsio.calibration.play import Run
from torsio.calibration.quantity import Quantity
from torsio.calibration.shaft import Shaft

__all__ = ["Findings", "Quantities", "Runs", "quantities_of"]

# The brake's side has from none up to this share of all viscous friction, each value as likely.
# Knob and brake turn alike in every experiment, so nothing tells them apart.
_BRAKE_VISCOUS = 0.25


_LATER: Any = None


@dataclass(frozen=True)
class Findings:
    """Findings of the steps.

    Attributes
    ----------
    turns
        Run of the free knob, which later steps read again.
    free, shaft
        There once their steps are done; later ones need not ask.
    brake
        None after a look for drift.
    circuit
        None where the device measures no current.
    drive
        Source of the motor's torque; None if the motor gives what it is told.
    """

    turns: Run = _LATER
    free: Free = _LATER
    shaft: Shaft = _LATER
    brake: Brake | None = None
    circuit: Circuit | None = None
    drive: Drive | None = None

    @property
    def knob_inertia_kg_m2(self) -> float:
        """Inertia of the knob's side alone, a guess after a look for drift."""
        found = self.shaft.knob_inertia
        return 0.6 * self.free.inertia.value if found is None else found.value

    @property
    def flexible_s2(self) -> float:
        """The brake's inertia over the shaft's stiffness."""
        brake_kg_m2 = max(self.free.inertia.value - self.knob_inertia_kg_m2, 0.0)
        return brake_kg_m2 / self.shaft.stiffness.value


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
    free, shaft, brake = found.free, found.shaft, found.brake
    added = 0.0 if found.drive is None else found.drive.added_kg_m2

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
