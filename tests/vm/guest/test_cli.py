"""The command line with knobs that the kernel has."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

import torsio
from tests.vm.guest.child import torsio_command
from tests.vm.guest.torque_log import turn
from tests.vm.guest.virtual_bus import VirtualBus, VirtualKnob, wait_for
from torsio.cli import app
from torsio.demos import wall

pytestmark = pytest.mark.kernel("6.12")


def answer(*arguments: str) -> Any:
    """Return what a command prints as JSON."""
    result = CliRunner().invoke(app, [*arguments, "--json"])
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


@pytest.mark.whole
def test_list_shows_what_is_plugged_in_and_the_emulated_knob(
    two_knobs: tuple[VirtualKnob, VirtualKnob],
) -> None:
    *plugged, emulated = answer("list")
    assert {device["path"]: device["serial"] for device in plugged} == {
        str(knob.hidraw): knob.serial for knob in two_knobs
    }
    for device in plugged:
        assert device["product"] == "haptic knob"
        assert (device["transport"], device["problem"]) == ("hid", "")
    assert emulated["path"] == "emulated"


@pytest.mark.whole
def test_info_tells_of_the_knob_that_is_named_by_its_serial_number(
    two_knobs: tuple[VirtualKnob, VirtualKnob],
) -> None:
    _, knob = two_knobs
    found = answer("info", "--device", knob.serial)
    assert found["info"]["serial"] == knob.serial
    assert found["info"]["path"] == str(knob.hidraw)
    assert found["info"]["transport"] == "hid"
    assert found["info"]["fingerprint"] == torsio.protocol.fingerprint()
    assert found["health"]["state"] == "disarmed"


def test_demo_measures_a_visit_to_the_wall_and_writes_what_it_found(
    bus: VirtualBus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Drawing takes an emulated processor half a minute, and has nothing to do with the knob.
    figure = SimpleNamespace(save_figure=lambda visit, measures, file: file.write_bytes(b"figure"))
    monkeypatch.setitem(sys.modules, "torsio.demos.wall_figure", figure)
    knob = bus.plug("DEMO", options=["--status"])
    knob.say("still")
    out = tmp_path / "out"
    demo = torsio_command("demo", "wall", "--device", "DEMO", "--out", str(out), typed="\n")
    status = knob.process.stdout
    assert status is not None
    wait_for("the demo to arm the knob", lambda: " armed " in status.readline())
    deepest_rad = wall.WALL_ANGLE_RAD + wall.PEAK_TORQUE_NM / wall.WALL_STIFFNESS_NM_PER_RAD
    turn(knob, tmp_path, [(0, 0), (0.3, 0), (1.3, deepest_rad), (1.5, deepest_rad), (2.5, 0)])
    text = demo.end()
    assert "It feels like a wall" in text
    assert f"knob     {knob.hidraw}, serial number DEMO" in text
    found = json.loads((out / "virtual_wall.json").read_text())
    assert found["device"] == "DEMO"
    assert found["peak_torque_nm"] == pytest.approx(wall.PEAK_TORQUE_NM, rel=0.02)
    assert found["left_wall"]
    assert (found["samples"], found["samples_lost"]) == (6000, 0)
    assert found["sensor_rms_nm"] is None  # only the emulator could tell
    assert (out / "virtual_wall.png").read_bytes() == b"figure"
    with torsio.open("DEMO") as opened:
        assert opened.state == "disarmed"
