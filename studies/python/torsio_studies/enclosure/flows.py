"""Linear equations in ball arithmetic: their flows, and the first zeros of linear functions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from flint import arb, arb_mat, arb_poly, ctx
from scipy.linalg import matrix_balance

__all__ = ["COLUMNS", "Mode", "Row", "UndecidedError", "matrix_of", "since_before"]

COLUMNS: Final = 15
_TIE: Final = 1e-45  # s
_STILL: Final = {
    ("knob starts", "knob stops"): 1,
    ("knob starts", "cogging"): 2,
    ("brake starts", "brake stops"): 1,
}
"""Derivative of a function that is exactly 0 after an event: friction just balances the torque."""
_NEWTON: Final = 400
_DERIVATIVES: Final = 3
_FEW: Final = 30
"""Digits of what only carries an error on."""

Row = dict[int, Any]


class UndecidedError(ArithmeticError):
    """Two events are too near to be told apart, or a function touches 0."""


def matrix_of(rows: Sequence[Row]) -> Any:
    """Write linear functions as a matrix."""
    found = arb_mat(len(rows), COLUMNS)
    for number, row in enumerate(rows):
        for column, value in row.items():
            found[number, column] = value
    return found


def since_before(width: Any) -> Any:
    """Give the times of a piece, from just before it on: a zero may be there."""
    return arb(-_TIE).union(width)


class Stay:
    """A function that stays positive in a mode; its derivatives along the flow, from the 0th."""

    def __init__(self, name: str, row: Row, matrix: Any) -> None:
        self.name, self.derivatives = name, [matrix_of([row])]
        for _ in range(_DERIVATIVES + 1):
            self.derivatives.append(self.derivatives[-1] * matrix)

    def looks(self, here: Any, inside: Any, end: Any, after: str, *, is_last: bool) -> str:
        """Say whether a function surely has no zero in a piece of time, surely one, or neither.

        In truth it is never negative at the begin, whatever its ball says: only such modes begin.
        """
        value, slope = self.derivatives[:2]
        rate, begin = (slope * inside)[0, 0], (value * here)[0, 0]
        if rate >= 0 or (value * inside)[0, 0] > 0:
            return "none"
        if not rate < 0:
            return "none" if begin.contains(0) and self._rises(here, inside, after) else "?"
        last = (value * end)[0, 0]
        # A zero that may be just behind the end belongs to the next piece, if there is one.
        behind = last.abs_upper() < _TIE * rate.abs_lower() and not is_last
        if last >= 0 or (behind and last.contains(0)):
            return "none"
        return "one" if last < 0 else "?"

    def _rises(self, here: Any, inside: Any, after: str) -> bool:
        """Whether a derivative is surely positive, and none before it negative at the begin."""
        _, slope, *more = self.derivatives
        for order, before, above in zip(range(1, 9), [slope, *more], more, strict=False):
            if _STILL.get((after, self.name)) != order and not (before * here)[0, 0] >= 0:
                return False
            if (above * inside)[0, 0] > 0:
                return True
        return False

    def root(self, mode: Mode, here: Any, inside: Any, width: Any) -> Any:
        """Narrow the only zero of a falling function."""
        terms, left = mode.series(here, width)
        value, rate = (
            arb_poly([(row * term)[0, 0] for term in terms]) + (row * left)[0, 0]
            for row in self.derivatives[:2]
        )
        span, steepest = since_before(width), (self.derivatives[1] * inside)[0, 0]
        for _ in range(_NEWTON):
            middle = arb(span.mid())
            nearer = rate(span / width)
            steepest = nearer if nearer < 0 else steepest
            narrower = middle - value(middle / width) / steepest
            if not narrower.overlaps(span):
                raise UndecidedError("an event belongs to a moment before")
            narrower = narrower.intersection(span)
            if not float(narrower.rad()) < 0.5 * float(span.rad()):
                return narrower
            span = narrower
        return span


def both(one: Any, other: Any) -> Any:
    """Give what is in two boxes."""
    pairs = zip(one.tolist(), other.tolist(), strict=True)
    return arb_mat([[a.intersection(b)] for (a,), (b,) in pairs])


class Centred:
    """The state as an exact middle and a turned box about it, by Lohner's method.

    A box along the axes grows in each step that turns it. This one turns with the flow. An event
    comes at another moment for each state of the box, so it turns and shears the box too.
    """

    def __init__(self, size: int) -> None:
        self.middle, self.spread = arb_mat(size, 1), arb_mat(size, 1)
        self.frame = arb_mat(size, size)

    def set(self, row: int, value: Any) -> None:
        """Set a component to what it surely is; the ball of a value that is rounded stays."""
        self.middle[row, 0] = value
        for column in range(self.frame.ncols()):
            self.frame[row, column] = arb(0)

    def box(self) -> Any:
        """Give a box along the axes about it."""
        return self.middle + self.frame * self.spread

    def leap(self, mode: Mode, middle: Any, flow: Any, stay: Stay, at: Any) -> None:
        """Go to a new middle by a flow until a function is 0, all states then in a box."""
        digits, ctx.dps = ctx.dps, _FEW
        carried = flow * self.frame
        # By how much later a state gets there: its derivative for the state at the begin.
        value, slope = stay.derivatives[:2]
        carried -= (mode.matrix * at) * (value * carried) / (slope * at)[0, 0]
        ctx.dps = digits
        self.middle = arb_mat([[one.mid()] for (one,) in middle.tolist()])
        self.frame, inverse = self._frame(mode, carried)
        spread = (inverse * carried) * self.spread + inverse * (middle - self.middle)
        self.spread = arb_mat([[arb(0, one.abs_upper())] for (one,) in spread.tolist()])
        for row, sides in enumerate(carried.tolist()):
            if all(one == 0 for one in sides) and middle[row, 0] == self.middle[row, 0]:
                self.set(row, self.middle[row, 0])  # such as the speed of a knob that is held

    def _frame(self, mode: Mode, carried: Any) -> tuple[Any, Any]:
        """Give orthogonal axes along the longest sides of a box, and the inverse of them."""
        sizes = [one.rad() for (one,) in self.spread.tolist()]
        longest = max([*sizes, arb(2) ** -4000])
        sides = np.array(
            [
                [
                    float(one.mid() / unit * size / longest)
                    for one, size in zip(row, sizes, strict=True)
                ]
                for row, unit in zip(carried.tolist(), mode.units, strict=True)
            ]
        )
        order = np.argsort(-np.linalg.norm(sides, axis=0), kind="stable")
        axes, _ = np.linalg.qr(sides[:, order])
        frame = arb_mat((axes * np.array(mode.units)[:, None]).tolist())
        return frame, frame.inv()


class Mode:
    """The equations between events, and the longest piece of time to look at: 2^-level s."""

    def __init__(self, matrix: Any, stays: list[tuple[str, Row]]) -> None:
        self.matrix = matrix
        self.stays = [Stay(name, row, matrix) for name, row in stays]
        middles = np.array([[float(one.mid()) for one in row] for row in matrix.tolist()])
        balanced, (scale, _) = matrix_balance(middles, permute=False, separate=True)
        rate = float(np.abs(np.linalg.eigvals(balanced)).max())
        self.level = max(12, math.ceil(math.log2(rate + 1.0)) - 2)
        # Powers of two: how the state is measured where one number must bound it.
        self.units = scale.tolist()
        column = arb_mat([[arb(one)] for one in self.units])
        sizes = arb_mat([[abs(one) for one in row] for row in matrix.tolist()]) * column
        self.size = float(self.norm(sizes)) * 1.01

    def within(self, width: Any, depth: int) -> Any:
        """Give the flow of all times in a piece. A sign asks for few digits until it is small."""
        digits, ctx.dps = ctx.dps, min(ctx.dps, 30 + 5 * depth)
        try:
            return (self.matrix * since_before(width)).exp()
        finally:
            ctx.dps = digits

    def flow(self, time_s: Any) -> Any:
        """Give the flow over a time, with a few digits, to carry an error on with."""
        digits, ctx.dps = ctx.dps, _FEW
        try:
            return (self.matrix * time_s).exp()
        finally:
            ctx.dps = digits

    def norm(self, column: Any) -> Any:
        """Give the largest component, in units."""
        rows = zip(column.tolist(), self.units, strict=True)
        return max((abs(one) / unit).upper() for (one,), unit in rows)

    def series(self, state: Any, time_s: Any) -> tuple[list[Any], Any]:
        """Give a Taylor series of the state after a time, and balls of what is left out."""
        step, size = self.matrix * time_s, self.size * float(abs(time_s).upper())
        number, tiny = max(len(self.units), math.ceil(2.0 * size)), -math.log(10.0) * (ctx.dps + 5)
        while number * math.log(size + 1e-300) - math.lgamma(number + 1) > tiny:
            number += 1
        terms = [state]
        for one in range(1, number + 1):
            terms.append(step * terms[-1] / one)
        # Each term from here on is at most half of the one before: together at most the last one.
        rest = self.norm(terms[-1])
        # A component whose first derivatives are all 0 does not move.
        early = [term.tolist() for term in terms[1 : len(self.units) + 1]]
        moves = [
            not all(term[row][0].is_zero() for term in early) for row in range(len(self.units))
        ]
        left = [[arb(0, rest * unit * one)] for one, unit in zip(moves, self.units, strict=True)]
        return terms, arb_mat(left)

    def moved(self, state: Any, time_s: Any) -> Any:
        """Give the state after a time."""
        terms, left = self.series(state, time_s)
        return sum(terms, left)
