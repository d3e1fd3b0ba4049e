"""Text about a calibration: its quantities, its drifts and the changes that it proposes."""

from __future__ import annotations

import math
from dataclasses import asdict

from torsio import perception
from torsio.calibration.proposal import Calibration
from torsio.knob import Knob

__all__ = ["cause", "change", "felt", "lines", "number", "proposals"]

_MOST_DIGITS = 9
# Least and most share of a configured value that wear explains, and what is wrong beyond it.
_CAUSES = {
    "spring_stiffness_nm_per_rad": (
        (0.8, 1.25),
        "a loose belt, a hub that slips, or a shaft that was made otherwise",
    ),
    "brake_drag_nm": ((0.0, 2.0), "a brake that stands askew, a tight belt"),
    "knob_coulomb_nm": ((0.0, 2.0), "a knob that rubs"),
}


def number(value: float, sigma: float) -> str:
    """Give a value to the digits that its uncertainty leaves, and the uncertainty."""
    if sigma <= 0.0:
        return f"{value:.4g}"
    last = math.floor(math.log10(sigma)) - 1  # the uncertainty's second digit
    rounded, spread = round(value, -last), f"{sigma:#.2g}".removesuffix(".")
    if rounded == 0.0:
        return f"0 +- {spread}"
    digits = math.floor(math.log10(abs(rounded))) - last + 1
    text = f"{rounded:#.{min(max(digits, 1), _MOST_DIGITS)}g}".replace(".e", "e")
    return f"{text.removesuffix('.')} +- {spread}"


def felt(name: str, value: float, error: float) -> str:
    """Give an error in JNDs, in words; empty where none is known."""
    jnds = perception.jnds_of(name, value, error)
    if jnds is None:
        return ""
    return "< 0.01 JND" if jnds < 0.01 else perception.text(jnds)


def lines(calibration: Calibration) -> list[tuple[str, str, str, str]]:
    """Give name, value with uncertainty, that in JNDs, and meaning of all that was found."""
    found = [
        (of.name, number(of.value, sigma), felt(of.name, of.value, sigma), of.meaning)
        for of in calibration.quantities.values()
        for sigma in (of.standard_uncertainty,)
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
    """Say how a value changes, with digits enough to see it, and what a finger makes of that."""
    if isinstance(old, str) or isinstance(new, str):
        return f"{name}: {old} -> {new}"
    jnds = felt(name, old, new - old)
    both = ((f"{old:.{digits}g}", f"{new:.{digits}g}") for digits in range(4, _MOST_DIGITS + 1))
    before, after = next((two for two in both if two[0] != two[1]), (f"{old:.4g}",) * 2)
    return f"{name}: {before} -> {after}" + (f" ({jnds})" if jnds else "")


def cause(name: str, old: float | str, new: float | str) -> str:
    """Say what may be wrong with a knob whose value is far from the configured one, or nothing."""
    if name not in _CAUSES or isinstance(old, str) or isinstance(new, str):
        return ""
    (least, most), words = _CAUSES[name]
    return "" if least * old <= new <= most * old else f"; look for {words}"


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
