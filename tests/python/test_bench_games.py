"""What the games' benchmark makes of times and torques; what it measures is another matter."""

from __future__ import annotations

import numpy as np
import pytest

from tests.bench import bench_games, game_frames
from tests.vm.guest import effect_forms


def test_delay_counts_from_the_call_to_the_first_and_to_nearly_all_of_the_change() -> None:
    time_s = np.arange(0.0, 0.1, 1e-4, dtype=np.float64)
    sent_s = np.array([0.01, 0.04, 0.07])
    # Up from 3 ms after the first call on, and down from 5 ms after the second: 2 ms each.
    torque = np.interp(time_s, [0.013, 0.015, 0.045, 0.047], [-0.2, 0.6, 0.6, -0.2])
    first_ms, whole_ms = bench_games._delays_ms(sent_s, time_s, torque)
    assert first_ms == pytest.approx([3.0, 5.0], abs=0.11)
    assert whole_ms == pytest.approx([5.0, 7.0], abs=0.11)


def test_error_is_told_at_its_largest_and_as_root_mean_square() -> None:
    line = bench_games._error_line("sine", np.array([0.03, -0.04, 0.0, 0.0]))
    assert line == {
        "what": "torque_error",
        "effect": "sine",
        "max_share": 0.04,
        "rms_share": 0.025,
    }


def test_every_kind_of_effect_is_played() -> None:
    timed = " ".join(effect_forms.cases())
    for kind in ("ramp", "square", "sine", "triangle", "saw_up", "saw_down", "rumble", "envelope"):
        assert kind in timed


def test_frames_are_compared_with_the_curve_that_they_are_of() -> None:
    time_s = np.arange(0.0, 3.0, 1e-4, dtype=np.float64)
    late = game_frames.measures(time_s, 0.5 * np.sin(2 * np.pi * (time_s - 0.012)))
    assert late["late_ms"] == pytest.approx(12.0)
    assert late["ripple_share"] < 1e-4
    assert late["overshoot_share"] == 0
    # Held for a frame of 20 ms: 10 ms late in the mean, and up to half a frame's change off.
    held = game_frames.measures(time_s, 0.5 * np.sin(2 * np.pi * np.floor(time_s * 50) / 50))
    assert held["late_ms"] == pytest.approx(10.0, abs=0.2)
    assert held["step_share"] == pytest.approx(0.5 * 2 * np.pi * 0.02, rel=0.02)
    assert held["ripple_share"] == pytest.approx(0.5 * 2 * np.pi * 0.01, rel=0.05)
