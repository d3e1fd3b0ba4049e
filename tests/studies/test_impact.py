"""The study of impacts: the knock is at the knob, as the closed form has it."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from torsio import ActuatorConfig
from torsio_studies.execution import execute
from torsio_studies.impact import study, trials


def test_cue_at_the_knob_has_the_frequency_the_decay_and_the_size_that_were_asked_for() -> None:
    for frequency_hz, decay_s in ((300.0, 5e-3), (300.0, 10e-3), (500.0, 3e-3)):
        tap = trials.tap(1.0, trials.with_cue(frequency_hz=frequency_hz, decay_s=decay_s))
        found = trials.fit_sine(tap)
        assert found.frequency_hz == pytest.approx(frequency_hz, rel=0.03)
        assert found.decay_s == pytest.approx(decay_s, rel=0.2)
        # Torque over inertia: a free mass.
        expected = 0.02 * tap.speed_rad_s / (6e-5 + 1e-4)
        assert found.amplitude_rad_s2 == pytest.approx(expected, rel=0.1)


def test_spectrum_at_the_knob_peaks_at_the_set_frequency_and_without_it_does_not() -> None:
    tap = trials.tap(1.0)
    assert trials.peak_hz(tap.acceleration_rad_s2) == pytest.approx(300.0, rel=0.1)
    frequency_hz, plain = trials.spectrum(tap.plain_rad_s2)
    _, with_it = trials.spectrum(tap.acceleration_rad_s2)
    there = int(np.argmin(np.abs(frequency_hz - 300.0)))
    assert with_it[there] > 4.0 * plain[there]


def test_impact_gives_little_of_the_energy_that_knob_and_finger_brought() -> None:
    taps = [(speed, trials.CUE) for speed in study.SPEEDS_RAD_S]
    taps += [(1.0, trials.with_cue(frequency_hz=f, decay_s=3e-3)) for f in study.FREQUENCIES_HZ]
    for speed_rad_s, cue in taps:
        tap = trials.tap(speed_rad_s, cue)
        assert tap.given_j < 0.15 * tap.energy_j
        # (12) of docs/explanation/theory.md
        assert tap.given_j < ActuatorConfig().motor_torque_max_nm * math.tau / trials.COUNTS


def test_cue_grows_with_the_speed_of_the_contact() -> None:
    slow, fast = trials.tap(1.0), trials.tap(2.0)
    ratio = trials.fit_sine(fast).amplitude_rad_s2 / trials.fit_sine(slow).amplitude_rad_s2
    assert ratio == pytest.approx(fast.speed_rad_s / slow.speed_rad_s, rel=0.1)


def test_fit_finds_a_sine_that_is_there() -> None:
    tap = trials.tap(1.0)
    clean = trials.Tap(
        tap.impact,
        1.0,
        tap.time_s,
        70.0 * np.exp(-tap.time_s / 4.5e-3) * np.cos(2 * math.pi * 290.0 * tap.time_s),
        np.zeros_like(tap.time_s),
        1.0,
        1.0,
        0.0,
    )
    found = trials.fit_sine(clean)
    assert found.frequency_hz == pytest.approx(290.0, rel=1e-3)
    assert found.decay_s == pytest.approx(4.5e-3, rel=5e-3)
    assert found.amplitude_rad_s2 == pytest.approx(70.0, rel=5e-3)


def test_study_writes_the_documented_keys_and_a_picture(tmp_path: Path) -> None:
    execute("impact", json_file=tmp_path / "i.json", out=tmp_path, quick=True)
    results = json.loads((tmp_path / "i.json").read_text())
    page = (Path(__file__).parents[2] / "docs" / "results" / "impact.md").read_text()
    assert [
        key for key in results["rows"][0] if f"`{key}`" not in page.replace("rows[].", "")
    ] == []
    assert results["figures"] == ["impact_knock.png"]
    assert 20_000 < (tmp_path / "impact_knock.png").stat().st_size < 200_000
