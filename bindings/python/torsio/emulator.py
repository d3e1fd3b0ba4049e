"""The emulated device and its parts, each on its own, for study.

`torsio.open("emulated")` puts them together; here are the plant, hands' profiles, the encoder, and
the whole device at the level of report bytes.
"""

from __future__ import annotations

from torsio._torsio.emulator import PLANT_DTYPE, EmulatedDevice, Encoder, Plant, Profile

__all__ = ["PLANT_DTYPE", "EmulatedDevice", "Encoder", "Plant", "Profile"]
