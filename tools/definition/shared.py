"""Shared by the printers of files: where the lists are, and which enumerations belong together."""

from __future__ import annotations

from pathlib import Path

from firmware.protocol.definition import effects
from firmware.protocol.definition import enumerations as e
from tools.definition.model import Enumeration

TREE = Path(__file__).parent.parent.parent
LISTS = "firmware/protocol/definition/"
PLANT_LISTS = "emulator/definition/"

EFFECT_ENUMERATIONS = tuple(
    dict.fromkeys(
        field.of
        for of in effects.EFFECTS
        for field in of.fields
        if isinstance(field.of, Enumeration)
    )
)
CONFIG_ENUMERATIONS = (e.LAW, e.BASIS, e.PERSONALITY, e.DIAL_USE)
DEVICE_ENUMERATIONS = (
    e.STATE, e.OWNER, e.GAME_EFFECT_KIND, e.GAME_EFFECT_STATE, e.RESET_CAUSE, e.CENTRE,
)  # fmt: skip

KNOT = (
    "One corner of a piecewise-linear function of time. The first value holds before the first "
    "knot, the last one after the last. Two knots at the same time make a jump."
)
