"""What each board does when one of its parts goes wrong, as JSON lines.

``./dev bench guards`` runs each board's real firmware in its emulated chip, has it push into a wall
with all that its motor may, and then has one of the dangers of ``tests/board/dangers.py`` happen.
A line tells after how long motor and brake were off, to 0.05 ms below 1 ms and to 0.25 ms above,
and which fault is latched or which cause of a restart is told.

For the wires of the encoder the board is coupled to the plant: a hand leans on a wall with 50 mN m,
the wires are cut, and the hand lets go. These lines also tell, to 4 ms, how far and how fast the
knob turned until the outputs were off, and what it reached.

Arguments are names of boards. It takes two minutes for each.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent.parent.parent))

from tests.board import felt
from tests.board.dangers import DANGERS, FAULTS, react
from tests.board.pico import MODELS, choose, enumerated
from torsio.hands import NoHand

LEAN_NM = 50e-3
STIFFNESS = math.degrees(30e-3)
A, B = 2, 3


def _tell(board: str, danger: str, **line: Any) -> None:
    print(json.dumps({"board": board, "danger": danger, **line}), flush=True)


def main(boards: list[str]) -> None:
    """Print the lines of each board."""
    for board in boards or MODELS:
        choose(board)
        with enumerated() as pico:
            for danger in DANGERS:
                passed_ms, told = react(pico, danger)
                _tell(board, danger.name, off_ms=round(passed_ms, 2), tells=told)
        for name, pins in (("encoder: one channel dead", [B]), ("encoder: cable off", [A, B])):
            with felt.binary(felt.plant_of(board)) as bench:
                felt.prepare(bench)
                felt.lean(bench, STIFFNESS, LEAN_NM)
                found = felt.cut_encoder(bench, pins, NoHand(), 0.6)
                _tell(
                    board,
                    name,
                    off_ms=None if found.off_s is None else round(1e3 * found.off_s),
                    tells=", ".join(n for i, n in enumerate(FAULTS) if found.faults >> i & 1),
                    moved_rad=round(found.moved_rad, 2),
                    fastest_rad_s=round(found.fastest_rad_s),
                )


if __name__ == "__main__":
    main(sys.argv[1:])
