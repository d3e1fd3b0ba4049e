"""A shaft that is not one straight line is found and kept; tests/cpp has sensor, laws and work."""

from __future__ import annotations

from pathlib import Path

import pytest

import torsio
from torsio import PlantParams, ShaftConfig, ShaftHardening, calibration


def test_calibration_finds_the_knee_and_the_device_keeps_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    plant = PlantParams(shaft_hardening=ShaftHardening())
    options = torsio.EmulatorOptions(seed=5, control_rate_hz=10_000.0, plant=plant)
    with torsio.open("emulated", emulator=options) as knob:
        assert knob.shaft_config() == ShaftConfig()
        found = calibration.calibrate(knob)
        assert knob.shaft_config() == ShaftConfig()
        calibration.apply(knob, found)
        shaft = knob.shaft_config()
        assert shaft.knee_1_rad == pytest.approx(0.015, rel=0.02)
        assert shaft.knee_1_nm_per_rad == pytest.approx(2 * 2.873, rel=0.03)
        assert shaft.knee_2_rad == 0.0
        assert 0.0 < knob.calibration_config().sigma_knee_1_nm_per_rad < 0.1
        truth = plant.matching_shaft()
        assert truth == ShaftConfig(knee_1_rad=0.015, knee_1_nm_per_rad=2 * 2.873)
