"""The emulated device and its parts, each on its own, for study.

`torsio.open("emulated")` puts them together; here are the plant, hands' profiles, the encoder, and
the whole device at the level of report bytes.
"""

from __future__ import annotations

from torsio._torsio.emulator import PLANT_DTYPE, EmulatedDevice, Encoder, Plant, Profile
from torsio.closed_loop import (
    LOOP_DTYPE,
    REPLAY_DTYPE,
    ClosedLoop,
    InitialState,
    LoopOptions,
    SpinUp,
    replay,
    simulate,
    simulate_many,
)

__all__ = [
    "LOOP_DTYPE",
    "PLANT_DTYPE",
    "REPLAY_DTYPE",
    "ClosedLoop",
    "EmulatedDevice",
    "Encoder",
    "InitialState",
    "LoopOptions",
    "Plant",
    "Profile",
    "SpinUp",
    "replay",
    "simulate",
    "simulate_many",
]
