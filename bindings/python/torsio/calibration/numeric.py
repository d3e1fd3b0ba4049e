"""The mathematics of the estimators: least squares with uncertainties, smooth windows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from torsio.calibration.quantity import Array

__all__ = ["Solution", "crossings", "gauss_newton", "kernel", "linear", "play_of", "smooth"]


@dataclass(frozen=True)
class Solution:
    """Values of the parameters, their covariance, and what is left."""

    value: Array
    covariance: Array
    residual: Array

    def sigma(self, index: int) -> float:
        """Give the standard uncertainty of one parameter."""
        return float(np.sqrt(max(self.covariance[index, index], 0.0)))


def _covariance(slopes: Array, residual: Array, lags: int) -> Array:
    """Give the covariance of a least-squares fit whose residuals hang together over `lags` samples.

    The estimate of Newey and West; White's without lags.
    """
    count, unknowns = slopes.shape
    inverse = np.linalg.pinv(slopes.T @ slopes)
    scores = slopes * residual[:, None]
    middle = scores.T @ scores
    for lag in range(1, min(lags, count - 1) + 1):
        part = scores[lag:].T @ scores[:-lag]
        middle += (1.0 - lag / (lags + 1.0)) * (part + part.T)
    result: Array = inverse @ middle @ inverse * count / max(count - unknowns, 1)
    return result


def linear(slopes: Array, measured: Array, *, lags: int = 0) -> Solution:
    """Fit measured = slopes @ value, with columns of whatever size."""
    size = np.sqrt(np.mean(slopes**2, axis=0))
    size[size == 0.0] = 1.0
    scaled = slopes / size
    value = np.linalg.lstsq(scaled, measured, rcond=None)[0]
    residual = measured - scaled @ value
    covariance = _covariance(scaled, residual, lags) / np.outer(size, size)
    return Solution(value / size, covariance, residual)


def gauss_newton(
    model: Callable[[Array], Array],
    measured: Array,
    start: Array,
    *,
    scale: Array,
    lags: int = 0,
    steps: int = 12,
) -> Solution:
    """Fit measured = model(value) from a start nearby; `scale` is a small change of each value."""

    def slopes_at(value: Array, there: Array) -> Array:
        columns = []
        # Away from zero: there a model of a size folds, whatever its sign, and looks flat.
        for index, step in enumerate(np.copysign(scale, value)):
            moved = value.copy()
            moved[index] += step
            columns.append((model(moved) - there) / step)
        return np.column_stack(columns)

    value = np.array(start, dtype=np.float64)
    there = model(value)
    cost = float(np.sum((measured - there) ** 2))
    damping = 1e-3
    slopes = slopes_at(value, there)
    for _ in range(steps):
        size = np.sqrt(np.sum(slopes**2, axis=0)) + 1e-30
        scaled = slopes / size
        matrix = scaled.T @ scaled
        gradient = scaled.T @ (measured - there)
        improved = False
        for _ in range(6):
            change = np.linalg.solve(matrix + damping * np.eye(len(value)), gradient) / size
            trial = value + change
            trial_there = model(trial)
            trial_cost = float(np.sum((measured - trial_there) ** 2))
            if trial_cost < cost:
                improved = True
                break
            damping *= 10.0
        if not improved:
            break
        gain = (cost - trial_cost) / max(cost, 1e-300)
        value, there, cost = trial, trial_there, trial_cost
        damping *= 0.1
        slopes = slopes_at(value, there)
        if gain < 1e-9:
            break
    residual = measured - there
    size = np.sqrt(np.sum(slopes**2, axis=0)) + 1e-30
    covariance = _covariance(slopes / size, residual, lags) / np.outer(size, size)
    return Solution(value, covariance, residual)


def kernel(half_width: int, period_s: float) -> tuple[Array, Array, Array]:
    """Give a smooth window of sum 1 and its first two differences, all of 2 half_width + 3 points.

    Data weighed with the differences are exactly derivatives weighed with the window. So
    measurements are never differentiated.
    """
    place = np.linspace(-1.0, 1.0, 2 * half_width + 1)
    window = (1.0 - place**2) ** 4
    window /= window.sum()
    padded = np.pad(window, 2)
    first = (padded[2:] - padded[:-2]) / (2.0 * period_s)
    second = (padded[2:] - 2.0 * padded[1:-1] + padded[:-2]) / period_s**2
    return padded[1:-1], first, second


def smooth(data: Array, window: Array, *, odd: bool = False) -> Array:
    """Weigh with the window round every sample; `odd` for a first difference. Shape (n-m+1,)."""
    weights = window if odd else window[::-1]
    return np.asarray(np.convolve(data, weights, mode="valid"), dtype=np.float64)


def crossings(counts: Array, values: Array) -> tuple[Array, Array]:
    """Give each border between two counts that a sweep crosses, and a value interpolated there.

    Parameters
    ----------
    counts
        Counts of a sweep in one direction, in whole counts; noise may toggle it.
    values
        Values to read off at the borders; they rise or fall evenly.

    Returns
    -------
    borders, values
        In counts, and in the unit of `values`. The first and last two counts are left out.
    """
    rising = counts[-1] >= counts[0]
    ordered = counts if rising else counts[::-1]
    reading = values if rising else values[::-1]
    low, high = int(ordered.min()) + 2, int(ordered.max()) - 1
    if high <= low:
        return np.empty(0), np.empty(0)
    borders = np.arange(low, high + 1, dtype=np.float64)
    # How many samples lie below a border says where it was crossed, however often noise toggled.
    below = np.searchsorted(np.sort(ordered), borders, side="left") - 0.5
    place = np.arange(len(reading), dtype=np.float64)
    result: Array = np.interp(below, place, reading)
    return borders, result


def play_of(command: Array, half_width: float, start: float) -> Array:
    """Give the play (backlash operator) of a sequence of commands, never below zero."""
    result = np.empty_like(command)
    held = start
    for index, value in enumerate(command):
        held = max(0.0, min(max(held, value - half_width), value + half_width))
        result[index] = held
    return result
