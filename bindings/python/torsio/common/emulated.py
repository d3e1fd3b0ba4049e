"""Emulated knobs: the meaning of a selector, and the firmware's host."""

from __future__ import annotations

from typing import Final

__all__ = ["EMULATED", "moves_parts", "selects_emulated"]

EMULATED: Final = "emulated"
"""The selector of an emulated knob, its transport, and the board of one and of a virtual knob."""


def selects_emulated(selector: str) -> bool:
    """Whether a selector means an emulated knob, with a name or without."""
    return selector.partition(":")[0] == EMULATED


def moves_parts(board: str) -> bool:
    """Whether a board has a real motor, which can hurt: a virtual knob's has not."""
    return board != EMULATED
