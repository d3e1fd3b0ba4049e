"""Text about a calibration: its quantities, its drifts and the changes that it proposes."""

from __future__ import annotations

from dataclasses import asdict

from torsio import perception
from torsio.calibration.procedure import Calibration
from torsio.calibration.quantity import Quantity
from torsio.knob import Knob

__all__ = ["change", "felt", "lines", "number", "proposals"]


def number(quantity: Quantity) -> str:
    """Give a value to the digits that its uncertainty leaves, and the uncertainty."""
    sigma = quantity.standard_uncertainty
    if sigma <= 0.0:
        return f"{quantity.value:.4g}"
    return f"{quantity.value:.4g} +- {sigma:.2g}"


def felt(name: str, value: float, error: float) -> str:
    """Give an error in JNDs, in words; empty where none is known."""
    jnds = perception.jnds_of(name, value, error)
    if jnds is None:
        return ""
    return "< 0.01 JND" if jnds < 0.01 else perception.text(jnds)


def lines(calibration: Calibration) -> list[tuple[str, str, str, str]]:
    """Give name, value with uncertainty, that in JNDs, and meaning of all that was found."""
    found = [
        (of.name, number(of), felt(of.name, of.value, of.standard_uncertainty), of.meaning)
        for of in calibration.quantities.values()
    ]
    if calibration.cogging is not None and calibration.cogging.periods_per_rev:
        waves = ", ".join(
            f"{periods} ({1e3 * amplitude:.2g} mN m)"
            for periods, amplitude in zip(
                calibration.cogging.periods_per_rev, calibration.cogging.amplitudes_nm, strict=True
            )
        )
        found.append(("periods_per_rev", waves, "", "of the cogging's waves"))
    if calibration.brake_curve is not None:
        words = calibration.brake_curve.in_words()
        found.append(("brake_curve", words, "", "brake's torque over its current"))
    return found


def change(name: str, old: float | str, new: float | str) -> str:
    """Say how a value changes, and what a finger would make of that."""
    if isinstance(old, str) or isinstance(new, str):
        return f"{name}: {old} -> {new}"
    jnds = felt(name, old, new - old)
    return f"{name}: {old:.4g} -> {new:.4g}" + (f" ({jnds})" if jnds else "")


def proposals(knob: Knob, found: Calibration) -> list[tuple[str, float | str, float | str]]:
    """Give the fields of a knob's configuration that a proposal changes, with both values."""
    control = knob.control_config()
    old = asdict(knob.actuator_config()) | asdict(knob.shaft_config())
    old |= {"law": control.law, "free_assist_nm": control.free_assist_nm}
    new = asdict(found.actuator) | asdict(found.shaft)
    if found.board is not None:
        old |= asdict(knob.board_config())
        new |= asdict(found.board)
    new |= {"law": found.law, "free_assist_nm": found.free_assist_nm}
    return [(name, old[name], new[name]) for name in old if old[name] != new[name]]
