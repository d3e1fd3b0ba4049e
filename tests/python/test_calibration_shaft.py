"""The shaft's curve and its backlash, from slow pulls of a held knob that a closed form makes."""

from __future__ import annotations

import numpy as np
import pytest

from torsio.calibration.play import Run
from torsio.calibration.shaft import Shaft, estimate_shaft

STIFFNESS, COULOMB_NM, KNEE_RAD, FACTOR = 2.5, 6e-3, 0.010, 2.2
PULL_NM, PULL_S, PULLS, PERIOD_S = 72e-3, 0.9, 4, 1e-3


def _shaft(*, backlash_rad: float, knee_rad: float, counts_per_rev: int) -> Shaft:
    """Pull there and back, and estimate; friction and backlash are drawn as loops by hand.

    The knob follows a pull once that has come from behind its friction to before it. Then the shaft
    holds the pull less the friction, and is twisted by that over its stiffness, on the far side of
    what it has lost.
    """
    up_nm = np.arange(-PULL_NM, PULL_NM, 2.0 * PULL_NM * PERIOD_S / PULL_S)
    held_up_nm = np.maximum(up_nm - COULOMB_NM, -PULL_NM + COULOMB_NM)
    held_nm = np.concatenate([held_up_nm, -held_up_nm] * (PULLS // 2))
    motor_nm = np.concatenate([up_nm, -up_nm] * (PULLS // 2))
    knee_nm = STIFFNESS * knee_rad
    size_nm = np.abs(held_nm)
    soft_nm = np.minimum(size_nm, knee_nm)
    twist_rad = (soft_nm + (size_nm - soft_nm) / FACTOR) / STIFFNESS
    angle_rad = np.sign(held_nm) * (twist_rad + 0.5 * backlash_rad)
    count_rad = 2.0 * np.pi / counts_per_rev
    noise = np.random.default_rng(1).normal(0.3, 0.1, len(angle_rad))
    counts = np.floor(angle_rad / count_rad + noise)
    time_s = PERIOD_S * np.arange(len(counts), dtype=np.float64)
    none = np.zeros_like(time_s)
    pulls = Run(
        time_s, counts, counts * count_rad, none, motor_nm, motor_nm, none,
        count_rad=count_rad, period_s=PERIOD_S, tick_s=1e-4,
    )  # fmt: skip
    return estimate_shaft(pulls, pulls.between(0.0, 0.01), np.zeros_like, 1e-4)


@pytest.mark.parametrize("counts_per_rev", [8192, 32768])
@pytest.mark.parametrize("knee_rad", [1e9, KNEE_RAD], ids=["straight", "bent"])
@pytest.mark.parametrize("backlash_rad", [0.0, 0.2e-3, 0.5e-3, 1e-3, 2e-3])
def test_backlash_is_found_and_taken_out_of_the_curve(
    backlash_rad: float, knee_rad: float, counts_per_rev: int
) -> None:
    found = _shaft(backlash_rad=backlash_rad, knee_rad=knee_rad, counts_per_rev=counts_per_rev)
    tenth_of_a_count = 0.1 * 2.0 * np.pi / counts_per_rev
    assert found.backlash.value == pytest.approx(backlash_rad, abs=tenth_of_a_count)
    assert found.backlash.standard_uncertainty < 5e-5
    assert found.stiffness.value == pytest.approx(STIFFNESS, rel=5e-3)
    assert found.knob_coulomb.value == pytest.approx(COULOMB_NM, rel=1e-2)
    assert (found.knee is not None) == (knee_rad == KNEE_RAD)
    if found.knee is not None and found.factor is not None:
        assert found.knee.value == pytest.approx(KNEE_RAD, rel=1e-2)
        assert found.factor.value == pytest.approx(FACTOR, rel=1e-2)
