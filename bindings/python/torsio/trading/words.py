"""A trade in words, and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from torsio import perception
from torsio.trading.found import BoardShare, Row, Trade
from torsio.trading.runs import HIGHEST_HZ, RATES_HZ

__all__ = ["as_dict", "lines"]


def lines(found: Trade) -> Iterator[str]:
    """Say what matters: each part, rate and change, the proposal, boards and extremes."""
    reference = found.rows[0]
    alone = found.alone
    effects = ", ".join(type(effect).__name__ for effect in found.scene) or "Free air"
    yield f"{effects}, played by a knob with {', '.join(alone) or 'no part to leave out'}."
    yield f"All parts at {HIGHEST_HZ // 1000} kHz cost {_cost(reference)}: the reference."
    if found.swings:
        yield "Thrown into the scene, even this knob swings."
    yield from (_of_part(name, row, reference, found) for name, row in alone.items())
    yield from _of_changes(found)
    yield from _proposal(found)
    yield from map(_of_board, found.boards)
    yield f"To play the scene takes {found.scene_bytes} bytes on the wire."
    yield from (_of_extreme(one) for one in found.extremes)


def _of_changes(found: Trade) -> Iterator[str]:
    """Say what another rate, encoder, law or noise changes, and another place of the run."""
    for rate in RATES_HZ[1:]:
        row = found.row(rate_hz=rate)
        yield f"{rate // 1000} kHz {_changes(row)} and {_saves(row, found.rows[0])}."
    for row in found.rows:
        if row.variant.counts_per_rev or row.variant.law:
            yield _of_change(row)
        if row.variant.other_noise:
            yield f"Other noise {_changes(row)}: less is chance."
    yield from (_elsewhere(row) for row in found.rows if row.name != row.variant.name)


def _of_change(row: Row) -> str:
    ticks = ", ".join(f"{of.instructions:,} on `{of.board}`" for of in row.boards)
    more = f"; a tick is {ticks}" if row.variant.law else ""
    return f"{row.name[0].upper()}{row.name[1:]} {_changes(row)}{more}."


def _elsewhere(row: Row) -> str:
    """Say what a run in the batch, or of the whole device, changes and costs."""
    wire = ""
    if row.wire_bytes_per_s is not None:
        wire = f" and {row.wire_bytes_per_s / 1e3:.0f} kB/s on the wire"
    return f"As {row.name}: {_changes(row)}, costs {_cost(row)}{wire}."


def _of_board(board: BoardShare) -> str:
    fits = "" if board.share < 0.95 else ": too much, the board would raise `overrun`"
    return (
        f"On `{board.board}` a tick is {board.instructions:,} instructions and "
        f"{100 * board.share:.0f} % of its period{fits}."
    )


def _proposal(found: Trade) -> Iterator[str]:
    row = found.proposal
    yield f"Proposed: {row.name}. It {_changes(row)} and {_saves(row, found.rows[0])}."
    verified = f"{perception.text(found.verified.jnds)} on other visits, and "
    verified += f"{perception.text(found.on_device.difference.jnds)} on the whole device"
    if found.holds:
        yield f"Verified: {verified}. {perception.text(found.wanted_jnds)} was wanted."
    else:
        yield f"It falls short by {perception.text(found.short_by_jnds)}: {verified}."
        least = max(
            row.difference.jnds
            for row in found.rows
            if row.variant.other_noise or row.name == f"whole device, {found.rows[0].name}"
        )
        if least > found.wanted_jnds:
            noise = perception.text(least)
            yield f"Even with all parts two visits differ by {noise}."


def _of_part(name: str, row: Row, reference: Row, found: Trade) -> str:
    share = 100 * (1.0 - row.cpu_s / reference.cpu_s)
    costs = f"costs {share:.0f} %" if share >= 1.0 else "costs nothing"
    if name in found.proposal.variant.lacks:
        verdict = "leave it out"
    elif row.difference.jnds > found.wanted_jnds or share < 1.0 or not found.proposal.variant.lacks:
        verdict = "keep it"
    else:
        verdict = "keep it beside what is left out"
    what = perception.text(row.difference.jnds)
    return f"{name[0].upper()}{name[1:]} changes what is felt by {what} and {costs}: {verdict}."


def _changes(row: Row) -> str:
    felt, missed = perception.text(row.difference.jnds), row.difference.missed
    if missed:
        edges = "an edge once" if missed == 1 else f"edges {missed} times"
        return f"changes what is felt by {felt}, crosses {edges} more or less"
    contact_ms = float(f"{round(1e3 * row.difference.contact_s, 3):.2g}")
    return f"changes what is felt by {felt}, contacts by {contact_ms:g} ms"


def _cost(row: Row) -> str:
    return (
        f"{row.ns_per_tick:,.0f} ns a tick, {row.knobs_in_real_time:,.0f} knobs in real time on a "
        "core"
    )


def _saves(row: Row, reference: Row) -> str:
    share = 100 * (1.0 - row.cpu_s / reference.cpu_s)
    return f"saves {share:.0f} %" if share >= 1.0 else "saves nothing"


def _of_extreme(one: Any) -> str:
    true = "is true nowhere on this way"
    if one.true_to is not None:
        beyond = "" if one.is_bounded else f", the last of {len(one.tried)} that were tried"
        true = f"stays true to {one.true_to:g} {one.unit}{beyond}"
    swings = "" if one.swings_at is None else f"; swings at {one.swings_at:g} {one.unit}"
    breaks = ""
    if one.breaks:
        breaks = f"; first, at {one.breaks_at:g} {one.unit}, {one.breaks}"
    return f"{one.quantity[0].upper()}{one.quantity[1:]} {true}{swings}{breaks}."


def as_dict(found: Trade) -> dict[str, Any]:
    """Give all of it as JSON has it."""
    return {
        "wanted_jnds": found.wanted_jnds,
        "holds": found.holds,
        "short_by_jnds": found.short_by_jnds,
        "swings": found.swings,
        "proposal": _row(found.proposal),
        "options": found.paste(),
        "verified": found.verified.as_dict(),
        "on_device": _row(found.on_device),
        "rows": [_row(row) for row in found.rows],
        "boards": [asdict(one) for one in found.boards],
        "scene_bytes": found.scene_bytes,
        "extremes": [asdict(one) for one in found.extremes],
    }


def _row(row: Row) -> dict[str, Any]:
    return {
        "name": row.name,
        "left_out": list(row.variant.left_out),
        "rate_hz": row.variant.rate_hz,
        **row.difference.as_dict(),
        "boards": [asdict(one) for one in row.boards],
        "ns_per_tick": row.ns_per_tick,
        "knobs_in_real_time": row.knobs_in_real_time,
        "wire_bytes_per_s": row.wire_bytes_per_s,
        "is_on_front": row.is_on_front,
    }
