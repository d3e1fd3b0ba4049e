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
            "Damper": 22,
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
        empty_ns=31100,
        instruction_ns=7.4,
        empty=1468,
        law=327,
        laws={
            "paper": 0,
            "compensated": 51,
            "parallel": 126,
            "motor_only": -103,
            "calibrated": 1845,
        },
        effects={
            "Wall": 612,
            "Spring": 580,
            "Damper": 219,
            "Friction": 316,
            "Inertia": 318,
            "Constant": 155,
            "Ramp": 327,
            "Periodic": 1133,
            "Detents": 1084,
            "EndStops": 333,
            "Texture": 1134,
            "Curve": 399,
            "Impact": 1226,
        },
    ),
}
"""By the name of the board's folder."""
