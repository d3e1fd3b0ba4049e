"""The boards that the firmware is built for: ``firmware/boards/*/board.cmake``.

``python -m tools.boards`` prints their names, one a line.
"""

from __future__ import annotations

import re
from pathlib import Path

FOLDER = Path(__file__).parent.parent / "firmware" / "boards"


def chips() -> dict[str, str]:
    """Return every board's chip, ``rp2040`` or ``rp2350``, by the board's name.

    Raises
    ------
    ValueError
        If a board does not say which chip it has.
    """
    found = {}
    for file in sorted(FOLDER.glob("*/board.cmake")):
        chip = re.search(r"^set\(TORSIO_CHIP (\w+)\)$", file.read_text(encoding="utf-8"), re.M)
        if chip is None:
            raise ValueError(f"{file}: no line set(TORSIO_CHIP ...)")
        found[file.parent.name] = chip[1]
    return found


def chip_of(firmware: Path) -> str:
    """Return the chip that a file is for whose name is ``torsio-BOARD.elf`` or ``.uf2``.

    Raises
    ------
    ValueError
        If there is no such board.
    """
    board = firmware.stem.removeprefix("torsio-")
    try:
        return chips()[board]
    except KeyError:
        names = ", ".join(chips())
        raise ValueError(f"{firmware.name}: no board {board!r}; there are {names}") from None


if __name__ == "__main__":
    print("\n".join(chips()))
