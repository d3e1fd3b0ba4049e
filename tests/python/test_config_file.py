"""`torsio.load_config`: a text's content and its possible faults."""

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


def test_recording_has_the_configuration_that_was_loaded(knob: torsio.Knob, tmp_path: Path) -> None:
    with knob.record_to(tmp_path / "knob.mcap"):
        torsio.load_config(knob, '{"control_config": {"beta": 0.75}}')
    noted = [
        event["config"]
        for event in torsio.load(tmp_path / "knob.mcap").events
        if event["kind"] == "configure"
    ]
    assert [each["beta"] for each in noted if each["type"] == "ControlConfig"] == [0.75]


def test_what_is_no_text_is_refused(knob: torsio.Knob) -> None:
    with pytest.raises(TypeError, match="text must be a string"):
        torsio.load_config(knob, {})  # type: ignore[arg-type]
