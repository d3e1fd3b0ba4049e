"""A user's first steps with a knob plugged in."""

from __future__ import annotations

import sys

import pytest

from tests.vm.guest.virtual_bus import TREE
from tests.vm.guest.wheel import take_first_steps


@pytest.mark.kernel("6.12")
def test_first_steps_lead_a_plugged_knob_into_a_wall() -> None:
    # 50 mN m into 1.4 N m/rad from 0.1 rad, less the knob's own friction: README says 0.130.
    said = take_first_steps([sys.executable, "-W", "error", str(TREE / "tools/first_steps.py")])
    assert "pushed the knob to 0.130 rad" in said
