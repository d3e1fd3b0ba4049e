"""`torsio doctor --drift`: a knob that is not any more what it was when it was calibrated."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

import torsio
from torsio import calibration
from torsio.apps import doctor
from torsio.apps.cli import app
from torsio.apps.doctor.drift import check_drift
from torsio.apps.doctor.findings import Finding


@pytest.fixture(autouse=True)
def data_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    return tmp_path / "torsio/calibration"


def emulated(seed: int = 1, **plant: float) -> torsio.Knob:
    """Give a knob whose device believes in the reference actuator, whatever it is."""
    options = torsio.EmulatorOptions(
        seed=seed,
        plant=torsio.PlantParams(**plant),  # type: ignore[arg-type]
        actuator=torsio.ActuatorConfig(),
    )
    return torsio.open("emulated", emulator=options)


def keep_calibration() -> None:
    with emulated() as knob:
        calibration.keep(calibration.calibrate(knob, drift=True))


def test_only_what_has_changed_is_found_to_have_drifted() -> None:
    keep_calibration()
    with emulated(seed=2) as knob:
        before = knob.actuator_config()
        same = check_drift(knob)
        assert knob.state == "disarmed"
        assert knob.actuator_config() == before
    assert same.ok, same.text
    assert same.text.startswith("nothing has drifted since 20")
    # A bearing that has gone from 6 to 9 mN m.
    with emulated(seed=3, knob_coulomb_nm=9e-3) as knob:
        worn = check_drift(knob)
    assert not worn.ok
    drifts = {drift["name"]: drift["now"] for drift in worn.values["drifts"]}
    assert drifts["knob_coulomb_nm"] == pytest.approx(9e-3, rel=0.03)
    assert "stiffness_nm_per_rad" not in drifts
    assert "knob_coulomb_nm: 0.006" in worn.text
    assert "JND" in worn.text
    assert worn.more.endswith("#drift")


def test_knob_that_was_never_calibrated_is_told_so_and_not_turned() -> None:
    with emulated() as knob:
        finding = check_drift(knob)
        assert knob.emulator.time_s < 1.0  # a calibration takes longer
    assert not finding.ok
    assert "no calibration" in finding.text
    assert "torsio calibrate" in finding.advice


def test_armed_knob_stays_armed() -> None:
    with emulated() as knob:
        knob.arm()
        finding = check_drift(knob)
        assert knob.state == "armed"
    assert not finding.ok
    assert "the knob is armed" in finding.text


def test_hand_on_the_knob_is_a_refusal_with_its_reason(data_folder: Path) -> None:
    keep_calibration()
    with emulated() as knob:
        knob.emulator.set_hand(torsio.PrescribedMotion(angle_rad=0.0))
        finding = check_drift(knob)
        assert knob.state == "disarmed"
    assert not finding.ok
    assert finding.values["reason"] in {"held", "still"}
    assert "take hand" in finding.advice
    (path,) = data_folder.iterdir()
    path.write_text("{")
    with emulated() as knob:
        assert f"{path} cannot be read" in check_drift(knob).text


def test_command_adds_the_finding_for_a_knob_that_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def one(selector: str) -> list[doctor.Report]:
        return [doctor.Report(selector, [Finding("firmware", True, "as in this library")])]

    monkeypatch.setattr(doctor, "diagnose", one)
    result = CliRunner().invoke(app, ["doctor", "--device", "emulated", "--drift", "--json"])
    assert result.exit_code == 1
    (report,) = json.loads(result.stdout)["reports"]
    assert [finding["check"] for finding in report["findings"]] == ["firmware", "drift"]
    unnamed = CliRunner().invoke(app, ["doctor", "--drift"])
    assert unnamed.exit_code == 2
    assert "name it with --device" in unnamed.output
