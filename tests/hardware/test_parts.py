"""The bill of materials: complete, and of parts that the configuration can live with."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from torsio_hardware import parts, wires
from torsio_hardware.knob import Knob, load

TREE = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def knob() -> Knob:
    return load()


def test_every_place_has_a_first_choice_and_two_alternatives() -> None:
    found = parts.load()
    for place in {part.place for part in found}:
        choices = [part.is_first for part in found if part.place == place]
        assert sorted(choices) == [False, False, True], place
    for part in found:
        assert all((part.maker, part.number, part.matters, part.source))
        assert re.fullmatch(r"\d{4}-\d\d-\d\d", part.date)
        assert 0 <= part.price_eur[0] <= part.price_eur[1]


def test_every_choice_has_what_the_configuration_assumes(knob: Knob) -> None:
    assert parts.failures(parts.load(), knob) == []


@pytest.mark.parametrize(
    ("place", "rating", "value"),
    [
        ("motor", "kt_nm_per_a", 0.03),
        ("brake", "coil_a", 0.24),
        ("encoder_dividers", "ratio", 1.5),
        ("current_sensor", "sensitivity_v_per_a", 0.88),  # the least of SparkFun's SEN-14544
        ("current_sensor", "supply_min_v", 4.5),  # Allegro's ACS723
        ("current_sensor", "zero_v", 2.8),
        ("encoder", "lines", 1000.0),
        ("emergency_stop", "contact", "closes"),
        ("emergency_stop", "contacts", 1.0),
        ("clamp", "high_v", 15.0),
        ("clamp", "low_v", 12.5),
        ("clamp", "current_a", 0.5),
        ("resistors", "resistance_ohm", 10_000.0),
    ],
)
def test_part_that_lacks_a_rating_is_named(
    knob: Knob, place: str, rating: str, value: object
) -> None:
    part = next(part for part in parts.load() if part.place == place)
    worse = replace(part, ratings={**part.ratings, rating: value})
    told, *_ = parts.failures([worse], knob)
    assert told.startswith(f"{place}: ")
    assert f"has {rating} {value}, needs" in told


def test_current_sensor_is_fed_no_more_than_the_boards_input_bears(knob: Knob) -> None:
    (fed,) = [begin for begin, end, *_ in wires.wiring(knob) if end == "current sensor VCC"]
    assert fed == "board 3V3"
    assert parts.ANALOGUE_V == 3.3  # data sheets of RP2040 and RP2350, pins ADC_AVDD, IOVDD


def test_signals_of_5_v_pass_dividers_in_harness_and_picture(knob: Knob) -> None:
    harness = [(begin, end) for begin, end, *_ in wires.wiring(knob)]
    fed = {end.split()[0] for begin, end in harness if begin == "board VBUS"}
    high = [part for part in parts.load() if part.ratings.get("output_v", 0) > 3.3]
    assert {part.place for part in high} == fed == {"encoder"}
    lines = re.findall(r'polyline points="([^ "]+)[^"]* ([^ "]+)"', wires.board_svg(knob))

    def hole(end: str) -> str:
        column, row = wires.place(end) or (0, 0)
        return f"{20 * column + 20},{20 * row + 40}"

    for n, letter in enumerate("AB"):
        pin, signal = f"board GP{knob.pins['encoder_pin'] + n}", f"encoder {letter}"
        ways = [(pin, f"dividers OUT_{letter}"), (f"dividers IN_{letter}", signal)]
        assert [ends for ends in harness if {pin, signal} & {*ends}] == ways
        drawn = [(hole(begin), hole(end)) for begin, end in ways]
        assert [ends for ends in lines if {hole(pin), hole(signal)} & {*ends}] == drawn
    assert set(wires.MODULES) == set(wires.GROUNDS)


def test_clamp_acts_between_the_supply_and_the_boards_limit(knob: Knob) -> None:
    """By the resistors that the bill names; the page of hardware has the limit."""
    page = (TREE / "docs/reference/hardware.md").read_text(encoding="utf-8")
    (limit,) = re.findall(r"A clamp must act below ([\d.]+) V", page)
    assert float(limit) == parts.CLAMP_BELOW_V
    for part in (part for part in parts.load() if part.place == "clamp"):
        above, below = map(float, re.findall(r"([\d.]+) and ([\d.]+) kohm", part.matters)[0])
        clamp_v = 2.495 * (1 + above / below)
        assert clamp_v == pytest.approx(knob.number("clamp_v"), abs=0.05)
        assert part.ratings["low_v"] < clamp_v < part.ratings["high_v"]


def test_emergency_stop_takes_the_enable_from_both_bridges_without_software(knob: Knob) -> None:
    enabled = {end: begin for begin, end, *_ in wires.wiring(knob) if "SLEEP" in end}
    assert set(enabled.values()) == {"stop contact 2 out"}
    assert len(enabled) == 2
    assert set(enabled) & set(wires.PULLED_DOWN)
    (board,) = [begin for begin, end, *_ in wires.wiring(knob) if end == "stop contact 2"]
    assert board == f"board GP{knob.pins['enable_pin']}"


def test_parts_of_the_file_are_in_the_bill(knob: Knob) -> None:
    found = parts.chosen(parts.load(), knob)
    assert {role: found[role].number for role in knob.parts} == knob.parts
    assert parts.differences(parts.load(), knob) == []


def test_file_whose_values_are_of_another_part_is_told(knob: Knob) -> None:
    other = replace(knob, parts={**knob.parts, "motor": "148877"})
    rows = [line.split(",") for line in parts.bill(other).splitlines()]
    (motor,) = [row for row in rows if row[0] == "motor"]
    assert motor[3:6] == ["148877", "350.0", "550.0"]  # 100 EUR more than the first choice
    assert float(rows[-1][4]) == parts.total_eur(knob)[0] + 100
    told = parts.differences(parts.load(), other)
    assert [words.split()[0] for words in told] == [
        "motor_torque_constant_nm_per_a",
        "motor_resistance_ohm",
    ]
    with pytest.raises(ValueError, match=r"motor = 'RE 30': parts\.csv has 310009"):
        parts.chosen(parts.load(), replace(knob, parts={"motor": "RE 30"}))


def test_harness_and_board_have_every_pin_of_the_file(knob: Knob) -> None:
    moved = replace(knob, pins={**knob.pins, "motor_pin": 20, "supply_sense_pin": 28})
    for of, pins in ((knob, {6, 7, 27}), (moved, {20, 21, 28})):
        for drawn in (wires.harness_svg(of), wires.board_svg(of)):
            found = set(map(int, re.findall(r"GP(\d+)", drawn)))
            assert found == {2, 3, 8, 9, 10, 11, 12, 26} | pins


def test_board_has_pins_where_a_pico_has_them_and_nothing_in_two_holes(knob: Knob) -> None:
    # As printed on the board, beside its holes 1 to 40.
    pins = {0: 1, 2: 4, 6: 9, 9: 12, 10: 14, 15: 20, 16: 21, 17: 22, 18: 24, 22: 29, 26: 31, 28: 34}
    assert {gp: wires.PICO[f"board GP{gp}"] for gp in pins} == pins
    assert len(set(wires.PICO.values())) == len(wires.PICO)
    taken = Counter(
        (column, row)
        for left, top, right, bottom in wires.MODULES.values()
        for column in range(left, right + 1)
        for row in range(top, bottom + 1)
    )
    assert max(taken.values()) == 1
    assert max(taken) < wires.HOLES
    for begin, end, *_ in wires.wiring(knob):
        for name in (begin, end):
            hole = wires.place(name)
            assert hole is None or hole in taken, name
    # Off the board are only turning parts and parts on their own terminals.
    off = {end for *ends, _, _ in wires.wiring(knob) for end in ends if not wires.place(end)}
    assert all(re.search("OUT[12]|motor [+-]|coil|ground", end) for end in off)


def test_page_has_the_figures_and_prices_of_the_file(knob: Knob) -> None:
    pages = ("how-to/build.md", "reference/reference-knob.md")
    page = "".join((TREE / "docs" / name).read_text(encoding="utf-8") for name in pages)
    rows = re.findall(r"^\| ([\w ]+) \| .* \| (\S+) to (\S+) \|$", page, re.M)
    for (step, *found), (of, name, band) in zip(rows, knob.expected(), strict=True):
        assert step == of
        assert tuple(map(float, found)) == pytest.approx(band, rel=5e-3, abs=1e-9), name
    # What is out of its band has a row with likely causes.
    causes = page[page.index("| out of its band |") :]
    named = [
        name
        for cell in re.findall(r"^\| ([^|]+) \| .* \|$", causes, re.M)
        for name in cell.split(", ")
    ]
    figures = re.findall(r"^\| [\w ]+ \| (.*) \| \S+ to \S+ \|$", page, re.M)
    assert len(figures) == len(rows)
    assert [of for of in figures if not any(of.startswith(name) for name in named)] == []
    low, high = parts.total_eur(knob)
    price = f"{round(low, -1):.0f} to {round(high, -1):,.0f} EUR"
    assert price in page
    assert price in (TREE / "README.md").read_text(encoding="utf-8")
    manifest = (TREE / "hardware/okh.toml").read_text(encoding="utf-8")
    named = re.findall(r'"([^"]+\.(?:md|csv|toml|py))"', manifest)
    assert len(named) >= 5
    assert [file for file in named if not (TREE / "hardware" / file).exists()] == []
