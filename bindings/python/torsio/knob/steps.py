"""Steps of a program's own loop, at equal distances of the device's time."""

from __future__ import annotations

from dataclasses import dataclass

from torsio import _torsio

__all__ = ["Step", "Steps"]


@dataclass(frozen=True)
class Step:
    """A step of a program's own loop.

    Attributes
    ----------
    index
        0, 1, 2 ... without a gap, also when steps were late.
    time_s
        When it was due, since the loop began.
    late_steps
        Steps left out so far, because they were overdue.
    """

    index: int
    time_s: float
    late_steps: int


class Steps:
    """An iterator without an end, made by `Knob.every`."""

    def __init__(self, steps: _torsio.Steps) -> None:
        self._steps = steps

    def __iter__(self) -> Steps:
        """Give the steps themselves."""
        return self

    def __next__(self) -> Step:
        """Wait for the next step."""
        return self.wait()

    def wait(self) -> Step:
        """Wait for the next step. Raises `Closed` and `Disconnected`."""
        return Step(*self._steps.wait())
