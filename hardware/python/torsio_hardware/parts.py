"""The bill of materials, and whether every choice has what the configuration assumes."""

from __future__ import annotations

import csv
import operator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from torsio_hardware.knob import Knob

FILE = Path(__file__).parent / "parts.csv"
# The board's analogue inputs stand no more; its 3V3 feeds the current sensor, see `wires`.
ANALOGUE_V = 3.3


@dataclass(frozen=True)
class Part:
    """A row of `parts.csv`: one way to fill a place."""

    place: str
    role: str
    quantity: int
    maker: str
    number: str
    is_first: bool
    ratings: dict[str, Any]  # by name, with units; text where the rating is a word
    matters: str
    price_eur: tuple[float, float]  # lowest and highest for one
    date: str
    source: str  # of ratings and price; what is `assumed` there was not looked up: check it


def _rating(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text


def load() -> list[Part]:
    """Read the bill of materials."""
    with FILE.open(encoding="utf-8", newline="") as file:
        _, *rows = csv.reader(file)
    return [
        Part(
            place, role, int(quantity), maker, number, choice == "first",
            {name: _rating(value) for name, value in (pair.split("=") for pair in ratings.split())},
            matters, (float(low), float(high)), date, source,
        )
        for place, role, quantity, maker, number, choice, ratings, matters, low, high, date, source
        in rows
    ]  # fmt: skip


def total_eur(parts: list[Part]) -> tuple[float, float]:
    """Return what the first choices cost together, lowest and highest."""
    first = [part for part in parts if part.is_first]
    low, high = (sum(part.quantity * part.price_eur[k] for part in first) for k in (0, 1))
    return low, high


_TESTS = {"at least": operator.ge, "at most": operator.le, "exactly": operator.eq}
Rule = tuple[str, str, Any]


def rules(knob: Knob) -> dict[str, list[Rule]]:
    """Give what the configuration asks of each place: a rating, and what it must be."""
    of = knob.number
    supply_v, kt = of("supply_v"), of("motor_torque_constant_nm_per_a")
    torque_nm, motor_a = of("motor_torque_max_nm"), 1.5 * of("motor_current_max_a")
    swing_v = of("current_sense_v_per_a") * motor_a
    bridge: list[Rule] = [
        ("pwm_hz", "at least", 40e3),
        ("enable", "exactly", 1),
        ("fault", "exactly", 1),
        ("supply_v", "at least", 1.25 * supply_v),
    ]
    return {
        "motor": [
            ("kt_nm_per_a", "at least", torque_nm / of("motor_current_max_a")),
            ("resistance_ohm", "at most", supply_v * kt / torque_nm),
            ("continuous_a", "at least", of("motor_current_continuous_a")),
        ],
        "brake": [
            ("torque_nm", "at least", of("brake_torque_max_nm")), ("coil_v", "at most", supply_v),
            ("coil_a", "at most", of("brake_current_max_a")),
        ],
        "motor_bridge": [*bridge, ("continuous_a", "at least", of("motor_current_continuous_a"))],
        "brake_bridge": [*bridge, ("continuous_a", "at least", of("brake_current_max_a"))],
        "current_sensor": [  # an over-current is 1.5 times the motor's limit
            ("range_a", "at least", motor_a), ("bandwidth_hz", "at least", 40e3),
            ("sensitivity_v_per_a", "exactly", of("current_sense_v_per_a")),
            ("supply_min_v", "at most", ANALOGUE_V), ("supply_max_v", "at least", ANALOGUE_V),
            ("zero_v", "at least", swing_v), ("zero_v", "at most", ANALOGUE_V - swing_v),
        ],
        "encoder": [
            ("lines", "exactly", of("counts_per_rev") / 4),
            ("speed_rpm", "at least", 160 * 9.55),  # calibration turns with 160 rad/s
        ],
        "choke": [("saturation_a", "at least", of("motor_current_max_a"))],
        "supply": [("supply_v", "exactly", supply_v), ("current_a", "at least", 4)],
        "emergency_stop": [("contact", "exactly", "opens")],
        "capacitor": [
            ("capacitance_f", "at least", 0.0022), ("voltage_v", "at least", 1.5 * supply_v)
        ],
        "resistors": [("resistance_ohm", "at most", 8200)],  # erratum RP2350-E9
        "divider": [("ratio", "exactly", of("supply_sense_ratio"))],
        "filament": [("material", "exactly", knob.spring.material.name)],
    }  # fmt: skip


def named(parts: list[Part], knob: Knob) -> dict[str, Part]:
    """Look up the parts that a knob's file names, by roles; `ValueError` of an unknown number."""
    found = {}
    for role, number in knob.parts.items():
        known = {part.number: part for part in parts if part.role == role}
        if number not in known:
            raise ValueError(f"[parts] {role} = {number!r}: parts.csv has {', '.join(known)}")
        found[role] = known[number]
    return found


def differences(parts: list[Part], knob: Knob) -> list[str]:
    """Name every value of the file that is more than two uncertainties off its part's."""
    motor, brake = (named(parts, knob)[role].ratings for role in ("motor", "brake"))
    choke = next(part for part in parts if part.place == "choke" and part.is_first).ratings
    theirs = {
        "motor_torque_constant_nm_per_a": motor["kt_nm_per_a"],
        "motor_resistance_ohm": motor["resistance_ohm"] + choke["resistance_ohm"],
        "brake_torque_constant_nm_per_a": brake["torque_nm"] / brake["coil_a"],
        "brake_resistance_ohm": brake["coil_v"] / brake["coil_a"],
    }
    return [
        f"{name} is {knob.number(name):g} in the file, and {value:.3g} by the parts that it names"
        for name, value in theirs.items()
        if not knob.values[name].band()[0] <= value <= knob.values[name].band()[1]
    ]


def failures(parts: list[Part], knob: Knob) -> list[str]:
    """Name every part that lacks what the configuration assumes, and what it lacks."""
    asked = rules(knob)
    return [
        f"{part.place}: {part.maker} {part.number} has {rating} {part.ratings[rating]}, needs "
        f"{must} {needed}"
        for part in parts
        for rating, must, needed in asked.get(part.place, ())
        if not _TESTS[must](part.ratings[rating], needed)
    ]
