"""Findings of the steps, one by one and put together as quantities."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from torsio.calibration.brake import STAIRS_RAD_S, Brake
from torsio.calibration.drive import Drive
from torsio.calibration.free import Free
from torsio.calibration.left_out import by_brake, honest
from torsio.calibration.play import Run
from torsio.calibration.quantity import Quantity
from torsio.calibration.shaft import Shaft

__all__ = ["Known", "Parts", "Runs", "quantities_of"]

# The brake's side has from none up to this share of all viscous friction, each value as likely.
# Knob and brake turn alike in every experiment, so nothing tells them apart.
_BRAKE_VISCOUS = 0.25
# The inertia that a drive adds is known to this share: winding and supply may be a tenth off each.
_ADDED_SIGMA = 0.2
# Share of the cogging that is left in the dry friction; and of inertia and viscous friction.
_OF_COGGING, _OF_BENDS = 2e-3, 8e-4


@dataclass(frozen=True)
class Parts:
    """Findings of the steps, one by one."""

    free: Free
    shaft: Shaft
    brake: Brake | None = None

    @property
    def knob_inertia_kg_m2(self) -> float:
        """Inertia of the knob's side alone, a guess after a quick look."""
        found = self.shaft.knob_inertia
        return 0.6 * self.free.inertia.value if found is None else found.value

    @property
    def flexible_s2(self) -> float:
        """The brake's inertia over the shaft's stiffness."""
        brake_kg_m2 = max(self.free.inertia.value - self.knob_inertia_kg_m2, 0.0)
        return brake_kg_m2 / self.shaft.stiffness.value


@dataclass(frozen=True)
class Known:
    """Findings of the steps so far, and the turns, which later steps read again."""

    turns: Run | None = None
    free: Free | None = None
    shaft: Shaft | None = None
    brake: Brake | None = None

    @property
    def parts(self) -> Parts:
        """The findings once there are friction and shaft."""
        assert self.free is not None
        assert self.shaft is not None
        return Parts(self.free, self.shaft, self.brake)


Runs = tuple[Run, ...]


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


def _with_bends(parts: Parts) -> Parts:
    """Add what cogging and bent shafts leave in the others: found on numbers 2000 to 2039."""
    free, shaft = parts.free, parts.shaft
    bent = 0.0 if shaft.factor is None else abs(math.log(shaft.factor.value))
    wave, through = free.amplitude, free.through_shaft
    waves = [*free.cogging.periods_per_rev, 0][0]
    share = _OF_BENDS if through > 0.05 or bent else 0.0
    damping = shaft.damping
    return replace(
        parts,
        free=replace(
            free,
            inertia=free.inertia.wider(share * free.inertia.value),
            coulomb=free.coulomb.wider(_OF_COGGING * wave.value),
            viscous=free.viscous.wider(share * free.viscous.value),
        ),
        shaft=replace(
            shaft,
            stiffness=shaft.stiffness.wider(wave.standard_uncertainty * waves),
            backlash=shaft.backlash.wider(0.3 * through * wave.value / shaft.stiffness.value),
            knob_coulomb=shaft.knob_coulomb.wider(0.02 * through * shaft.knob_coulomb.value),
            damping=damping and damping.wider((3.0 * through + 0.35 * bent) * damping.value),
        ),
    )


def quantities_of(parts: Parts, drive: Drive | None) -> dict[str, Quantity]:
    """Give all quantities by name, with uncertainties that know what the models leave out."""
    parts = _with_bends(parts)
    free, shaft, brake = parts.free, parts.shaft, parts.brake
    added = 0.0 if drive is None else drive.added_kg_m2

    def without_added(inertia: Quantity) -> Quantity:
        part = Quantity("", added, _ADDED_SIGMA * added)
        return honest(inertia.less(inertia.name, part, inertia.meaning))

    inertia, knob_coulomb = without_added(free.inertia), honest(shaft.knob_coulomb)
    found = [
        *(inertia, free.coulomb, free.viscous, free.offset),
        _knob_viscous(honest(free.viscous)),
        *(shaft.stiffness, shaft.backlash, knob_coulomb),
        *(of for of in (shaft.knee, shaft.factor, shaft.damping) if of is not None),
    ]
    if shaft.knob_inertia is not None:
        knob_inertia = without_added(shaft.knob_inertia)
        found += [
            knob_inertia,
            inertia.less("brake_inertia_kg_m2", knob_inertia, "of pulleys and brake"),
        ]
    if brake is not None:
        held_off = honest(free.coulomb).less("", knob_coulomb, "")
        found.append(
            held_off.less(
                "brake_drag_nm", brake.left, "what the brake holds with no current, its loop aside"
            )
        )
        found += [free.amplitude, brake.gain, brake.hysteresis, brake.rise, brake.release]
    done = {inertia.name, knob_coulomb.name, "knob_inertia_kg_m2"}
    named = {of.name: of if of.name in done else honest(of) for of in found}
    return named if brake is None else by_brake(named, brake.top_nm, STAIRS_RAD_S)
