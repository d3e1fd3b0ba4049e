"""The bill of materials, and whether every choice has what the configuration assumes."""

from __future__ import annotations

import csv
import io
import operator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from torsio_hardware.knob import Knob

FILE = Path(__file__).parent / "parts.csv"
# The board's analogue inputs stand no more; its 3V3 feeds the current sensor, see `wires`.
ANALOGUE_V = 3.3
# The braking motor's energy must go before the board sees too much: docs/reference/hardware.md.
CLAMP_BELOW_V = 13.3
FASTEST_RAD_S = 160.0  # calibration turns with it


@dataclass(frozen=True)
class Part:
    """A row of `parts.csv`: one way to fill a place."""

    place: str
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
        return [
            Part(
                quantity=int(row.pop("quantity")),
                is_first=row.pop("choice") == "first",
                ratings={
                    name: _rating(value)
                    for name, value in (pair.split("=") for pair in row.pop("ratings").split())
                },
                price_eur=(float(row.pop("price_low_eur")), float(row.pop("price_high_eur"))),
                **row,
            )
            for row in csv.DictReader(file)
        ]


_TESTS = {"at least": operator.ge, "at most": operator.le, "exactly": operator.eq}
Rule = tuple[str, str, Any]


def rules(knob: Knob) -> dict[str, list[Rule]]:
    """Give what the configuration asks of each place: a rating, and what it must be."""
    of = knob.number
    supply_v, kt = of("supply_v"), of("motor_torque_constant_nm_per_a")
    torque_nm, motor_a = of("motor_torque_max_nm"), 1.5 * of("motor_current_max_a")
    swing_v = of("current_sense_v_per_a") * motor_a
    # A motor feeds most back with half of its voltage at its winding.
    fed_back_w = (kt * FASTEST_RAD_S) ** 2 / (4 * of("motor_resistance_ohm"))
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
            ("coil_a", "at least", of("brake_current_max_a")),
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
            ("speed_rpm", "at least", 9.55 * FASTEST_RAD_S),
        ],
        "choke": [("saturation_a", "at least", of("motor_current_max_a"))],
        "supply": [("supply_v", "exactly", supply_v), ("current_a", "at least", 4)],
        "emergency_stop": [("contact", "exactly", "opens"), ("contacts", "at least", 2)],
        "clamp": [
            ("low_v", "at least", knob.values["supply_v"].band()[1]),
            ("high_v", "at most", CLAMP_BELOW_V), ("current_a", "at least", fed_back_w / supply_v),
        ],
        "capacitor": [
            ("capacitance_f", "at least", 0.0022), ("voltage_v", "at least", 1.5 * supply_v)
        ],
        "resistors": [("resistance_ohm", "at most", 8200)],  # erratum RP2350-E9
        "divider": [("ratio", "exactly", of("supply_sense_ratio"))],
        "encoder_dividers": [("ratio", "at least", 5 / ANALOGUE_V), ("ratio", "at most", 2.5)],
        "filament": [("material", "exactly", knob.spring.material.name)],
    }  # fmt: skip


def chosen(parts: list[Part], knob: Knob) -> dict[str, Part]:
    """Give the part of each place that a knob's file names, or else the first choice.

    Raises `ValueError` of an unknown number.
    """
    found = {part.place: part for part in parts if part.is_first}
    for place, number in knob.parts.items():
        known = {part.number: part for part in parts if part.place == place}
        if number not in known:
            raise ValueError(f"[parts] {place} = {number!r}: parts.csv has {', '.join(known)}")
        found[place] = known[number]
    return found


def total_eur(knob: Knob) -> tuple[float, float]:
    """Return what a knob's parts cost together, lowest and highest."""
    of = chosen(load(), knob).values()
    low, high = (sum(part.quantity * part.price_eur[k] for part in of) for k in (0, 1))
    return low, high


def bill(knob: Knob) -> str:
    """Give a knob's parts with totals, as CSV."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(["part", "quantity", "maker", "number", "low_eur", "high_eur", "source"])
    writer.writerows(
        [part.place, part.quantity, part.maker, part.number, *part.price_eur, part.source]
        for part in chosen(load(), knob).values()
    )
    writer.writerow(["total", "", "", "", *total_eur(knob), ""])
    return text.getvalue()


def differences(parts: list[Part], knob: Knob) -> list[str]:
    """Name every value of the file that is more than two uncertainties off its part's."""
    roles = ("motor", "brake", "choke")
    motor, brake, choke = (chosen(parts, knob)[role].ratings for role in roles)
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
