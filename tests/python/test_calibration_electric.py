"""The electrical estimators against closed forms of a winding."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from torsio.calibration import Refusal
from torsio.calibration.electric import (
    Intervals,
    check_current,
    current_zero,
    intervals,
    motor,
    winding,
)
from torsio.calibration.quantity import Array, Quantity
from torsio.printed.told import MotorCurrent

OHM, HENRY, CONSTANT, SUPPLY_V = 2.31, 1.7e-3, 0.047, 12.0
BELIEVED = {"believed_ohm": 2.5, "believed_h": 1.5e-3}
PERIOD_S, ZERO_A, NOISE_A = 25e-6, 8.25, 5e-3


def readings(
    share: Array,
    speed_rad_s: float,
    random: np.random.Generator,
    *,
    delay_share: float = 1.0,
    gain: float = 1.0,
    noise_a: float = NOISE_A,
    henry: float = HENRY,
) -> list[MotorCurrent]:
    """Give what a board tells now and then of a winding that is solved in closed form.

    The share that answers a measurement acts from `delay_share` periods later on.
    """
    current, angle, seen_sum, share_sum = 0.0, 0.0, 0.0, 0.0
    last = 0.0
    told = []
    look = int(random.integers(20, 120))
    for n, now in enumerate(share.tolist()):
        seen = gain * current + float(random.normal(0.0, noise_a))
        seen_sum += seen + ZERO_A
        share_sum += now
        if n == look:
            look += int(random.integers(20, 120))
            told.append(
                MotorCurrent(
                    measured=True, time_s=(n + 1) * PERIOD_S, angle_rad=angle, period_s=PERIOD_S,
                    delay_s=delay_share * PERIOD_S, periods=n + 1, current_a=seen, zero_a=ZERO_A,
                    step_a=4e-3, current_sum_a=seen_sum, share=now, share_before=last,
                    share_sum=share_sum, torque_constant_nm_per_a=0.05,
                )
            )  # fmt: skip
        for acting, part in ((last, delay_share), (now, 1.0 - delay_share)):
            end = (SUPPLY_V * acting - CONSTANT * speed_rad_s) / OHM
            current = end + (current - end) * math.exp(-part * PERIOD_S * OHM / henry)
        last = now
        angle += speed_rad_s * PERIOD_S
    return told


def pushed(random: np.random.Generator, **changes: float) -> Intervals:
    """Give intervals of a held knob, driven by waves of voltage about steps."""
    time_s = np.arange(30_000) * PERIOD_S
    level = np.repeat([0.1, -0.1, 0.2, -0.2, 0.25, -0.25], 5_000)
    wave = 0.08 * np.sin(2.0 * np.pi * 270.0 * time_s)
    parts = [
        readings((level + wave * np.sign(level))[begin : begin + 5_000], 0.0, random, **changes)
        for begin in range(0, 30_000, 5_000)
    ]
    return Intervals.together([intervals(part, SUPPLY_V) for part in parts])


def turned(random: np.random.Generator, speeds: tuple[float, ...] = (-75.0, -25.0, 25.0, 75.0)):  # type: ignore[no-untyped-def]
    """Give intervals of a knob that turns evenly against friction."""
    parts = []
    for speed in speeds:
        volts = CONSTANT * speed + OHM * 0.2 * np.sign(speed)
        parts.append(readings(np.full(8_000, volts / SUPPLY_V), speed, random))
    return Intervals.together([intervals(part, SUPPLY_V) for part in parts])


def covers(quantity: Quantity, truth: float) -> bool:
    low, high = quantity.interval
    return low <= truth <= high


@pytest.mark.parametrize(
    ("reading_a", "reason"),
    [(0.0, "dead_sensor"), (0.3, "dead_sensor"), (16.4, "saturated_sensor")],
)
def test_sensor_that_always_says_the_same_is_refused(reading_a: float, reason: str) -> None:
    with pytest.raises(Refusal, match="all the time") as caught:
        current_zero(np.full(100, reading_a), step_a=4e-3, v_per_a=0.2)
    assert caught.value.reason == reason


def test_sensor_without_noise_is_none_that_is_broken() -> None:
    zero, noise = current_zero(np.full(100, 8.25), step_a=4e-3, v_per_a=0.2)
    assert covers(zero, 1.65)
    assert covers(noise, 0.0)


@given(delay_share=st.floats(0.0, 1.0), seed=st.integers(0, 2**32), henry=st.floats(0.5e-3, 5e-3))
@settings(max_examples=15, deadline=None)
def test_without_noise_any_intervals_tell_the_winding(
    delay_share: float, seed: int, henry: float
) -> None:
    """The sums follow the equation except for the current between two measurements."""
    held = pushed(np.random.default_rng(seed), delay_share=delay_share, noise_a=0.0, henry=henry)
    fit = winding(held, believed_ohm=2.5, believed_h=1.5e-3, constant_nm_per_a=0.05)
    assert fit.value[0] == pytest.approx(OHM, rel=2e-4)
    # A straight line from one measurement to the next, for a current that bends.
    assert fit.value[1] == pytest.approx(henry, rel=1e-2)
    assert fit.value[2] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("gain", "reason"),
    [
        (-1.0, "reversed_sensor"),
        (0.01, "no_current"),
        (3.0, "winding_values"),
        (0.3, "winding_values"),
    ],
)
def test_winding_is_refused_with_its_fault(gain: float, reason: str) -> None:
    held = pushed(np.random.default_rng(0), gain=gain, noise_a=1e-4)
    with pytest.raises(Refusal) as caught:
        winding(held, believed_ohm=2.5, believed_h=1.5e-3, constant_nm_per_a=0.05)
    assert caught.value.reason == reason


def test_current_that_fits_is_believed_whichever_way_it_flows() -> None:
    for way in (1.0, -1.0):
        share = np.full(2000, way * 0.1)
        check_current(
            intervals(readings(share, 0.0, np.random.default_rng(2)), SUPPLY_V), 2.5, step=""
        )


def test_torque_constant_refuses_a_knob_that_turned_one_way_or_the_wrong_one() -> None:
    random = np.random.default_rng(3)
    held = pushed(random)
    with pytest.raises(Refusal, match="one way only"):
        motor(held, turned(random, (25.0, 75.0)), **BELIEVED, supply_sigma=0.0)
    both = turned(random)
    mirrored = Intervals(
        both.duration_s,
        both.voltage_v_s,
        both.charge_c,
        both.change_a,
        -both.angle_rad,
        both.share,
        both.change_late,
    )
    with pytest.raises(Refusal) as caught:
        motor(held, mirrored, **BELIEVED, supply_sigma=0.0)
    assert caught.value.reason == "reversed_emf"
