"""The bill of materials: complete, and of parts that the configuration can live with."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from torsio_hardware import parts
from torsio_hardware.knob import Knob, load

TREE = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def knob() -> Knob:
    return load()


def test_every_place_has_a_first_choice_and_two_alternatives() -> None:
    found = parts.load()
    first = Counter(part.place for part in found if part.is_first)
    others = Counter(part.place for part in found if not part.is_first)
    assert set(first.values()) == {1}
    assert set(others.values()) == {2}
    assert first.keys() == others.keys()
    for part in found:
        assert part.maker
        assert part.number
        assert part.matters
        assert re.fullmatch(r"\d{4}-\d\d-\d\d", part.date)
        assert 0 <= part.price_eur[0] <= part.price_eur[1]
        assert part.source


def test_every_choice_has_what_the_configuration_assumes(knob: Knob) -> None:
    assert parts.failures(parts.load(), knob) == []


@pytest.mark.parametrize(
    ("place", "rating", "value"),
    [
        ("motor", "kt_nm_per_a", 0.03),
        ("brake", "coil_v", 24.0),
        ("motor_bridge", "pwm_hz", 20_000.0),
        ("current_sensor", "sensitivity_v_per_a", 0.6),
        ("encoder", "lines", 1000.0),
        ("supply", "supply_v", 24.0),
        ("emergency_stop", "contact", "closes"),
        ("resistors", "resistance_ohm", 10_000.0),
        ("divider", "ratio", 16.0),
        ("filament", "material", "pla"),
    ],
)
def test_part_that_lacks_a_rating_is_named(
    knob: Knob, place: str, rating: str, value: object
) -> None:
    part = next(part for part in parts.load() if part.place == place)
    worse = replace(part, ratings={**part.ratings, rating: value})
    (told,) = parts.failures([worse], knob)
    assert told.startswith(f"{place}: ")


def test_parts_of_the_file_are_in_the_bill(knob: Knob) -> None:
    numbers = {(part.role, part.number) for part in parts.load()}
    assert {(role, number) for role, number in knob.parts.items()} <= numbers


def test_totals_are_sums_of_first_choices() -> None:
    low, high = parts.total_eur(parts.load())
    rows = [part for part in parts.load() if part.is_first]
    assert low == sum(part.quantity * part.price_eur[0] for part in rows)
    assert 500 < low < high < 1500


def test_harness_has_every_pin_of_the_board_once(knob: Knob) -> None:
    drawn = re.findall(r"board GP(\d+)", parts.harness_svg(knob))
    assert Counter(map(int, drawn)) == Counter([2, 3, 6, 7, 8, 9, 10, 11, 12, 26, 27])


def test_page_has_the_figures_and_prices_of_the_file(knob: Knob) -> None:
    page = (TREE / "docs/how-to/build.md").read_text(encoding="utf-8")
    rows = re.findall(
        r"^\| (?:Encoder|Supply|Brake|Calibrate) \| .* \| (\S+) to (\S+) \|$", page, re.M
    )
    told = [tuple(map(float, row)) for row in rows]
    assert len(told) == len(knob.expected())
    for found, (_, name, band, _) in zip(told, knob.expected(), strict=True):
        assert found == pytest.approx(band, rel=5e-3, abs=1e-9), name
    low, high = parts.total_eur(parts.load())
    assert f"{round(low, -1):.0f} to {round(high, -1):,.0f} EUR" in page
    manifest = (TREE / "hardware/okh.toml").read_text(encoding="utf-8")
    named = re.findall(r'"([^"]+\.(?:md|csv|toml|py))"', manifest)
    assert len(named) >= 5
    assert [file for file in named if not (TREE / "hardware" / file).exists()] == []
