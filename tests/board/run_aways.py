"""Faults that could throw a knob, made on a board that is coupled to the plant."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from tests.board import felt, pico
from tests.board.unguarded import take_away, unguarded
from torsio.printed.hands import NoHand

STIFFNESS = math.degrees(30e-3)
LEAN_NM = 50e-3
WITHIN_S = 0.3
A, B = 2, 3


@dataclass(frozen=True)
class RunAway:
    """One of them.

    Attributes
    ----------
    name
        What has happened, as the table of docs/results.md has it.
    law
        With it the knob gets fastest.
    guards
        What stands against it, by name in ``unguarded.GUARDS``.
    begin
        Makes the board play, has it happen, and watches.
    tells
        The fault that is latched; empty: none, for nothing turns.
    most_rad, most_rad_s
        So far and so fast at most the knob turns with them.
    both_boards
        It is tried on both; what is much like another only on the quicker one.
    """

    name: str
    law: str
    guards: tuple[str, ...]
    begin: Callable[[felt.Bench], felt.RunAway]
    tells: str
    most_rad: float
    most_rad_s: float
    both_boards: bool = True

    def __str__(self) -> str:
        return self.name

    @contextmanager
    def bench(self, *, guarded: bool) -> Iterator[felt.Bench]:
        """Give the chosen board, ready for it, with its guards or without."""
        boot = pico.enumerated if guarded else unguarded
        with felt.binary(felt.plant_of(pico.chosen.name), boot) as bench:
            if not guarded:
                take_away(bench.board, *self.guards)
            felt.prepare(bench, law=self.law)
            yield bench


def _cut(*pins: int) -> Callable[[felt.Bench], felt.RunAway]:
    def begin(bench: felt.Bench) -> felt.RunAway:
        felt.lean(bench, STIFFNESS, LEAN_NM)
        return felt.cut_encoder(bench, pins, NoHand(), WITHIN_S)

    return begin


def _swap(part: str) -> Callable[[felt.Bench], felt.RunAway]:
    def begin(bench: felt.Bench) -> felt.RunAway:
        felt.turn_wrong_way(bench, part)
        return felt.touch_spring(bench, WITHIN_S)

    return begin


def _shift(amperes: float) -> Callable[[felt.Bench], felt.RunAway]:
    return lambda bench: felt.shift_zero(bench, amperes, WITHIN_S)


_ENCODER = ("dead channel", "winding")
RUN_AWAYS = (
    RunAway("encoder: one channel dead", "paper", _ENCODER, _cut(B), "encoder", 0.6, 20.0),
    RunAway("encoder: cable off", "paper", _ENCODER, _cut(A, B), "winding", 6.0, 60.0),
    # The speed limit is 10 rad/s and the speed estimate is some milliseconds late. "Unguarded" also
    # lacks the winding's guard, which sees that motor and knob turn different ways.
    *(
        RunAway(f"{part}'s sign wrong, {brake} the brake", law, ("timid", "winding"), _swap(part),
                tells, 0.7, 11.0, both_boards=brake == "without")
        for part in ("encoder", "motor")
        for brake, law, tells in (("without", "motor_only", "over_speed"), ("with", "paper", ""))
    ),
    *(
        RunAway(f"current sensor's zero moves by {amperes:g} A, knob let go", "motor_only",
                ("winding",), _shift(amperes), "winding", 0.3, 15.0, both_boards=amperes != 0.4)
        for amperes in (0.25, 0.4, 0.8)
    ),
    # 5 mN m of 8 that friction and drag hold.
    RunAway("current sensor's zero moves by 0.1 A, knob let go", "motor_only", ("winding",),
            _shift(0.1), "", 2e-3, 0.1, both_boards=False),
)  # fmt: skip
