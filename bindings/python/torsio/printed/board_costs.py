"""Instructions and time of a control tick on each board, by the effects that play."""

# Printed from the field lists in firmware/protocol/definition/ by `./dev generate`;
# change those instead.

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

__all__ = [
    "BOARDS",
    "BoardCost",
]


@dataclass(frozen=True)
class BoardCost:
    """Cost of a tick on a board.

    Attributes
    ----------
    period_ns
        From tick to tick.
    empty_ns
        The control interrupt's time with an empty scene.
    instruction_ns
        Of a further instruction.
    empty
        Instructions of an armed tick with an empty scene.
    law
        That the law adds as soon as an effect plays.
    laws
        That each law adds to that, if it was counted.
    effects
        That each effect adds, by the name of its class, if it was counted.
    """

    period_ns: int
    empty_ns: int
    instruction_ns: float
    empty: int
    law: int
    laws: dict[str, int]
    effects: dict[str, int]


BOARDS: Final = {
    "pico2": BoardCost(
        period_ns=50000,
        empty_ns=6600,
        instruction_ns=12.2,
        empty=171,
        law=26,
        laws={
            "paper": 0,
            "compensated": 2,
            "parallel": 0,
            "motor_only": -1,
            "calibrated": 81,
        },
        effects={
            "Wall": 37,
            "Spring": 52,
            "Damper": 19,
            "Friction": 28,
            "Inertia": 28,
            "Constant": 59,
            "Ramp": 64,
            "Periodic": 91,
            "Detents": 65,
            "EndStops": 38,
            "Texture": 78,
            "Curve": 36,
            "Impact": 247,
        },
    ),
    "pico": BoardCost(
        period_ns=100000,
        empty_ns=31600,
        instruction_ns=7.6,
        empty=1836,
        law=515,
        laws={
            "paper": 0,
            "compensated": 60,
            "parallel": 193,
            "motor_only": -165,
            "calibrated": 2292,
        },
        effects={
            "Wall": 954,
            "Spring": 709,
            "Damper": 223,
            "Friction": 379,
            "Inertia": 437,
            "Constant": 213,
            "Ramp": 447,
            "Periodic": 1686,
            "Detents": 1637,
            "EndStops": 391,
            "Texture": 1554,
            "Curve": 326,
            "Impact": 1542,
        },
    ),
}
"""By the name of the board's folder."""
