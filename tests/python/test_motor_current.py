"""The reported current and voltage of the motor, against the plant's truth."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import torsio
from torsio.closed_loop import LoopOptions, simulate

OHM, CONSTANT_NM_PER_A, SUPPLY_V = 3.1, 0.05, 12.0
STEP_NM = CONSTANT_NM_PER_A * 3.3 / 4096 / 0.2  # of the current sensor's converter
# Stiff against the motor, so that nothing turns.
HAND = torsio.ImpedanceHand(
    intended_angle_rad=[(0.0, 0.0)], stiffness_nm_per_rad=500.0, damping_nm_s_per_rad=0.5
)


def opened(electrics: torsio.Electrics | None, rate_hz: float = 1000.0) -> torsio.Knob:
    plant = torsio.PlantParams(electrics=electrics)
    return torsio.open(
        "emulated",
        emulator=torsio.EmulatorOptions(
            plant=plant, hand=HAND, log_truth=True, control_rate_hz=rate_hz
        ),
    )


def test_knob_without_electrics_measures_nothing() -> None:
    with opened(None) as knob:
        knob.sleep(0.1)
        told = dataclasses.asdict(knob.motor_current())
    assert told.pop("measured") is False
    told.pop("angle_rad")
    assert not any(told.values())


@pytest.mark.parametrize("rate_hz", [1000.0, 20_000.0])
def test_sums_tell_the_charge_and_the_voltage_of_a_held_knob(rate_hz: float) -> None:
    electrics = torsio.Electrics(winding_resistance_ohm=OHM, supply_resistance_ohm=0.0)
    with opened(electrics, rate_hz) as knob:
        knob.sleep(0.2)  # the board learns its sensor's zero
        knob.play(torsio.Constant(torque_nm=0.03))
        knob.arm()
        knob.sleep(0.3)
        before, begin_s = knob.motor_current(), knob.emulator.time_s
        knob.emulator.truth()
        knob.sleep(0.2)
        after, end_s = knob.motor_current(), knob.emulator.time_s
        truth = knob.emulator.truth()
    periods = after.periods - before.periods
    assert periods * after.period_s == pytest.approx(end_s - begin_s, abs=2.0 / rate_hz)
    assert after.time_s - before.time_s == pytest.approx(end_s - begin_s, abs=2.0 / rate_hz)
    current_a = (after.current_sum_a - before.current_sum_a) / periods - after.zero_a
    true_a = float(np.mean(truth["motor_torque_nm"])) / CONSTANT_NM_PER_A
    assert current_a == pytest.approx(true_a, abs=1e-3)
    voltage_v = SUPPLY_V * (after.share_sum - before.share_sum) / periods
    assert voltage_v == pytest.approx(OHM * true_a, rel=0.01)
    assert after.step_a == pytest.approx(3.3 / 4096 / 0.2)
    assert abs(after.current_a - current_a) < 0.05
    assert after.torque_constant_nm_per_a == pytest.approx(CONSTANT_NM_PER_A)


def test_disarmed_board_goes_on_to_measure_and_drives_nothing() -> None:
    with opened(torsio.Electrics(sensor_zero_v=1.6)) as knob:
        knob.sleep(0.2)
        told = knob.motor_current()
    assert told.measured
    assert told.periods > 1000
    assert told.share_sum == told.share == 0.0
    # The converter cuts off parts of a step of 0.8 mV.
    assert told.zero_a * 0.2 == pytest.approx(1.6, abs=1e-3)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("torque_nm", [0.03, -0.03, 1e-4])
def test_no_reading_alone_is_the_sensors_zero(torque_nm: float, seed: int) -> None:
    plant = torsio.PlantParams(electrics=torsio.Electrics())
    control = torsio.ControlConfig(law="motor_only")
    scene = [torsio.Constant(torque_nm=torque_nm)]
    options = LoopOptions(plant=plant, hand=HAND, scene=scene, seed=seed, control=control)
    # As soon as one can arm.
    emulated = torsio.EmulatorOptions(
        plant=plant, hand=HAND, log_truth=True, seed=seed, control=control
    )
    with torsio.open("emulated", emulator=emulated) as knob:
        knob.play(scene)
        knob.arm()
        knob.sleep(0.3)
        for rows in (simulate(options, duration_s=0.3), knob.emulator.truth()):
            given_nm = rows["motor_torque_nm"][-len(rows) // 3 :].mean()
            assert given_nm == pytest.approx(torque_nm, abs=0.4 * STEP_NM)
