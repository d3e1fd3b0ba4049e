"""Effects of games on a knob: at one moment, and how often they change."""

from __future__ import annotations

from dataclasses import dataclass

from torsio.common import checks
from torsio.knob import Knob, need_knob
from torsio.printed.told import GameEffect, GameStatus

__all__ = ["GameMonitor", "GameReading"]

_COUNTS = 1 << 32  # the device's counters wrap


@dataclass(frozen=True, repr=False)
class GameReading(checks.ShortRepr):
    """Effects of games at one moment.

    Attributes
    ----------
    status
        Owner of the actuator, and values common to all effects.
    effects
        In the order of their blocks.
    updates_per_s
        Reports of all games in a second, since the reading before.
    effect_updates_per_s
        The same for each effect.
    clipped_share
        Share of the time since the last reading in which effects asked for more than their joint
        limit; 0 to 1.
    asked_most_percent
        The most that they asked for since the monitor's first reading, in % of their joint limit.
    """

    status: GameStatus
    effects: tuple[GameEffect, ...]
    updates_per_s: float
    effect_updates_per_s: tuple[float, ...]
    clipped_share: float
    asked_most_percent: int


class GameMonitor:
    """Watches games on a knob. It takes nothing from them: the actuator stays theirs."""

    def __init__(self, knob: Knob) -> None:
        need_knob(knob)
        self._knob = knob
        self._last: GameStatus | None = None
        self._counts: dict[int, int] = {}
        self._asked_most_percent = 0

    def read(self) -> GameReading:
        """Ask the knob. The first reading has no rates yet, they are 0."""
        effects = self._knob.game_effects()
        status = self._knob.game_status()
        last = self._last or status
        elapsed_s = status.time_s - last.time_s

        def rate(now: int, before: int) -> float:
            return (now - before) % _COUNTS / elapsed_s if elapsed_s > 0 and now >= before else 0.0

        rates = tuple(rate(e.updates, self._counts.get(e.block, e.updates)) for e in effects)
        clipped_ticks_per_s = rate(status.clipped_ticks, last.clipped_ticks)
        self._asked_most_percent = max(self._asked_most_percent, status.asked_percent)
        reading = GameReading(
            status,
            effects,
            rate(status.updates, last.updates),
            rates,
            min(1.0, clipped_ticks_per_s / self._knob.info.control_rate_hz),
            self._asked_most_percent,
        )
        self._last = status
        self._counts = {effect.block: effect.updates for effect in effects}
        return reading
