"""`torsio.load_config`: what is in a text, and what may be wrong with it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

import torsio


@pytest.fixture
def knob() -> Iterator[torsio.Knob]:
    with torsio.open("emulated") as knob:
        yield knob


NO_SUCH_TEXT = [
    *("", "no json", "{", "[]", "{} {}", "null", "[" * 100_000, "{" * 100_000),
    *('{"beta": 1}', '{"control_config": 1}', '{"control_config": {}', '{"a": {"b": {}}}'),
    *(
        f'{{"control_config": {{{inside}'
        for inside in (
            *('"beta": }}', '"beta": nan}}', '"beta": -}}', '"beta": 0.5,}}', '"beta": null}}'),
            *('"be\\u0074a": 0.5}}', "beta: 0.5}}", '"beta": "0.5', '"beta": [0.5]}}'),
        )
    ),
]


@pytest.mark.parametrize("text", NO_SUCH_TEXT, ids=lambda text: text[:40])
def test_text_that_is_none_changes_nothing(knob: torsio.Knob, text: str) -> None:
    before = torsio.dump_config(knob)
    with pytest.raises(torsio.InvalidArgument, match=r"this is no text of dump_config\(\)"):
        torsio.load_config(knob, text)
    assert torsio.dump_config(knob) == before


BAD_VALUES = {
    "no such configuration": ({"controll_config": {}}, "no configuration 'controll_config'"),
    "no such field": ({"control_config": {"bet": 1}}, "control_config has no field 'bet'"),
    "no number": ({"control_config": {"beta": True}}, "beta takes a number"),
    "no switch": ({"control_config": {"autonomous": 1}}, "autonomous takes true or false"),
    "no choice": ({"control_config": {"law": "papers"}}, "law takes one of paper, compensated"),
    "no word": ({"control_config": {"law": 1}}, "law takes one of"),
    "no whole number": ({"board_config": {"light_pin": 2.5}}, "light_pin takes a whole number"),
    "below zero": ({"actuator_config": {"counts_per_rev": -4}}, "takes a whole number"),
    "too large": ({"actuator_config": {"counts_per_rev": 10**12}}, "takes a whole number"),
    "out of range": ({"control_config": {"beta": 2}}, r"beta is 2, allowed are 0 to 1"),
    # The first is taken back.
    "the second": (
        {"control_config": {"beta": 0.75}, "board_config": {"supply_v": 100}},
        "supply_v",
    ),
}


@pytest.mark.parametrize("case", BAD_VALUES)
def test_what_a_knob_does_not_take_is_told_and_changes_nothing(
    knob: torsio.Knob, case: str
) -> None:
    content, words = BAD_VALUES[case]
    before = torsio.dump_config(knob)
    with pytest.raises(torsio.InvalidArgument, match=words):
        torsio.load_config(knob, json.dumps(content))
    assert torsio.dump_config(knob) == before
    assert knob.health().saves == 0


def test_what_a_text_names_is_set_and_saved_and_the_rest_stays(knob: torsio.Knob) -> None:
    knob.update(beta=0.25)
    torsio.load_config(
        knob,
        json.dumps({"control_config": {"law": "compensated"}, "board_config": {"supply_v": 24}}),
    )
    assert (knob.control_config().law, knob.control_config().beta) == ("compensated", 0.25)
    assert knob.board_config().supply_v == 24.0
    assert knob.health().saves == 1


def test_dump_has_every_field_as_the_knob_gives_it(knob: torsio.Knob) -> None:
    found = json.loads(torsio.dump_config(knob))
    for name, config in {
        "actuator_config": knob.actuator_config(),
        "control_config": knob.control_config(),
        "board_config": knob.board_config(),
        "game_config": knob.game_config(),
        "shaft_config": knob.shaft_config(),
        "calibration_config": knob.calibration_config(),
    }.items():
        assert type(config)(**found.pop(name)) == config
    assert found == {}


def test_nothing_is_loaded_while_somebody_has_the_actuator(knob: torsio.Knob) -> None:
    knob.arm()
    with pytest.raises(torsio.Refused, match="somebody has the actuator"):
        torsio.load_config(knob, '{"control_config": {"beta": 0.75}}')
    assert knob.control_config().beta == 0.5


def test_recording_has_the_configuration_that_was_loaded(knob: torsio.Knob, tmp_path: Path) -> None:
    with knob.record_to(tmp_path / "knob.mcap"):
        torsio.load_config(knob, '{"control_config": {"beta": 0.75}}')
    noted = [
        event["config"]
        for event in torsio.load(tmp_path / "knob.mcap").events
        if event["kind"] == "configure"
    ]
    assert [each["beta"] for each in noted if each["type"] == "ControlConfig"] == [0.75]


def test_what_is_no_knob_and_no_text_is_refused(knob: torsio.Knob) -> None:
    with pytest.raises(TypeError, match="knob must be a knob"):
        torsio.dump_config(None)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="text must be a string"):
        torsio.load_config(knob, {})  # type: ignore[arg-type]
