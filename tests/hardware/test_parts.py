"""The bill of materials: complete, and of parts that the configuration can live with."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace

import pytest

from torsio_hardware import parts
from torsio_hardware.knob import Knob, load


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
