"""The bill of materials, and whether every choice has what the configuration assumes."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from torsio_hardware.knob import Knob

FILE = Path(__file__).parent / "parts.csv"
_SENSOR_HALF_RANGE_V = 1.65
_PULL_DOWN_MOST_OHM = 8200.0  # a floating pin of an early RP2350 stays half high above it


@dataclass(frozen=True)
class Part:
    """A row of `parts.csv`: one way to fill a place.

    Attributes
    ----------
    ratings
        By name, with units; text where the rating is a word.
    price_eur
        Lowest and highest for one.
    source
        Where ratings and price come from. What was not looked up is an estimate: check it.
    """

    place: str
    role: str
    quantity: int
    maker: str
    number: str
    is_first: bool
    ratings: dict[str, Any]
    matters: str
    price_eur: tuple[float, float]
    date: str
    source: str


def _rating(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text


def _part(row: dict[str, str]) -> Part:
    pairs = (word.partition("=") for word in row["ratings"].split())
    return Part(
        row["part"],
        row["role"],
        int(row["quantity"]),
        row["maker"],
        row["number"],
        row["choice"] == "first",
        {name: _rating(value) for name, _, value in pairs},
        row["matters"],
        (float(row["price_low_eur"]), float(row["price_high_eur"])),
        row["date"],
        row["source"],
    )


def load(path: Path = FILE) -> list[Part]:
    """Read the bill of materials.

    Raises
    ------
    ValueError
        If a row has a number that is none.
    """
    with path.open(encoding="utf-8", newline="") as file:
        return [_part(row) for row in csv.DictReader(file)]


def total_eur(parts: list[Part]) -> tuple[float, float]:
    """Return what the first choices cost together, lowest and highest."""
    first = [part for part in parts if part.is_first]
    low, high = (sum(part.quantity * part.price_eur[k] for part in first) for k in (0, 1))
    return low, high


Rule = Callable[[dict[str, Any], Knob], bool]


def _motor(rated: dict[str, Any], knob: Knob) -> bool:
    """Torque within the board's current, and within the bridge's range at rest."""
    needed_a = knob.number("motor_torque_max_nm") / rated["kt_nm_per_a"]
    volts = needed_a * rated["resistance_ohm"]
    lasting_a = float(rated["continuous_a"])
    return bool(
        needed_a <= knob.number("motor_current_max_a") and volts < knob.number("supply_v")
    ) and lasting_a >= knob.number("motor_current_continuous_a")


# Of each place: what is asked, and the test.
RULES: dict[str, tuple[str, Rule]] = {
    "motor": ("full torque within 2 A and 12 V, 1 A for ever", _motor),
    "brake": (
        "110 mN m, a coil for the supply that takes no more than the bridge's limit",
        lambda rated, knob: (
            rated["torque_nm"] >= knob.number("brake_torque_max_nm")
            and rated["coil_v"] <= knob.number("supply_v")
            and rated["coil_a"] <= knob.number("brake_current_max_a")
        ),
    ),
    "motor_bridge": (
        "40 kHz, enable, fault, the supply with 25 % to spare, the continuous current",
        lambda rated, knob: (
            rated["pwm_hz"] >= 40_000
            and rated["enable"] == rated["fault"] == 1
            and rated["supply_v"] >= 1.25 * knob.number("supply_v")
            and rated["continuous_a"] >= knob.number("motor_current_continuous_a")
        ),
    ),
    "brake_bridge": (
        "the coil's current",
        lambda rated, knob: (
            rated["continuous_a"] >= knob.number("brake_current_max_a")
            and rated["supply_v"] >= 1.25 * knob.number("supply_v")
        ),
    ),
    "current_sensor": (
        "both directions to one and a half times the limit, within 3.3 V; faster than the loop",
        lambda rated, knob: (
            rated["range_a"] >= 1.5 * knob.number("motor_current_max_a")
            and rated["sensitivity_v_per_a"] == knob.number("current_sense_v_per_a")
            and 1.5 * knob.number("motor_current_max_a") * rated["sensitivity_v_per_a"]
            <= _SENSOR_HALF_RANGE_V
            and rated["bandwidth_hz"] >= 40_000
        ),
    ),
    "encoder": (
        "counts a turn, at 160 rad/s",
        lambda rated, knob: (
            4 * rated["lines"] == knob.number("counts_per_rev") and rated["speed_rpm"] >= 160 * 9.55
        ),
    ),
    "choke": (
        "carries the limit without saturation",
        lambda rated, knob: rated["saturation_a"] >= knob.number("motor_current_max_a"),
    ),
    "supply": (
        "the supply's volts, and motor, brake and a reserve",
        lambda rated, knob: (
            rated["supply_v"] == knob.number("supply_v") and rated["current_a"] >= 4.0
        ),
    ),
    "emergency_stop": ("opens when pressed", lambda rated, knob: rated["contact"] == "opens"),
    "capacitor": (
        "2200 uF, for more than the supply",
        lambda rated, knob: (
            rated["capacitance_f"] >= 0.0022 and rated["voltage_v"] >= 1.5 * knob.number("supply_v")
        ),
    ),
    "resistors": (
        "strong enough a pull-down",
        lambda rated, knob: rated["resistance_ohm"] <= _PULL_DOWN_MOST_OHM,
    ),
    "divider": (
        "the ratio that is configured",
        lambda rated, knob: rated["ratio"] == knob.number("supply_sense_ratio"),
    ),
    "filament": (
        "the spring's material",
        lambda rated, knob: rated["material"] == knob.spring.material.name,
    ),
}


def failures(parts: list[Part], knob: Knob) -> list[str]:
    """Name every part that lacks what the configuration assumes, and what it lacks."""
    found = []
    for part in parts:
        if part.place in RULES:
            asked, rule = RULES[part.place]
            if not rule(part.ratings, knob):
                found.append(f"{part.place}: {part.maker} {part.number} lacks: {asked}")
    return found


def wiring(knob: Knob) -> list[tuple[str, str, str]]:
    """Give every wire of the harness: from, to, and what it carries; pins as configured."""
    pin = {name: f"board GP{number}" for name, number in knob.pins.items()}
    second = {name: f"board GP{number + 1}" for name, number in knob.pins.items()}
    return [
        (pin["encoder_pin"], "encoder A", "signal, 3.3 V"),
        (second["encoder_pin"], "encoder B", "signal, 3.3 V"),
        (pin["motor_pin"], "motor bridge IN1", "PWM, 4.7 kohm to ground"),
        (second["motor_pin"], "motor bridge IN2", "PWM, 4.7 kohm to ground"),
        (pin["brake_pin"], "brake bridge IN1", "PWM, 4.7 kohm to ground"),
        (second["brake_pin"], "brake bridge IN2", "PWM, 4.7 kohm to ground"),
        (pin["enable_pin"], "both bridges SLEEP", "enable, 4.7 kohm to ground"),
        (pin["emergency_stop_pin"], "emergency stop", "to ground, opens when pressed"),
        (pin["driver_fault_pin"], "both bridges FAULT", "low on an error"),
        (pin["current_sense_pin"], "current sensor OUT", "1.65 V at no current"),
        (pin["supply_sense_pin"], "divider 100 and 10 kohm", "supply over 11"),
        ("motor bridge OUT1", "choke, current sensor, motor +", "2 A"),
        ("motor bridge OUT2", "motor -", "2 A"),
        ("brake bridge OUT1", "brake coil", "0.3 A"),
        ("brake bridge OUT2", "brake coil", "0.3 A"),
        ("supply 12 V", "both bridges VM, 2200 uF", "4 A, fuse"),
        ("supply ground", "all grounds in one point", "4 A"),
        ("board 3.3 V", "current sensor VCC", "10 mA"),
        ("board VBUS", "encoder VCC", "5 V, 20 mA"),
    ]


def harness_svg(knob: Knob) -> str:
    """Draw the harness: a line for each wire, with what it carries."""
    wires = wiring(knob)
    rows = []
    for n, (begin, end, carries) in enumerate(wires):
        y = 40 + 26 * n
        rows.append(
            f'<rect x="20" y="{y - 14}" width="170" height="20"/>'
            f'<text x="26" y="{y}">{begin}</text>'
            f'<line x1="190" y1="{y - 4}" x2="480" y2="{y - 4}"/>'
            f'<text class="small" x="205" y="{y - 8}">{n + 1}: {carries}</text>'
            f'<rect x="480" y="{y - 14}" width="230" height="20"/>'
            f'<text x="486" y="{y}">{end}</text>'
        )
    height = 40 + 26 * len(wires)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 730 {height}">'
        "<style>rect{fill:#eef3f7;stroke:#345}line{stroke:#a33;stroke-width:1.5}"
        "text{font:12px sans-serif}.small{font-size:10px;fill:#555}</style>"
        f'<rect x="0" y="0" width="730" height="{height}" style="fill:#fff;stroke:none"/>'
        f"{''.join(rows)}</svg>\n"
    )
