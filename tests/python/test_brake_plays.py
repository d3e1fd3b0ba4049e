"""A model of one play for a brake of two: docs/explanation/theory.md, "The brake's loop"."""

from __future__ import annotations

import numpy as np
import pytest

from torsio.calibration.brake import STAIRS
from torsio.calibration.numeric import gauss_newton, play_of
from torsio.calibration.quantity import Array

WIDTHS_NM = (2.75e-3, 8.25e-3)  # in equal parts; their mean is 5 % of the brake's limit
TOP_NM = 52e-3
NOISE_NM = 30e-6  # noise of a stair, as calibration states it
POINTS_NM = TOP_NM * np.array(STAIRS)
# Twice into a wall of 75 mN m and out again. The brake carries half.
VISITS_NM = np.concatenate(2 * [37.5e-3 * (1.0 - np.abs(np.linspace(-1.0, 1.0, 401)))])


def _sum_of(command_nm: Array, widths_nm: tuple[float, ...], shares: tuple[float, ...]) -> Array:
    """Plays in parallel; the brake was held before."""
    parts = zip(shares, widths_nm, strict=True)
    result: Array = np.sum([w * play_of(command_nm, abs(h), abs(h)) for w, h in parts], axis=0)
    return result


def _of_two(command_nm: Array, value: Array) -> Array:
    first, second, share, gain = (float(number) for number in value)
    return _sum_of(command_nm, (first, second), (gain * share, gain * (1.0 - share)))


def _of_one(command_nm: Array, value: Array) -> Array:
    return _sum_of(command_nm, (float(value[0]),), (float(value[1]),))


def _errors_nm(seed: int) -> tuple[float, float]:
    """RMS of what one play and what two get wrong in the visits, fitted to the stairs."""
    true_nm = _sum_of(POINTS_NM, WIDTHS_NM, (0.5, 0.5))
    measured = true_nm + np.random.default_rng(seed).normal(0.0, NOISE_NM, len(true_nm))
    one = gauss_newton(
        lambda value: _of_one(POINTS_NM, value), measured, np.array([5e-3, 1.0]),
        scale=np.array([2e-5, 1e-3]), steps=40,
    )  # fmt: skip
    two = gauss_newton(
        lambda value: _of_two(POINTS_NM, value), measured, np.array([3e-3, 7e-3, 0.5, 1.0]),
        scale=np.array([2e-5, 2e-5, 1e-3, 1e-3]), steps=60,
    )  # fmt: skip
    visited_nm = _sum_of(VISITS_NM, WIDTHS_NM, (0.5, 0.5))
    wrong = (_of_one(VISITS_NM, one.value), _of_two(VISITS_NM, two.value))
    errors = [float(np.sqrt(np.mean((told - visited_nm) ** 2))) for told in wrong]
    return errors[0], errors[1]


def test_second_play_would_take_away_what_one_gets_wrong_in_a_wall() -> None:
    one, two = np.median([_errors_nm(seed) for seed in range(20)], axis=0)
    assert one == pytest.approx(0.87e-3, abs=0.05e-3)
    assert two < 0.05e-3
