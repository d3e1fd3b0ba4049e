"""The printed parts: whole, free of each other, and flat on the printer's bed."""

from __future__ import annotations

import csv
import itertools
import json
import math
import re
from pathlib import Path
from typing import Any

import pytest
from build123d import CenterOf, Cylinder, GeomType, Pos, Rot
from typer.testing import CliRunner

from torsio_hardware import making, parts, solids
from torsio_hardware.cli import app
from torsio_hardware.knob import load
from torsio_hardware.layout import BELT_LENGTH_MM, CENTRES_MM, PULLEY_MM

KNOB = load()
# Two named motors and two brakes: 310009 and 148877, B1 and B2.
DIAMETERS = {"first": (30.0, 47.0), "alternative": (40.0, 53.0)}
# A slicer bridges so much, such as below a screw's ear.
BRIDGED_MM2 = 100.0


@pytest.fixture(scope="module", params=list(DIAMETERS))
def placed(request: pytest.FixtureRequest) -> list[solids.Placed]:
    return solids.assembly(KNOB.spring.flexure, *DIAMETERS[request.param])


def common_mm3(one: Any, other: Any) -> float:
    both = one.intersect(other)
    if both is None:
        return 0.0
    return float(sum(part.volume for part in (both if isinstance(both, list) else [both])))


def test_no_part_is_within_another(placed: list[solids.Placed]) -> None:
    for one, other in itertools.combinations(placed, 2):
        assert common_mm3(one.solid, other.solid) < 0.01, (one.name, other.name)


def test_screws_are_long_enough_and_can_be_reached(placed: list[solids.Placed]) -> None:
    by_name = {part.name: part.solid for part in placed}
    # Plate and a clamp's ear, 6 mm each, and a nut of 2.4: longer than 14.4, and in stock.
    ear = by_name["motor clamp"].bounding_box().max.Z - by_name["plate"].bounding_box().min.Z
    assert ear == pytest.approx(0.0, abs=1e-6)
    sets = [part.matters for part in parts.load() if part.place == "screws"]
    # Eight ears and both clamps, with nuts; four legs, and the end stop.
    assert all("15 M3x16; 10 nuts M3" in told for told in sets)
    # The brake's screws slide, so that the belt can be tightened.
    ear = by_name["brake clamp"].bounding_box().max.Y - 6.0
    for slid in (-3.0, 0.0, 3.0):
        screw = Pos(CENTRES_MM + ear + slid, ear, 0) * Cylinder(1.5, 40)
        assert common_mm3(screw, by_name["plate"]) < 0.01
    # A key of 2 mm goes from outside to the set screw of the knob's hub.
    hole = by_name["sleeve"].bounding_box().max.Z - 3.0
    key = Pos(-25, 0, hole) * Rot(0, 90, 0) * Cylinder(1.0, 30)
    assert common_mm3(key, by_name["knob"]) < 0.01


def test_part_in_the_wrong_place_and_one_printed_upside_down_are_found(
    placed: list[solids.Placed],
) -> None:
    by_name = {part.name: part.solid for part in placed}
    assert common_mm3(Pos(0, 0, -4.0) * by_name["knob"], by_name["sleeve"]) > 10
    assert solids.overhang_mm2(Pos(0, 0, 20) * by_name["knob"]) > 1000


def test_every_printed_part_is_one_piece_that_lies_flat(placed: list[solids.Placed]) -> None:
    for part in placed:
        if part.is_printed:
            assert len(part.solid.solids()) == 1, part.name
            on_bed = solids.printed(part)
            assert pytest.approx(0.0, abs=1e-6) == on_bed.bounding_box().min.Z
            assert solids.overhang_mm2(on_bed) < BRIDGED_MM2, part.name
            bed = [face for face in on_bed.faces() if abs(face.center().Z) < 1e-3]
            assert sum(face.area for face in bed) > 30, part.name


def test_belt_has_its_length_and_grooves_for_its_teeth(placed: list[solids.Placed]) -> None:
    assert math.tau * PULLEY_MM + 2 * CENTRES_MM == pytest.approx(BELT_LENGTH_MM)
    # The set screw's hole cuts four lands of the brake's pulley in two.
    for name, pieces in (("drum", 50), ("brake pulley", 54)):
        faces = next(part.solid.faces() for part in placed if part.name == name)
        # A pulley of 50 grooves of 2 mm has 31.32 mm outside, by makers' tables.
        radii = [face.radius for face in faces if face.geom_type == GeomType.CYLINDER]
        assert sum(radius == pytest.approx(15.66, abs=0.01) for radius in radii) == pieces


