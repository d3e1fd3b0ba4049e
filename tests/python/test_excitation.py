"""Bounded experiments: the device plays what it is told, and stops at the first surprise."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

import torsio
from torsio import Excitation
from torsio.printed.hands import PrescribedMotion

BOUNDS = {
    "duration_s": 0.5,
    "travel_rad": 50.0,
    "speed_limit_rad_s": 100.0,
    "torque_limit_nm": 0.05,
}


@pytest.fixture
def knob() -> Iterator[torsio.Knob]:
    options = torsio.EmulatorOptions(
        hand=PrescribedMotion(angle_rad=0.0),
        actuator=torsio.ActuatorConfig(brake_time_constant_s=0.0),
    )
    with torsio.open("emulated", emulator=options) as knob:
        knob.start_telemetry(1000.0)
        knob.arm()
        yield knob


def test_sine_goes_from_one_frequency_to_the_other(knob: torsio.Knob) -> None:
    knob.excite(Excitation(**BOUNDS, sine_nm=0.03, sine_begin_hz=10.0, sine_end_hz=50.0))
    knob.sleep(0.4)
    log = knob.read(max_samples=1000)
    start = int(np.argmax(np.abs(log["motor_command_nm"]) > 1e-4)) - 1
    time_s = np.arange(300) * 1e-3
    # The phase of a frequency that grows by 80 Hz a second, in steps of a tick.
    turns = 10.0 * time_s + 40.0 * time_s * (time_s - 1e-3)
    expected = 0.03 * np.sin(2 * math.pi * turns)
    assert log["motor_command_nm"][start : start + 300] == pytest.approx(expected, abs=5e-5)


def test_value_out_of_range_is_named_and_changes_nothing(knob: torsio.Knob) -> None:
    knob.excite(Excitation(**BOUNDS, motor_command_nm=0.01))
    with pytest.raises(torsio.InvalidArgument, match=r"excitation: .*ramp_s"):
        knob.excite(Excitation(**BOUNDS, ramp_s=61.0))
    with pytest.raises(TypeError, match="Excitation"):
        knob.excite(torsio.Constant(torque_nm=0.01))  # type: ignore[arg-type]
    assert knob.record(0.02)["motor_command_nm"][-1] == pytest.approx(0.01, abs=2e-5)


@pytest.mark.parametrize("electrics", [None, torsio.Electrics()], ids=["simple motor", "electrics"])
@pytest.mark.parametrize("stiffness_nm_per_rad", [0.0, 0.3])
@pytest.mark.parametrize("alive_s", [0.0, 0.4])
def test_servo_whose_encoder_dies_does_not_make_the_knob_ever_faster(
    alive_s: float, stiffness_nm_per_rad: float, electrics: torsio.Electrics | None
) -> None:
    plant = torsio.PlantParams(electrics=electrics)
    options = torsio.EmulatorOptions(plant=plant, control_rate_hz=10_000, log_truth=True)
    with torsio.open("emulated", emulator=options) as knob:
        knob.arm()
        knob.excite(
            Excitation(
                duration_s=3.0,
                travel_rad=600.0,
                speed_limit_rad_s=160.0,
                torque_limit_nm=0.064,
                stiffness_nm_per_rad=stiffness_nm_per_rad,
                damping_nm_s_per_rad=6e-3,
                servo_rad_s=30.0,
            )
        )
        knob.sleep(alive_s)
        knob.emulator.freeze_encoder(frozen=True)
        knob.emulator.truth()
        knob.sleep(1.0)
        truth = knob.emulator.truth()
        assert knob.state != "armed"
        reached = np.abs(truth["speed_rad_s"])
        # 50 ms of 64 mN m on 1e-4 kg m2 give 32 rad/s. 12 more come before the servo asks for all.
        assert reached.max() < 30.0 + 32.0 + 12.0
        assert truth["time_s"][reached.argmax()] - truth["time_s"][0] < 0.1
