"""A knob from its file, and first power on it before there are parts."""

from __future__ import annotations

import json
import re
import sys
import time
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import torsio
from torsio import _torsio, protocol
from torsio.closed_loop import ClosedLoop, LoopOptions
from torsio.perception import VIBRATION_NM, vibration_nm
from torsio_hardware import faults, rehearsal
from torsio_hardware.first_power import STEPS, Seen, alone, run
from torsio_hardware.knob import DEFAULT, Knob, Value, load
from torsio_hardware.rehearsal import app, served

TREE = Path(__file__).parents[2]
# Those that a step before the calibration finds: a few seconds for all.
EARLY = [fault.name for fault in faults.FAULTS if not fault.finding.startswith("calibrate")]


@pytest.fixture(scope="module")
def knob() -> Knob:
    return load()


def rehearse(knob: Knob, name: str, seed: int | None = None) -> Seen:
    with rehearsal.emulated(knob, faults.named(name), seed) as bench:
        return run(bench, lambda seen: None)


def test_twenty_faults_have_names_of_their_own_and_a_finding_that_may_be_each(knob: Knob) -> None:
    assert len({fault.name for fault in faults.FAULTS}) == 20
    for fault in faults.FAULTS:
        causes = Seen("step", "command", "text", fault.finding).causes
        assert fault in causes
        assert len(causes) <= 3  # few enough to look at one after the other


def test_steps_are_those_of_the_guide_and_each_has_a_figure(knob: Knob) -> None:
    """The studio's test holds the page's titles against the same guide."""
    guides = TREE / "docs/how-to"
    guide = (guides / "first-power.md").read_text(encoding="utf-8")
    titles = re.findall(r"^\d+\. \*\*(.+?)\*\*", guide, re.M)
    assert list(dict.fromkeys(title for title, *_ in STEPS)) == titles
    assert {title for title, *_ in knob.expected()} == set(titles)
    guide += (guides / "wire.md").read_text(encoding="utf-8")
    for command in "; ".join(command for _, command, _ in STEPS).split("; "):
        plain = command.removesuffix(" {how}").replace("settings", "out/hardware/settings")
        named = plain.startswith("torsio") and plain != "torsio studio"  # the page has a link
        assert not named or f"`{plain}" in guide, plain


@pytest.mark.parametrize("fault", faults.FAULTS, ids=lambda fault: str(fault.name))
def test_doctor_or_calibrate_names_the_fault_and_the_page_says_which(
    knob: Knob, fault: faults.Fault
) -> None:
    with rehearsal.emulated(knob, fault) as bench:
        # Only the whole calibration looks at the winding.
        bench.quick = fault.name != "motor_contact"
        found = alone(bench)
        assert found == ("" if fault.alone == faults.NOBODY else fault.alone)
    page = (TREE / "docs/reference/reference-knob.md").read_text(encoding="utf-8")
    assert f"| {fault.name} | {fault.words} | {fault.finding} | {fault.alone} |\n" in page


@pytest.mark.parametrize("name", EARLY)
def test_fault_of_wiring_is_named_before_anything_is_calibrated(knob: Knob, name: str) -> None:
    seen = rehearse(knob, name)
    assert seen.finding == faults.named(name).finding
    assert faults.named(name) in seen.causes


def test_settings_are_those_that_a_device_takes_with_the_default_pins(knob: Knob) -> None:
    with torsio.open("emulated") as device:
        torsio.load_config(device, json.dumps(knob.settings()))
        assert device.board_config().supply_sense_pin == 27
        assert device.actuator_config().spring_stiffness_nm_per_rad == pytest.approx(2.873)
    off = {name for name, pin in knob.pins.items() if pin != getattr(torsio.BoardConfig(), name)}
    assert off == {"supply_sense_pin"}  # so the drawings of the guide hold


