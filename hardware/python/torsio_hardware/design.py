"""The spring of one knob: how stiff, how straight, how strained, and how sure all that is."""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from torsio.common.whole_file import text_of
from torsio_hardware.flexure import SHAPES, Bent, Flexure, bend

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

LINEAR_TO_RAD = 0.04
"""Full brake torque twists the reference shaft by 0.038 rad."""
FULL_NM = 0.11  # of the reference brake
LINEAR_WITHIN = 0.01
TWISTS_RAD = (0.0005, 0.005, 0.01, 0.015, 0.02, 0.03, 0.04)
# By CalculiX in three dimensions over plane stress, for arms of 18 mm and a width of 5 to 7 mm.
# Short spokes as wide as 8 mm on 12 mm have 1.12.
PLATES = {"spoke": 1.07, "spiral": 1.085, "meander": 1.09}
_PLATE_UNCERTAINTY = 0.03


@dataclass(frozen=True)
class Range:
    """A value with the least and the most that one must expect."""

    value: float
    low: float
    high: float

    @property
    def relative_uncertainty(self) -> float:
        """Return the standard uncertainty of values as likely all over the range."""
        return (self.high - self.low) / math.sqrt(12) / self.value


@dataclass(frozen=True)
class Material:
    """A plastic as printed; `materials.toml` has the sources."""

    name: str
    modulus_pa: Range
    strain_limit: float
    creep_gain_at_1_h: Range
    creep_power: float

    def creep(self, hours: float) -> Range:
        """Return what a twist under a held torque has become after some hours, over its first."""
        gain, grown = self.creep_gain_at_1_h, hours**self.creep_power
        return Range(1 + gain.value * grown, 1 + gain.low * grown, 1 + gain.high * grown)


def read_toml(path: Path) -> dict[str, Any]:
    """Read a file. Raises `ValueError` if it is no TOML, `OSError` if it cannot be read."""
    text = text_of(path)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is no TOML: {error}") from None


def material(name: str) -> Material:
    """Look a material up. Raises `ValueError` if there is none of that name."""
    known = read_toml(Path(__file__).parent / "materials.toml")
    if name not in known:
        raise ValueError(f"no material {name!r}; known are {', '.join(known)}")
    row = known[name]
    modulus, gain = (Range(**row[key]) for key in ("modulus_pa", "creep_gain_at_1_h"))
    return Material(name, modulus, row["strain_limit"], gain, row["creep_power"])


def twist(flexure: Flexure, of: Material, twists_rad: Any) -> Bent:
    """Twist a flexure of a material as the plate that it is, stiffer than plane stress says.

    Raises `ArithmeticError` if it cannot be twisted so far.
    """
    bent = bend(flexure, of.modulus_pa.value, twists_rad)
    return replace(bent, torque_nm=PLATES[flexure.family] * bent.torque_nm)


@dataclass(frozen=True)
class Spring:
    """A flexure of a material, and what to expect of it."""

    flexure: Flexure
    material: Material
    bent: Bent
    stiffness_nm_per_rad: float  # at small twists, plates' stiffness included
    relative_uncertainty: float  # of it, standard: modulus, walls and the model
    deviation: float  # of the secant from that line, the most up to `LINEAR_TO_RAD`
    strain: float  # the largest at `LINEAR_TO_RAD`
    within_m: float  # how far the printer may leave walls off
    thinner: float  # stiffness over the nominal one, with such walls
    thicker: float

    @property
    def safety(self) -> float:
        """Return the strain limit over the largest strain; 1 and more is safe."""
        return self.material.strain_limit / self.strain

    def strain_at(self, torque_nm: float) -> float:
        """Return the largest strain under a torque; `ArithmeticError` if it is too much."""
        far = 2 * torque_nm / self.stiffness_nm_per_rad
        bent = twist(self.flexure, self.material, np.linspace(far / 20, far, 20))
        if torque_nm > bent.torque_nm[-1]:
            raise ArithmeticError(f"{torque_nm:g} N m is more than the spring bears")
        return float(np.interp(torque_nm, bent.torque_nm, bent.strain))

    def shaft_config(self) -> dict[str, float]:
        """Return the fields of ShaftConfig: knees where the slope has changed by 1 % and more."""
        slopes = np.diff(self.bent.torque_nm, prepend=0.0) / np.diff(
            self.bent.twist_rad, prepend=0.0
        )
        found: dict[str, float] = {}
        last = slopes[0]
        for begin, slope in zip(self.bent.twist_rad[:-1], slopes[1:], strict=True):
            if abs(slope / last - 1) >= LINEAR_WITHIN and len(found) < 8:
                number = len(found) // 2 + 1
                found[f"knee_{number}_rad"] = float(begin)
                found[f"knee_{number}_nm_per_rad"] = float(slope)
                last = slope
        return found

    def as_dict(self, torque_nm: float) -> dict[str, Any]:
        """For JSON: its fields, and figures that follow from them and from the largest torque."""
        return {
            **asdict(self),
            "family": self.flexure.family,
            "shaft_config": self.shaft_config(),
            "strain_at_torque": self.strain_at(torque_nm),
            "safety": self.safety,
            "twist_after_held_wall": {
                f"{hours:g} h": vars(self.material.creep(hours)) for hours in (0.1, 1, 8)
            },
        }


