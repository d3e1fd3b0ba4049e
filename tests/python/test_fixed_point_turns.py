"""Angles travel as 2^-32 turns, and the nearest of them is sent, on every system.

The reference is exact: fractions, and pi to 50 digits.
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import torsio
from tests.python import wire
from torsio.closed_loop import LoopOptions, reports

TURN_RAD = 2 * Fraction("3.14159265358979323846264338327950288419716939937510")
MOST_RAD = 2**26 * 2 * math.pi
# A rounded value may be wrong by a hundred-thousandth of a step.
NEAREST = Fraction(1, 2) + Fraction(1, 100_000)


def sent(effect: torsio.Effect, field: str, counts_per_rev: int = 8192) -> int:
    actuator = torsio.ActuatorConfig(counts_per_rev=counts_per_rev)
    options = LoopOptions(scene=effect, actuator=actuator)
    found = (wire.decode(report) for report in reports(options))
    (value,) = (values[field] for _, values in found if field in values)
    assert isinstance(value, int)
    return value


@pytest.mark.parametrize("angle_rad", [0.05, 1.0, -1e3, 4e8, -4e8, 1e-9, 2 * math.pi, MOST_RAD])
def test_angle_of_an_effect_is_the_nearest(angle_rad: float) -> None:
    exact = Fraction(angle_rad) / TURN_RAD * 2**32
    wall = torsio.Wall(angle_rad=angle_rad, stiffness_nm_per_rad=1.0)
    assert abs(sent(wall, "angle_turns_q32") - exact) <= NEAREST


@given(st.floats(-MOST_RAD, MOST_RAD))
def test_any_angle_of_an_effect_is_the_nearest(angle_rad: float) -> None:
    test_angle_of_an_effect_is_the_nearest(angle_rad)


@given(st.floats(2 * math.pi / 64, 128 * 6.283185307))
def test_span_of_a_curve_is_the_nearest(span_rad: float) -> None:
    curve = torsio.Curve(angle_rad=0.0, span_rad=span_rad, torque_nm=[0.0, 0.01])
    exact = Fraction(span_rad) / TURN_RAD * 2**32
    assert abs(sent(curve, "span_turns_q32") - exact) <= NEAREST


@given(st.floats(2 * math.pi / 65536, 2 * math.pi * 2**32))
def test_pitch_of_detents_is_the_nearest(pitch_rad: float) -> None:
    detents = torsio.Detents(pitch_rad=pitch_rad, torque_nm=0.01)
    exact = TURN_RAD / Fraction(pitch_rad) * 2**32
    assert abs(sent(detents, "per_turn_q32", 1 << 24) - exact) <= NEAREST


@given(st.floats(2.0**-32, 65536.0))
def test_number_of_detents_is_the_nearest(per_turn: float) -> None:
    detents = torsio.Detents(per_turn=per_turn, torque_nm=0.01)
    exact = Fraction(per_turn) * 2**32
    assert abs(sent(detents, "per_turn_q32", 1 << 24) - exact) <= NEAREST


@pytest.mark.parametrize(
    ("changes", "limit"),
    [
        ({"per_turn": 65536.1}, "2.328306e-10 to 65536"),
        ({"pitch_rad": 9.5e-5}, "9.58738e-05 to 2.698608e+10 rad"),
    ],
)
def test_detents_finer_than_travel_are_refused_in_the_users_words(
    changes: dict[str, Any], limit: str
) -> None:
    with pytest.raises(torsio.InvalidArgument) as found:
        sent(replace(torsio.Detents(torque_nm=0.01), **changes), "per_turn_q32", 1 << 24)
    (name,) = changes
    assert str(found.value).startswith(
        f"effect 0 (detents): {name} is {changes[name]}, allowed are"
    )
    assert str(found.value).endswith(limit)