def test_knob_turns_round_and_round_until_the_end_stop_is_on(placed: list[solids.Placed]) -> None:
    """A calibration turns it some dozen times."""
    by_name = {part.name: part.solid for part in placed}
    hit = set()
    for degrees in range(0, 360, 10):
        turned = Rot(0, 0, degrees) * by_name["knob"]
        for name in ("plate", "brake pulley", "end stop"):
            if common_mm3(turned, by_name[name]) > 0.01:
                hit.add(name)
    assert hit == {"end stop"}


def test_knob_and_drum_have_the_inertia_that_the_file_says(placed: list[solids.Placed]) -> None:
    """PETG has 1.27 g in a cubic centimetre."""

    def inertia_kg_m2(name: str, at_mm: float = 0.0) -> float:
        body = Pos(-at_mm, 0, 0) * next(part.solid for part in placed if part.name == name)
        middle = body.center(CenterOf.MASS)  # the matrix is about it
        about_axis = body.matrix_of_inertia[2][2] + body.volume * (middle.X**2 + middle.Y**2)
        return 1.27e-12 * float(about_axis)

    motor = parts.chosen(parts.load(), KNOB)["motor"].ratings
    knob = inertia_kg_m2("knob") + inertia_kg_m2("sleeve") + motor["inertia_kg_m2"]
    low, high = KNOB.values["knob_inertia_kg_m2"].band()
    assert low < knob < high
    # The bearings' outer rings and the belt have about 1e-6; a rotor of 7e-6 is assumed.
    turning = inertia_kg_m2("spring") + inertia_kg_m2("drum")
    turning += inertia_kg_m2("brake pulley", CENTRES_MM) + 8e-6
    low, high = KNOB.values["brake_inertia_kg_m2"].band()
    assert low < turning < high


def test_spring_has_the_volume_of_its_arms() -> None:
    shape = KNOB.spring.flexure
    line = 1e3 * shape.centre_line(2000)
    arm = sum(math.dist(a, b) for a, b in itertools.pairwise(line)) * 1e3 * shape.thickness_m
    rings = math.pi * (29**2 - 25**2 + 7**2 - 5**2 - 6 * 1.1**2)
    expected = (rings + shape.arms * arm) * 1e3 * shape.width_m
    assert solids.spring(shape).volume == pytest.approx(expected, rel=0.01)


def test_command_writes_the_spring_that_it_designs(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["spring", "--family", "spoke", "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert {file.suffix for file in tmp_path.iterdir()} == {".svg", ".step", ".stl", ".json"}
    figures = json.loads((tmp_path / "spring.json").read_text(encoding="utf-8"))
    assert figures["family"] == "spoke"
    assert figures["shaft_config"]["knee_1_rad"] > 0


def test_all_files_are_made(tmp_path: Path) -> None:
    files = making.make(KNOB, tmp_path, lambda what: None)
    assert all(file.stat().st_size > 200 for file in files)
    figures = json.loads((tmp_path / "expected.json").read_text(encoding="utf-8"))["figures"]
    page = (Path(__file__).parents[2] / "docs/reference/reference-knob.md").read_text(
        encoding="utf-8"
    )
    page = " ".join(page.split())
    for name, words in (
        ("free_drag", "drag in free air is"),
        ("least_torque_sensed", "least torque sensed is"),
        ("torque_gap", "way out of a wall"),
    ):
        told = f"{words} {1e3 * figures[f'{name}_nm']:.1f} mN m"
        assert re.search(rf"{told}.{{0,12}} \({figures[f'{name}_jnds']:.1f} JND\)", page), told
    assert f"up to {figures['stable_stiffness_nm_per_rad']:.0f} N m/rad are stable" in page
    called = (tmp_path / "exploded.svg").read_text(encoding="utf-8")
    for words in ("11 spring", "3 motor: maxon 310009", "13 belt: Gates 2MGT-300-6"):
        assert f">{words}</text>" in called
    names = {file.name for file in files}
    assert {"assembly.step", "spring.step", "spring.stl", "exploded.svg", "step_8.svg"} <= names
    with (tmp_path / "parts.csv").open(encoding="utf-8") as opened:
        *_, total = csv.reader(opened)
    assert total[0] == "total"