def test_knob_with_another_encoder_is_expected_to_count_its_lines(knob: Knob) -> None:
    other = replace(knob, values={**knob.values, "counts_per_rev": Value(4000.0)})
    bands = {step: band for step, _, band in other.expected()}
    assert bands["Encoder"] == pytest.approx((3992.0, 4008.0))
    assert rehearse(other, "motor_swapped").step == "Motor"  # past the encoder's


def test_soft_spring_is_kept_within_a_prints_band_and_wrong_below_it(knob: Knob) -> None:
    fault = faults.named("spring_soft")
    # A bent wall is as stiff as the cube of its thickness, and walls are 0.9 mm.
    (thinner_mm,) = map(float, re.findall(r"([\d.]+) mm", fault.words))
    assert (1 - thinner_mm / 0.9) ** 3 == pytest.approx(fault.softer, abs=0.01)
    drawn_nm_per_rad = knob.plant(6).shaft_stiffness_nm_per_rad

    def told(*words: str) -> str:
        return CliRunner().invoke(app, ["--quick", *words]).output

    kept = told("--fault", "spring_soft")
    assert "\noff    Calibrate " in kept
    assert "look for a loose belt, a hub that slips" in kept
    assert "keep what is proposed" in kept
    assert "\nok     A soft wall " in kept
    below = told("--blind", "6", "--reveal")
    assert "\nWRONG  Calibrate " in below
    assert "-47 % from the file's" in below
    assert fault.words in below
    assert f"this print's spring has {drawn_nm_per_rad:.3f} N m/rad" in below


def test_plants_that_are_drawn_lie_within_what_the_file_says(knob: Knob) -> None:
    drawn = [knob.plant(seed).shaft_stiffness_nm_per_rad for seed in range(20)]
    low, high = knob.values["spring_stiffness_nm_per_rad"].band()
    assert low <= min(drawn) < 2.6 < 3.1 < max(drawn) <= high
    assert knob.plant(3) == knob.plant(3)


@pytest.mark.parametrize("end", [0, 1])
def test_walls_are_still_with_a_spring_at_either_end_of_its_band_before_it_is_calibrated(
    knob: Knob, end: int
) -> None:
    """By the law `calibrated`; the others hum in stiff walls whatever the spring."""
    stiffness = knob.values["spring_stiffness_nm_per_rad"].band()[end]
    assert stiffness / 2.873 == pytest.approx([0.6, 1.4][end], abs=0.02)
    soft = torsio.ImpedanceHand(
        stiffness_nm_per_rad=0.7, damping_nm_s_per_rad=5e-3, inertia_kg_m2=1e-5,
        intended_angle_rad=[(0.0, 0.0), (0.1, 0.1)],
    )  # fmt: skip
    weights = [torsio.TorqueHand(torque_nm=[(0, 0), (ramp, 40e-3)]) for ramp in (0.02, 0.3)]
    thrown = torsio.TorqueHand(torque_nm=[(0, 60e-3), (0.06, 60e-3), (0.06, 0), (1, 0)])
    common: Any = {
        "plant": replace(knob.plant(), electrics=None, shaft_stiffness_nm_per_rad=stiffness),
        "actuator": knob.configs()["actuator"],
        "control": torsio.ControlConfig(law="calibrated"),
        "control_period_ns": 50_000,
    }
    stiff = (0.2, 1.0, 2.0, 3.0, 10.0, 50.0, 100.0)
    walls = (torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=each) for each in stiff)
    visits = product(walls, (soft, thrown, *weights))
    for wall, hand in visits:
        loop = ClosedLoop(LoopOptions(scene=wall, hand=hand, **common))
        loop.run(duration_s=1.8, record_every=20_000)
        rows = loop.run(duration_s=0.2, record_every=8)
        assert np.ptp(rows["angle_rad"]) < 1e-3
        assert vibration_nm(rows["motor_torque_nm"], 2500) < VIBRATION_NM


