"""A game on the emulated knob; its reports are packed by hand after docs/reference/games.md."""

from __future__ import annotations

import struct

import torsio

CONSTANT, SPRING = 1, 8


class Game:
    """A game's orders to its effects, a report each."""

    def __init__(self, knob: torsio.Knob) -> None:
        self.port = knob.emulator.game
        self.knob = knob

    def create(self, kind: int) -> int:
        assert self.port.set_feature(struct.pack("<BBH", 0x21, kind, 0))
        answer = self.port.get_feature(0x22)
        assert answer is not None
        block = answer[1]
        self.effect(block, kind)
        return block

    def effect(self, block: int, kind: int) -> None:
        self.port.write(
            struct.pack("<BBBHHHHBBHH", 0x11, block, kind, 0xFFFF, 0, 0, 32767, 0, 2, 24575, 0)
        )

    def envelope(self, block: int) -> None:
        self.port.write(struct.pack("<BBHHHH", 0x12, block, 0, 0, 0, 0))

    def constant(self, block: int, level: int) -> None:
        self.port.write(struct.pack("<BBh", 0x15, block, level))

    def play(self, block: int) -> None:
        self.port.write(struct.pack("<BBBB", 0x1A, block, 1, 1))

    def stop(self, block: int) -> None:
        self.port.write(struct.pack("<BBBB", 0x1A, block, 3, 0))
