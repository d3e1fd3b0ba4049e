"""The results of a trade: its rows, its proposal, and the boards' costs."""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from torsio.common import checks
from torsio.printed.board_costs import BOARDS
from torsio.printed.config import ControlConfig
from torsio.printed.emulator_options import EmulatorOptions
from torsio.printed.plant import Cogging
from torsio.printed.scenes import Effect, Scene
from torsio.trading.extremes import Extreme
from torsio.trading.runs import HIGHEST_HZ, Variant
from torsio.trading.visits import Difference, effects_of

__all__ = ["BoardShare", "Row", "Trade", "board_shares", "pasteable"]


@dataclass(frozen=True)
class BoardShare:
    """Cost of the scene's control tick on a board, from counted instructions.

    Attributes
    ----------
    instructions
        Instructions of the device's code.
    time_ns
        Time of the whole control interrupt.
    share
        Share of the period; from 0.95 on the board raises the fault `overrun`.
    """

    board: str
    instructions: int
    time_ns: float
    share: float


@dataclass(frozen=True, repr=False)
class Row(checks.ShortRepr):
    """Changes of a variant, and their cost.

    Attributes
    ----------
    difference
        From all parts at the highest rate, the worst of the visits.
    cpu_s
        CPU time of one core for a second of the knob.
    boards
        Cost of a tick on each board, if its period is that of `variant`.
    wire_bytes_per_s
        Both ways, of the whole device; None: nothing is sent.
    is_on_front
        No variant that may be proposed is both cheaper and truer.
    """

    name: str
    variant: Variant
    difference: Difference
    cpu_s: float
    boards: tuple[BoardShare, ...]
    wire_bytes_per_s: float | None = None
    is_on_front: bool = False

    @property
    def ns_per_tick(self) -> float:
        """CPU time of a control tick."""
        return 1e9 * self.cpu_s / self.variant.rate_hz

    @property
    def knobs_in_real_time(self) -> float:
        """How many knobs one core simulates in real time."""
        return 1.0 / self.cpu_s


@dataclass(frozen=True, repr=False)
class Trade(checks.ShortRepr):
    """Needs of a scene.

    Attributes
    ----------
    wanted_jnds
        By how much the torque that is felt may differ at most.
    rows
        All that was tried; the reference first.
    scene
        The effects that were traded.
    swings
        The knob with all parts at the highest rate swings, if thrown into the scene.
    proposal
        The cheapest row that stays within what was wanted on the visits that it was chosen by, and
        swings if the scene does. If it failed on further ones, they helped to choose the next.
    options
        The emulated knob that it is.
    verified
        By how much the proposal differs on visits that were not used to choose.
    on_device
        The same of the whole device, which is opened with `options`, on one of these visits.
    boards
        Cost of a tick on each board.
    scene_bytes
        On the wire, to play the scene.
    extremes
        How far the scene may be stretched; empty if that was not asked.
    """

    wanted_jnds: float
    scene: tuple[Effect, ...]
    swings: bool
    rows: tuple[Row, ...]
    proposal: Row
    options: EmulatorOptions
    verified: Difference
    on_device: Row
    boards: tuple[BoardShare, ...]
    scene_bytes: int
    extremes: tuple[Extreme, ...]

    @property
    def short_by_jnds(self) -> float:
        """By how much the proposal is worse than wanted where it was verified; 0: it is not."""
        worst = max(self.verified.jnds, self.on_device.difference.jnds)
        return max(0.0, worst - self.wanted_jnds)

    @property
    def holds(self) -> bool:
        """The proposal stays within what was wanted on every visit."""
        return self.short_by_jnds == 0.0

    @property
    def alone(self) -> dict[str, Row]:
        """Rows of the highest rate without one part, by this part."""
        return {
            row.variant.left_out[0]: row
            for row in self.rows
            if row.name == row.variant.name
            and len(row.variant.left_out) == 1
            and row.variant.rate_hz == HIGHEST_HZ
        }

    def row(self, **of: Any) -> Row:
        """Give the row of ``Variant(**of)``: `left_out`, `rate_hz`, `counts_per_rev`, `law`.

        Raises
        ------
        KeyError
            If that was not tried.
        """
        wanted = Variant(**of)
        for row in self.rows:
            if row.variant == wanted:
                return row
        raise KeyError(wanted.name)

    def paste(self) -> str:
        """Give the call that makes `options`."""
        return pasteable(self.options)


def _counted(name: str, costs: dict[str, int]) -> str:
    return name if name in costs else max(costs, key=costs.__getitem__)


def board_shares(
    scene: Scene | None, control: ControlConfig, period_ns: float | None = None
) -> tuple[BoardShare, ...]:
    """Give what a tick costs on each board while every effect of the scene plays.

    Without a period the board's own one counts. A law or effect that nobody has counted costs as
    much as the most costly one.
    """
    effects = effects_of(scene)
    shares = []
    for board, cost in BOARDS.items():
        law = _counted(control.law, cost.laws)
        more = sum(cost.effects[_counted(type(of).__name__, cost.effects)] for of in effects)
        more += cost.law if effects else 0
        if effects or law == "calibrated":  # which works in free air too
            more += cost.laws[law]
        time_ns = cost.empty_ns + more * cost.instruction_ns
        share = time_ns / (period_ns or cost.period_ns)
        shares.append(BoardShare(board, cost.empty + more, time_ns, share))
    return tuple(shares)


def pasteable(value: Any, indent: str = "") -> str:
    """Write a value as Python makes it, without defaults."""
    if not is_dataclass(value) or isinstance(value, type):
        return repr(value)
    inner = indent + "    "
    given = [
        f"{inner}{of.name}={pasteable(getattr(value, of.name), inner)},\n"
        for of in fields(value)
        if of.init and getattr(value, of.name) != of.default
    ]
    if isinstance(value, Cogging):
        amplitude = max(value.torque_nm)
        sine = {"periods_per_rev": value.periods_per_rev, "amplitude_nm": amplitude}
        if value == Cogging.sine(**sine):  # type: ignore[arg-type]
            return f"torsio.Cogging.sine({', '.join(f'{k}={v!r}' for k, v in sine.items())})"
    body = f"\n{''.join(given)}{indent}" if given else ""
    return f"torsio.{type(value).__name__}({body})"