def test_figures_are_those_of_the_closed_forms(knob: Knob) -> None:
    figures = knob.figures()
    # beta 0.5, 85 and 110 mN m; 2 pi 2.873 / 8192, as the paper has it.
    assert figures["critical_torque_nm"] == pytest.approx(0.17)
    assert figures["least_torque_sensed_nm"] == pytest.approx(2.2e-3, rel=0.01)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("motor_pin = 6", "motor_pin = 2", "motor_pin is 2: this pin has another job"),
        ("supply_v = {", "supply_w = {", "supply_v is missing"),
        ("thickness_m", "thicknes_m", "unexpected keyword argument 'thicknes_m'"),
        ('material = "petg"', 'material = "wood"', "no material"),
        ("uncertainty = 0.3 ", "sigma = 0.3 ", "uncertainty is missing"),
        ("value = 12.0", 'value = "12"', "is no number"),
        ("[pins]", "[pegs]", "unknown table"),
        ("[pins]", "[pins", "is no TOML"),
    ],
)
def test_file_with_a_mistake_is_refused_in_words(
    tmp_path: Path, old: str, new: str, words: str
) -> None:
    text = DEFAULT.read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "knob.toml").write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ValueError, match=words):
        load(tmp_path / "knob.toml")


def test_bad_file_is_told_with_its_name(tmp_path: Path) -> None:
    file = tmp_path / "knob.toml"
    deep, long = b"a = " + b"[" * 200_000, b"a = " + b"1" * 200_000
    for content in (DEFAULT.read_bytes() + b"\xe4", bytes(5000), deep, long, b"", b"spring = 1"):
        file.write_bytes(content)
        with pytest.raises(ValueError, match=r"knob\.toml") as told:
            load(file)
        assert len(str(told.value)) < 500


def test_command_names_a_fault_and_tells_which_was_built_in() -> None:
    result = CliRunner().invoke(app, ["--fault", "motor_swapped", "--reveal"])
    assert result.exit_code == 1
    assert "found    motor:backwards" in result.output
    assert result.output.count("the motor's two wires are swapped") == 2
    listed = CliRunner().invoke(app, ["--fault", "list"])
    assert listed.exit_code == 0
    assert len(listed.output.splitlines()) == 20
    unknown = CliRunner().invoke(app, ["--fault", "gremlins"])
    assert unknown.exit_code == 1
    assert "no fault 'gremlins'" in unknown.output
    assert "error: gone.toml: No such file" in CliRunner().invoke(app, ["gone.toml"]).output
    assert json.loads(json.dumps(load().expected()))


@pytest.mark.parametrize("missing", ["torsio.studio.server", "the built page"])
def test_page_that_cannot_be_served_is_refused_with_all_that_it_needs(
    missing: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unbuilt() -> Path:
        raise torsio.Error("the studio's page is not built")

    monkeypatch.setattr(rehearsal, "page_folder", unbuilt)
    if missing != "the built page":
        monkeypatch.setitem(sys.modules, missing, None)
    result = CliRunner().invoke(app, ["--page"])
    assert result.exit_code == 1
    for needed in ("pip install", "./dev studio", f"missing now: {missing}"):
        assert needed in " ".join(result.output.split())


@pytest.mark.parametrize(
    ("name", "bits"),  # in the report `health`
    [("stop_open", 0x01), ("bridge_fault", 0x08), ("sensor_off", 0x40)],
)
def test_page_has_the_knob_with_what_happens_to_it(knob: Knob, name: str, bits: int) -> None:
    world = served(knob, faults.named(name), None)
    device = _torsio.Transport("emulated", world.options)
    world.happen(device)
    health = protocol.encode("health", {})[0]
    for _ in range(1000):  # until the board has looked
        time.sleep(5e-3)
        report = device.get_feature(health)
        if report and (found := protocol.decode(report)[1]["faults"]) & bits:
            break
    device.close()
    assert found & bits
