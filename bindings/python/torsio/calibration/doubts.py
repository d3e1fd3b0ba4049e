"""Doubts: the uncertainties that no fit knows of itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from torsio.calibration.brake import STAIRS_RAD_S
from torsio.calibration.brake_curve import BrakeCurve
from torsio.calibration.cogging import Cogging
from torsio.calibration.drive import Drive
from torsio.calibration.found import Findings, Quantities, quantities_of
from torsio.calibration.left_out import (
    LEFT_OUT,
    LEFT_OUT_BY_DRIVE,
    LEFT_OUT_BY_SIMPLE_LOOP,
    LEFT_OUT_BY_TICK,
    STATED_TOO_WIDE,
    TICK_S,
)
from torsio.calibration.quantity import Quantity

__all__ = ["Doubted", "differences", "of_ticks", "with_doubts"]

_Table = Mapping[str, tuple[float, float]]  # a share of the value, and at least
_Doubt = dict[str, float]  # what is added to an uncertainty, by the quantity's name

# The inertia that a drive adds is known to this share: winding and supply may be a tenth off each.
_ADDED_SIGMA = 0.2
# Share of the cogging that is left in the dry friction; and of inertia and viscous friction.
_OF_COGGING, _OF_BENDS = 2e-3, 8e-4
# Share of the stairs that is lost for each second in which they wind the shaft.
_LOST_PER_S = 0.4
# Ends of the names of what is measured in torques of the motor.
_OF_TORQUE = ("_nm", "_nm_per_rad", "_nm_s_per_rad", "_kg_m2", "brake_gain", "brake_curve")


@dataclass(frozen=True)
class Doubted:
    """All quantities, the cogging's map and the brake's curve; no map or curve without a brake."""

    quantities: Quantities
    cogging: Cogging | None = None
    brake_curve: BrakeCurve | None = None


def with_doubts(findings: Findings, *, tick_s: float, others: Sequence[Findings] = ()) -> Doubted:
    """Give all that was found, with all that the fits cannot know.

    Nothing else changes the uncertainty of a quantity, a wave or a point after its fit. Each doubt
    is independent of the fit and of the other doubts, so its square is added:

    - of a fit: what cogging and a bent shaft leave in it; the inertia that the drive seems to add;
      then what its model leaves out, of which it may have taken a part for chance;
    - of the brake: stairs that are faster than the shaft, or lie within a wide loop;
    - of a long tick: when a torque began;
    - of the drive: errors of every current loop, and those of the simple one;
    - of other drives that may be as well: the difference that each would make;
    - of the torque constant, in the measure of which every torque is.

    Parameters
    ----------
    others
        Estimates from the same runs, each with what the motor's drive may be as well.
    """
    doubted, points = _of_fit(findings), _points(findings)
    found = quantities_of(findings, doubted) | {name: doubted(of) for name, of in points.items()}
    brake, circuit = findings.get("brake"), findings.get("circuit")
    share = 0.0 if circuit is None else circuit.torque_share
    doubts = (
        {} if brake is None else _stairs(found, brake.top_nm),
        of_ticks(found, tick_s),
        *_of_drives(found, findings["drive"], others),
        {name: share * of.value for name, of in found.items() if of.name.endswith(_OF_TORQUE)},
    )
    for doubt in doubts:
        found = {name: of.wider(doubt.get(name, 0.0)) for name, of in found.items()}
    sigmas = [found.pop(name).standard_uncertainty for name in points]
    of_circuit = {} if circuit is None else {of.name: of for of in circuit.quantities}
    if brake is None:
        return Doubted(of_circuit | found)
    return Doubted(
        of_circuit | found,
        findings["free"].cogging.as_uncertain_as(found["cogging_nm"].standard_uncertainty),
        brake.curve.with_sigmas(sigmas),
    )


def _of_fit(findings: Findings) -> Callable[[Quantity], Quantity]:
    drive = findings["drive"]
    added = 0.0 if drive is None else _ADDED_SIGMA * drive.added_kg_m2
    of_fit = (_bends(findings), {"inertia_kg_m2": added, "knob_inertia_kg_m2": added})

    def doubted(fit: Quantity) -> Quantity:
        for doubt in of_fit:
            fit = fit.wider(doubt.get(fit.name, 0.0))
        sigma = STATED_TOO_WIDE.get(fit.name, 1.0) * fit.standard_uncertainty
        return replace(fit, standard_uncertainty=sigma).wider(_left_out(fit, LEFT_OUT))

    return doubted


def _of_drives(
    found: Quantities, drive: Drive | None, others: Sequence[Findings]
) -> Iterator[_Doubt]:
    """Give the errors of every current loop and of the simple one, then what others would give."""
    if drive is not None:
        for table in (LEFT_OUT_BY_DRIVE, {} if drive.predicts else LEFT_OUT_BY_SIMPLE_LOOP):
            yield {name: _left_out(of, table) for name, of in found.items()}
    for other in others:
        yield differences(found, quantities_of(other) | _points(other))


def _points(findings: Findings) -> Quantities:
    """Give the points of the brake's curve as quantities."""
    points = findings["brake"].curve.points if "brake" in findings else ()
    return {
        f"brake_curve[{i}]": Quantity("brake_curve", of.torque_nm, of.sigma_nm)
        for i, of in enumerate(points)
    }


