"""The numbers and the picture of the wall demonstration, from records made by hand."""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import torsio
from torsio.demos import wall, wall_figure
from torsio.printed.plant import PlantParams
from torsio.telemetry import TRUTH_DTYPE

STIFFNESS = 1.5
SURFACE_RAD = 0.05


def visit(*, missing_on_way_out_nm: float = 0.0, gain: float = 1.0) -> wall.WallVisit:
    """Give a triangular visit to 0.05 rad depth, 75 mN m, whose torque is rendered as told."""
    time_s: wall.Array = np.arange(2001, dtype=np.float64) * 1e-3
    angle = SURFACE_RAD + 0.05 - 0.1 * np.abs(time_s - 1.0)
    ideal = -STIFFNESS * np.maximum(angle - SURFACE_RAD, 0.0)
    felt = gain * ideal
    out = (time_s > 1.0) & (ideal < 0)
    felt[out] += np.minimum(missing_on_way_out_nm, -felt[out])
    spring, motor = 0.4 * felt, 0.6 * felt
    truth = np.zeros(len(time_s), dtype=TRUTH_DTYPE)
    truth["angle_rad"] = angle
    truth["spring_torque_nm"], truth["motor_torque_nm"] = spring, motor
    truth["brake_capacity_nm"] = np.abs(spring)
    return wall.WallVisit(
        device="TS-0001",
        law="paper",
        control_rate_hz=1000.0,
        wall_angle_rad=SURFACE_RAD,
        wall_stiffness_nm_per_rad=STIFFNESS,
        beta=0.5,
        time_s=time_s,
        angle_rad=angle,
        desired_torque_nm=ideal,
        motor_command_nm=motor,
        brake_capacity_nm=np.abs(spring),
        spring_torque_nm=spring + 1e-3,
        truth=truth,
        samples_lost=0,
        realtime_factor=1.0,
        counts_per_rev=8192,
    )


def test_measure_finds_the_torque_that_is_missing_on_the_way_out() -> None:
    measures = wall.measure(visit(missing_on_way_out_nm=6e-3))
    assert measures.tracking_rms_in == pytest.approx(0.0, abs=1e-3)
    # 6 of 75 mN m are missing nearly all the way.
    assert measures.tracking_rms_out == pytest.approx(0.08, rel=0.05)
    assert measures.torque_gap_nm == pytest.approx(6e-3)


def test_torque_that_is_a_fifth_too_small_is_so_on_the_way_in() -> None:
    # The root mean square of a ramp is its end over the root of three; the sensor adds 1 mN m.
    measures = wall.measure(visit(gain=0.8))
    assert measures.tracking_rms_in == pytest.approx(0.2 / 3**0.5, rel=0.03)


def test_measure_says_when_the_wall_was_never_reached() -> None:
    away = replace(visit(), desired_torque_nm=np.zeros(2001))
    with pytest.raises(wall.WallNotReachedError, match="never reached the wall"):
        wall.measure(away)


@pytest.mark.parametrize("on_hardware", [False, True])
def test_figure_is_drawn_with_and_without_the_truth(tmp_path: Path, on_hardware: bool) -> None:
    seen = visit(missing_on_way_out_nm=6e-3)
    if on_hardware:
        seen = replace(seen, truth=None)
    measures = wall.measure(seen)
    assert (measures.sensor_rms_nm is None) == on_hardware
    wall_figure.save_figure(seen, measures, tmp_path / "wall.png")
    assert (tmp_path / "wall.png").stat().st_size > 50_000


def test_run_leaves_the_knob_disarmed_and_configured_as_before() -> None:
    control = torsio.ControlConfig(law="motor_only", beta=0.1)
    with torsio.open(
        "emulated", emulator=torsio.EmulatorOptions(control=control, log_truth=True)
    ) as knob:
        shares: list[float] = []
        seen = wall.run(knob, shares.append)
        assert knob.state == "disarmed"
        assert knob.control_config().law == "motor_only"
        assert knob.control_config().beta == pytest.approx(0.1)
    assert seen.law == "paper"
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)


def test_run_that_ends_early_puts_the_law_back_or_says_that_it_cannot(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    options = torsio.EmulatorOptions(control=torsio.ControlConfig(law="motor_only"), log_truth=True)
    with torsio.open("emulated", emulator=options) as knob:

        def fail(_: float) -> None:
            knob.emulator.set_emergency_stop(pressed=True)
            knob.sleep(0.01)
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            wall.run(knob, fail)
        assert knob.faults() == ("emergency_stop",)
        assert knob.control_config().law == "motor_only"
        knob.emulator.set_emergency_stop(pressed=False)
        knob.clear_fault()

        def refuse(_: object) -> None:
            raise torsio.Timeout("late")

        monkeypatch.setattr(knob, "configure", refuse)
        with pytest.raises(torsio.Error, match=r"before the demonstration could not be restored"):
            wall.run(knob)
        assert knob.state == "disarmed"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, []),
        ({"tracking_rms_in": 0.0701}, ["way in"]),
        ({"tracking_rms_in": float("nan")}, ["way in"]),
        ({"tracking_rms_out": 0.0901}, ["way out"]),
        ({"left_wall": False}, ["still in the wall"]),
        ({"samples_lost": 1}, ["samples lost: 1"]),
        ({"left_wall": False, "samples_lost": 2}, ["still in the wall", "lost: 2"]),
    ],
)
def test_shortcomings_name_everything_that_is_not_as_it_should_be(
    changes: dict[str, Any], words: list[str]
) -> None:
    found = replace(wall.measure(visit()), **changes).shortcomings()
    assert len(found) == len(words)
    for sentence, word in zip(found, words, strict=True):
        assert word in sentence


def test_demo_is_bit_by_bit_what_it_was_before_the_field_lists() -> None:
    # Figures of commit 8e0834a5, with the default lag of a motor there.
    plant = PlantParams(motor_time_constant_s=0.1e-3)
    options = torsio.EmulatorOptions(plant=plant, log_truth=True)
    with torsio.open("emulated", emulator=options) as knob:
        visit = wall.run(knob)
    felt = {
        "angle_rad": visit.angle_rad,
        "desired_torque_nm": visit.desired_torque_nm,
        "spring_torque_nm": visit.spring_torque_nm,
        "motor_command_nm": visit.motor_command_nm,
    }
    found = {name: sha256(column.tobytes()).hexdigest()[:16] for name, column in felt.items()}
    assert found == {
        "angle_rad": "e5a314967360c8bb",
        "desired_torque_nm": "1f4b3a03b0ffa285",
        "spring_torque_nm": "41baf3dc8f7fc0be",
        "motor_command_nm": "65c4d1284ace8856",
    }
