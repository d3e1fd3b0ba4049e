"""An ordinary knob of the SDK whose device is a board's binary in its emulated chip.

The board is coupled to a world, and time passes for both in the knob's calls only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import torsio
from tests.board import felt
from tests.board.pico import MS, EmulatedPico, UsbStall, enumerated
from torsio.printed.plant import PlantParams

TAKEN_MS = 20  # so long the bus tries to hand over a report


class BinaryTransport(torsio.Transport):
    """Moves reports over the USB of an emulated chip."""

    time_is_virtual = True

    def __init__(self, board: EmulatedPico) -> None:
        self._board = board

    def close(self) -> None:
        """Leave the board open: its maker closes it."""

    def write(self, report: bytes) -> bool:
        return self._board.write(report, within_ms=TAKEN_MS) == "ack"

    def read(self, timeout_s: float) -> bytes | None:
        answer = self._board.do("in", endpoint=1, within_ns=0)
        return None if answer == "nak" else bytes.fromhex(answer["data"])

    def get_feature(self, report_id: int) -> bytes | None:
        try:
            return self._board.get_raw(report_id)
        except UsbStall:
            return None

    def set_feature(self, report: bytes) -> bool:
        try:
            self._board.set_raw(report[0], report)
        except UsbStall:
            return False
        return True

    def now_ns(self) -> int:
        return int(self._board.status()["ns"])

    def advance_to(self, time_ns: int) -> None:
        left_ns = time_ns - self.now_ns()
        if left_ns > 0:
            self._board.run(left_ns / MS)


@contextmanager
def live_knob(
    params: PlantParams, boot: Callable[[], AbstractContextManager[EmulatedPico]] = enumerated
) -> Iterator[tuple[torsio.Knob, felt.Place]]:
    """Give a knob whose device is the chosen board's binary, and the world that it is in."""
    with felt.binary(params, boot) as bench, torsio.open(BinaryTransport(bench.board)) as knob:
        yield knob, bench.place