def _left_out(quantity: Quantity, table: _Table) -> float:
    share, least = table.get(quantity.name, (0.0, 0.0))
    return math.hypot(share * quantity.value, least)


def _bends(findings: Findings) -> _Doubt:
    """Give what cogging and bent shafts leave in the others: found on numbers 2000 to 2039."""
    free, shaft = findings["free"], findings["shaft"]
    bent = 0.0 if shaft.factor is None else abs(math.log(shaft.factor.value))
    wave, through = free.amplitude, free.through_shaft
    waves = [*free.cogging.periods_per_rev, 0][0]
    share = _OF_BENDS if through > 0.05 or bent else 0.0
    damping = 0.0 if shaft.damping is None else shaft.damping.value
    return {
        "inertia_kg_m2": share * free.inertia.value,
        "coulomb_nm": _OF_COGGING * wave.value,
        "viscous_nm_s_per_rad": share * free.viscous.value,
        "stiffness_nm_per_rad": wave.standard_uncertainty * waves,
        "backlash_rad": 0.3 * through * wave.value / shaft.stiffness.value,
        "knob_coulomb_nm": 0.02 * through * shaft.knob_coulomb.value,
        "shaft_damping_nm_s_per_rad": (3.0 * through + 0.35 * bent) * damping,
    }


def _stairs(found: Quantities, top_nm: float) -> _Doubt:
    """Give what a fast brake and a wide loop leave out of stairs up to a torque.

    A brake whose torque rises faster than the turning knob winds the shaft stops for a moment. And
    a loop that takes most of the stairs leaves little of them. Found on the numbers 300 to 315.
    """
    stiffness = found["stiffness_nm_per_rad"].value
    inertia = max(found["brake_inertia_kg_m2"].value, 0.0)
    winds_s = math.hypot(top_nm / (stiffness * STAIRS_RAD_S), math.sqrt(inertia / stiffness))
    added = {}
    share = 0.0
    for name in ("rise_s", "release_s"):
        fast = math.exp(-((found[name].value / (3.5 * winds_s)) ** 2))
        added[name] = fast * winds_s / 4.0
        share = max(share, _LOST_PER_S * fast * winds_s)
    loop_nm = found["hysteresis_nm"].value
    added["hysteresis_nm"] = 0.25 * share * top_nm
    added["brake_gain"] = share + 0.25 * (loop_nm / top_nm) ** 4
    added["brake_drag_nm"] = 0.5 * share * top_nm + loop_nm * added["brake_gain"]
    return added


def of_ticks(found: Quantities, tick_s: float) -> _Doubt:
    """Give what a tick longer than others leaves out."""
    long = max(tick_s - TICK_S, 0.0) / 1e-3
    return {name: long * _left_out(of, LEFT_OUT_BY_TICK) for name, of in found.items()}


def differences(found: Quantities, other: Quantities) -> _Doubt:
    """Give how far another case is; a missing quantity counts as zero there."""
    values = {name: of.value for name, of in other.items()}
    return {name: values.get(name, 0.0) - of.value for name, of in found.items()}
