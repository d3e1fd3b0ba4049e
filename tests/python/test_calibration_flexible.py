"""A heavy brake on a soft shaft: what passes fast is bent by it, and comes out as it is."""

from __future__ import annotations

from dataclasses import replace

import pytest

import torsio
from torsio import calibration

PERIODS, COGGING_NM = 24, 1.5e-3
_DEFAULT = torsio.PlantParams()
PLANT = replace(
    _DEFAULT,
    brake_inertia_kg_m2=2.0 * _DEFAULT.brake_inertia_kg_m2,
    shaft_stiffness_nm_per_rad=0.6 * _DEFAULT.shaft_stiffness_nm_per_rad,
    brake_time_constant_s=30e-3,
    cogging=torsio.Cogging.sine(periods_per_rev=PERIODS, amplitude_nm=COGGING_NM, points=64),
)


@pytest.fixture(scope="module")
def found() -> calibration.Calibration:
    """Calibrate it once."""
    options = torsio.EmulatorOptions(seed=4, control_rate_hz=10_000.0, plant=PLANT)
    with torsio.open("emulated", emulator=options) as knob:
        return calibration.calibrate(knob)


def test_cogging_near_the_shaft_s_own_frequency_is_all_there(
    found: calibration.Calibration,
) -> None:
    assert found.cogging is not None
    assert found.cogging.periods_per_rev[0] == PERIODS
    cogging = found.quantities["cogging_nm"]
    assert abs(cogging.value - COGGING_NM) < 3.0 * cogging.standard_uncertainty
    assert cogging.standard_uncertainty < 12e-3 * COGGING_NM
    assert found.cogging.sigmas_nm[0] == pytest.approx(cogging.standard_uncertainty)


def test_brake_that_the_shaft_answers_is_not_taken_for_a_stronger_one(
    found: calibration.Calibration,
) -> None:
    assert found.quantities["brake_gain"].value == pytest.approx(1.0, abs=1e-3)
    for name in ("rise_s", "release_s"):
        of = found.quantities[name]
        assert abs(of.value - 30e-3) < 3.0 * of.standard_uncertainty < 5e-3, name
