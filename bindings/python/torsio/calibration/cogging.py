"""Cogging over the angle: the waves of a turn that explain what slow turns need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from torsio.calibration.quantity import Array
from torsio.common import checks

__all__ = ["Cogging", "find_waves"]

_MOST_PERIODS, _MOST_WAVES = 128, 8
# Noise alone gives the best of so many waves a few parts in a hundred. The first must be beyond all
# doubt, or a motor without cogging has some.
_FIRST, _LATER = 0.7, 0.85
_POINTS = 360
"""Points of the table: more than two for each of the shortest waves."""


@dataclass(frozen=True, repr=False)
class Cogging(checks.ShortRepr):
    """Torque on the knob over the angle from the device's zero, as a sum of waves.

    Attributes
    ----------
    periods_per_rev
        Periods of each wave, the largest wave first; shape (n,).
    cosine_nm, sine_nm
        Amplitudes of each wave; shape (n,).
    covariance
        Covariance of cosine and sine, wave by wave; shape (2n, 2n).
    left_nm
        Amplitude of the largest wave that was not taken for one.
    """

    periods_per_rev: tuple[int, ...]
    cosine_nm: Array
    sine_nm: Array
    covariance: Array
    left_nm: float

    @property
    def amplitudes_nm(self) -> Array:
        """Amplitude of each wave, shape (n,)."""
        return np.hypot(self.cosine_nm, self.sine_nm)

    @property
    def sigmas_nm(self) -> Array:
        """Standard uncertainty of each amplitude, shape (n,)."""
        result = np.empty(len(self.periods_per_rev))
        for index, amplitude in enumerate(self.amplitudes_nm):
            along = np.array([self.cosine_nm[index], self.sine_nm[index]]) / max(amplitude, 1e-12)
            pair = slice(2 * index, 2 * index + 2)
            result[index] = np.sqrt(max(along @ self.covariance[pair, pair] @ along, 0.0))
        return result

    def _slopes(self, angle_rad: Array) -> Array:
        phase = np.outer(angle_rad, np.array(self.periods_per_rev, dtype=np.float64))
        pairs = np.stack([np.cos(phase), np.sin(phase)], axis=-1)
        return pairs.reshape(len(angle_rad), 2 * len(self.periods_per_rev))

    def torque_nm(self, angle_rad: Array) -> Array:
        """Give the torque on the knob, shape (n,)."""
        values = np.column_stack([self.cosine_nm, self.sine_nm]).ravel()
        result: Array = self._slopes(angle_rad) @ values
        return result

    def sigma_nm(self, angle_rad: Array) -> Array:
        """Give that torque's standard uncertainty, with the waves not found, shape (n,)."""
        slopes = self._slopes(angle_rad)
        variance = np.einsum("ni,ij,nj->n", slopes, self.covariance, slopes)
        result: Array = np.sqrt(np.maximum(variance, 0.0) + 0.5 * self.left_nm**2)
        return result

    def as_uncertain_as(self, sigma_nm: float) -> Cogging:
        """Give it with the largest wave so uncertain, and the others widened by the same share."""
        if not self.periods_per_rev:
            return self
        amplitudes = self.amplitudes_nm
        added = max(sigma_nm**2 - self.sigmas_nm[0] ** 2, 0.0) * (amplitudes / amplitudes[0]) ** 2
        # The same error of the amplitude wherever along the wave: half the square on either part.
        return replace(self, covariance=self.covariance + np.diag(np.repeat(added, 2)))

    def as_dict(self) -> dict[str, Any]:
        """Give the waves, ``amplitude * sin(periods * angle + phase)``, and a table, for JSON."""
        angle_rad = 2.0 * np.pi * np.arange(_POINTS) / _POINTS
        return {
            "waves": [
                {
                    "periods_per_rev": periods,
                    "amplitude_nm": float(amplitude),
                    "standard_uncertainty_nm": float(sigma),
                    "phase_rad": float(phase),
                }
                for periods, amplitude, sigma, phase in zip(
                    self.periods_per_rev,
                    self.amplitudes_nm,
                    self.sigmas_nm,
                    np.arctan2(self.cosine_nm, self.sine_nm),
                    strict=True,
                )
            ],
            "angle_rad": angle_rad.tolist(),
            "torque_nm": self.torque_nm(angle_rad).tolist(),
            "standard_uncertainty_nm": self.sigma_nm(angle_rad).tolist(),
        }


def find_waves(
    columns: Callable[[tuple[int, ...]], Array], motor_nm: Array
) -> tuple[tuple[int, ...], float]:
    """Find the waves that explain slow turns.

    Parameters
    ----------
    columns
        Columns of the equations with these waves, cosine and sine of each at the end; shape (n, m).

    Returns
    -------
    periods_per_rev, left_nm
        The largest first, and the amplitude of the largest wave that was not taken for one.
    """
    found: tuple[int, ...] = ()
    while True:
        others = [one for one in range(2, _MOST_PERIODS + 1) if one not in found]
        slopes = columns((*found, *others))
        begin = slopes.shape[1] - 2 * len(others)
        # The rest of the torque, and of each other wave, behind the waves found so far.
        base, _ = np.linalg.qr(slopes[:, :begin])
        left_nm = motor_nm - base @ (base.T @ motor_nm)
        pairs = slopes[:, begin:] - base @ (base.T @ slopes[:, begin:])
        pairs = pairs.T.reshape(len(others), 2, -1)
        along = pairs @ left_nm
        grams = pairs @ pairs.transpose(0, 2, 1) + 1e-30 * np.eye(2)
        waves = np.linalg.solve(grams, along[..., None])[..., 0]
        explained = np.sum(along * waves, axis=1)
        best, before = int(np.argmax(explained)), float(left_nm @ left_nm)
        enough = 1.0 - (_LATER if found else _FIRST)
        if len(found) == _MOST_WAVES or explained[best] <= enough * before:
            return found, float(np.hypot(*waves[best]))
        found = (*found, others[best])