def examine(
    flexure: Flexure, of: Material, stiffness_nm_per_rad: float, within_m: float = 0.05e-3
) -> Spring:
    """Make a flexure as wide as a stiffness takes, to 0.01 mm, and compute all that is known of it.

    Its walls are off by `within_m` at two deviations. Raises `ArithmeticError` if it cannot be
    twisted by 0.04 rad.
    """
    bent = twist(flexure, of, TWISTS_RAD)
    wider = stiffness_nm_per_rad / float(bent.stiffness_nm_per_rad[0])
    width_m = round(wider * flexure.width_m, 5)
    bent = replace(bent, torque_nm=bent.torque_nm * width_m / flexure.width_m)
    flexure = replace(flexure, width_m=width_m)
    secant = bent.stiffness_nm_per_rad
    thinner, thicker = (
        float(twist(other, of, TWISTS_RAD[:1]).stiffness_nm_per_rad[0] / secant[0])
        for other in (
            replace(flexure, thickness_m=flexure.thickness_m + off) for off in (-within_m, within_m)
        )
    )
    return Spring(
        flexure,
        of,
        bent,
        float(secant[0]),
        math.hypot(of.modulus_pa.relative_uncertainty, (thicker - thinner) / 4, _PLATE_UNCERTAINTY),
        float(np.max(np.abs(secant / secant[0] - 1))),
        float(bent.strain[-1]),
        within_m,
        thinner,
        thicker,
    )


@dataclass(frozen=True)
class Room:
    """The space for a spring, and the printer's limits: line, walls, gap."""

    hub_radius_m: float = 7e-3
    rim_radius_m: float = 25e-3
    line_m: float = 0.45e-3
    within_m: float = 0.05e-3
    gap_m: float = 1e-3
    widths_m: tuple[float, float] = (4e-3, 8e-3)


def candidates(room: Room, family: str) -> Iterator[Flexure]:
    """Give the shapes of a family that a printer can make: walls of whole lines, gaps, bends."""
    lines = (1, 2, 3) if family == "spoke" else (2, 3)
    for arms, count in itertools.product((6, 4, 8, 3), lines):
        common = Flexure(
            arms, room.hub_radius_m, room.rim_radius_m, count * room.line_m, room.widths_m[1]
        )
        if family == "spoke":
            yield common
        elif family == "spiral":
            for wrap in np.arange(0.5, 4.1, 0.5):
                yield replace(common, wrap_rad=float(wrap))
        elif arms % 2 == 0:
            for waves, swing in itertools.product((1, 2), np.arange(0.1, 0.6, 0.04)):
                yield replace(common, swing_rad=float(swing), waves=waves)


def search(room: Room, of: Material, stiffness_nm_per_rad: float, family: str) -> list[Spring]:
    """Find the springs of a family that fit, those that break no rule first, then by strain.

    A rule is the deviation of 1 % up to 0.04 rad, both ways, and the material's strain limit.
    Raises `ValueError` if there is none.
    """
    if family not in SHAPES:
        raise ValueError(f"no family {family!r}; known are {', '.join(SHAPES)}")
    found = []
    for shape in candidates(room, family):
        if shape.gap_m() < room.gap_m or shape.bend_radius_m() < shape.thickness_m:
            continue
        try:
            spring = examine(shape, of, stiffness_nm_per_rad, room.within_m)
            if not room.widths_m[0] <= spring.flexure.width_m <= room.widths_m[1]:
                continue
            if family == "spiral":  # the other way is not the same
                back = twist(shape, of, [-each for each in TWISTS_RAD]).stiffness_nm_per_rad
                off = np.abs(back / back[0] - 1).max()
                spring = replace(spring, deviation=max(spring.deviation, float(off)))
        except (ArithmeticError, ValueError):  # too far, or too narrow
            continue
        found.append(spring)
    if not found:
        raise ValueError(f"no {family} of this stiffness fits into the room of the knob")
    return sorted(
        found, key=lambda s: (s.deviation > LINEAR_WITHIN, s.safety < 1, round(s.strain, 6))
    )
