"""The electrical estimators against closed forms of a winding."""

from __future__ import annotations

import numpy as np
import pytest

from torsio.calibration import Refusal
from torsio.calibration.electric import current_zero, torque_constant, winding
from torsio.calibration.quantity import Quantity

OHM, HENRY = 2.31, 1.7e-3


def steps(random: np.random.Generator, noise_a: float = 5e-3):  # type: ignore[no-untyped-def]
    """Give time, voltage and current of a winding: exponentials to V / R, by the closed form."""
    time_s = np.arange(4000) * 1e-5
    voltage_v = np.where((time_s // 0.005) % 2 == 0, 3.0, -1.5)
    current_a = np.zeros(len(time_s))
    decay = np.exp(-1e-5 * OHM / HENRY)
    for n in range(1, len(time_s)):
        target = voltage_v[n - 1] / OHM
        current_a[n] = target + (current_a[n - 1] - target) * decay
    return time_s, voltage_v, current_a + random.normal(0.0, noise_a, len(time_s))


def test_zero_and_noise_are_those_of_the_samples() -> None:
    samples = np.random.default_rng(1).normal(0.031, 0.004, 5000)
    zero, noise = current_zero(samples)
    assert abs(zero.value - 0.031) < 4 * 0.004 / 5000**0.5
    assert noise.value == pytest.approx(0.004, rel=0.05)


def test_dead_sensor_is_refused() -> None:
    with pytest.raises(Refusal, match="the very same number") as caught:
        current_zero(np.full(100, 0.5))
    assert caught.value.reason == "dead_sensor"


def covers(quantity: Quantity, truth: float) -> bool:
    low, high = quantity.interval
    return low <= truth <= high


def test_winding_is_found_within_what_is_said() -> None:
    hits = np.zeros(2)
    for seed in range(100):
        found = winding(*steps(np.random.default_rng(seed)), believed_ohm=2.5)
        assert found[0].value == pytest.approx(OHM, rel=0.02)
        assert found[1].value == pytest.approx(HENRY, rel=0.05)
        assert found[2].value == pytest.approx(2.5 / found[0].value)
        hits += [covers(found[0], OHM), covers(found[1], HENRY)]
    assert (hits >= 85).all(), hits


@pytest.mark.parametrize(
    ("factor", "reason"), [(-1.0, "reversed_sensor"), (0.01, "no_current"), (3.0, "gain")]
)
def test_winding_is_refused_with_its_fault(factor: float, reason: str) -> None:
    time_s, voltage_v, current_a = steps(np.random.default_rng(0), 1e-4)
    with pytest.raises(Refusal) as caught:
        winding(time_s, voltage_v, factor * current_a, believed_ohm=2.5)
    assert caught.value.reason == reason


def test_torque_constant_is_the_slope_of_the_back_emf() -> None:
    random = np.random.default_rng(3)
    hits = 0
    for _ in range(100):
        speed = np.repeat([-80.0, -30.0, 30.0, 80.0], 50)
        current = 0.2 * np.sign(speed) + random.normal(0.0, 5e-3, len(speed))
        voltage = OHM * current + 0.047 * speed + 0.02 + random.normal(0.0, 0.05, len(speed))
        hits += covers(torque_constant(speed, voltage, current, resistance_ohm=OHM), 0.047)
    assert hits >= 88


def test_torque_constant_refuses_a_knob_that_turned_one_way() -> None:
    with pytest.raises(Refusal, match="one way only"):
        torque_constant(np.ones(5), np.ones(5), np.zeros(5), resistance_ohm=1.0)
