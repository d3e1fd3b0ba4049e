"""The paper's scenarios with the boards' binaries, beside the emulated device, as JSON lines.

``./dev bench binary`` runs each board's real firmware in its emulated chip, coupled to the plant
and its electrics, and the emulated device with the same plant. Both get the same reports. A line
tells for one board, one scenario and one of the two what the paper's study measures:

- ``bounce``: a knob that turns at 18 rad/s is caught by a spring; how often it goes through the
  middle in a second, and the oscillation that is left;
- ``push``: into a wall and out in 2.2 s; errors of the felt torque, and the gap;
- ``cut``: the string of a weight is cut; when the knob is out of the wall.

A line with ``apart`` has the difference of what a hand feels of the two, root of the mean square
and the most; and the same for two emulated devices whose current sensors have other noise, to
compare with.

The first line of a board tells what a tick costs inside one wall: instructions of its interrupt,
the time from the encoder to the PWM that the board itself tells, the share of the control period
that this is, and the share of all time that the control interrupt takes. Instructions and time are
the most that was seen. An RP2350's times are estimates; see docs/results.md.

Arguments are names of boards. It takes some minutes for each.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from tests.board import felt, pico
from tests.board.pico import MODELS, choose
from torsio.telemetry import Record
from torsio_studies.paper import runs

Measure = Callable[[felt.Columns], dict[str, Any]]
WALL, CUT_WALL = runs.per_degree(30.0), runs.per_degree(25.0)


def _bounced(rows: felt.Columns) -> dict[str, Any]:
    second = rows["time_s"] <= 1.0
    columns = {name: rows[name][second] for name in ("angle_rad", "time_s", "motor_torque_nm")}
    found = runs.count_bounces(_record(columns))
    return {"crossings": found.crossings, "oscillation_rad": _short(found.oscillation_rad)}


def _pushed(rows: felt.Columns) -> dict[str, Any]:
    push = runs.measure_push(_record(rows), WALL)
    names = ("peak_torque_nm", "tracking_rms_in", "tracking_rms_out", "torque_gap_nm")
    return {name: _short(getattr(push, name)) for name in (*names, "sensor_rms_nm")}


def _was_cut(rows: felt.Columns) -> dict[str, Any]:
    cut = runs.measure_cut(_record(rows), CUT_WALL, felt.plant_of("pico"))
    return {
        "outcome": cut.outcome,
        "exit_s": None if cut.exit_s is None else _short(cut.exit_s),
        "depth_at_cut_rad": _short(cut.depth_at_cut_rad),
        "final_depth_rad": _short(cut.final_depth_rad),
    }


def _record(columns: felt.Columns) -> Record:
    """Give the study's record: rows whose columns have names."""
    rows = np.empty(len(columns["time_s"]), [(name, float) for name in columns])
    for name, column in columns.items():
        rows[name] = column
    return cast(Record, rows)


def _short(value: float) -> float:
    return float(f"{value:.3g}")


@dataclass(frozen=True)
class Scenario:
    """A run: actions, law and measured figures."""

    name: str
    law: str
    run: Callable[[felt.Bench], felt.Columns]
    measure: Measure
    what: dict[str, Any]


SCENARIOS = (
    Scenario("push", "paper", lambda b: felt.push(b, WALL), _pushed, {"wall_mnm_per_deg": 30.0}),
    Scenario(
        "bounce", "paper", lambda b: felt.bounce(b, 4.0), _bounced, {"spring_nm_per_rad": 4.0}
    ),
    Scenario("cut", "paper", lambda b: felt.cut(b, CUT_WALL), _was_cut, {"wall_mnm_per_deg": 25.0}),
)


EMULATED, NOISE, BINARY = "emulated device", "with other noise", "binary"


def run(one: Scenario) -> dict[str, felt.Columns]:
    """Run a scenario with the chosen board's binary, and with two emulated devices like it."""
    params = felt.plant_of(pico.chosen.name)
    found = {}
    for kind, place in (
        (EMULATED, felt.twin(params)),
        (NOISE, felt.twin(params, seed=2)),
        (BINARY, felt.binary(params)),
    ):
        with place as bench:
            felt.prepare(bench, law=one.law)
            found[kind] = one.run(bench)
    return found


def apart_nm(found: dict[str, felt.Columns], kind: str) -> list[float]:
    """How far one of them is from the emulated device: root of the mean square, and the most."""
    return [_short(nm) for nm in felt.difference_nm(found[kind], found[EMULATED])]


def _tell(board: str, **line: Any) -> None:
    print(json.dumps({"board": board, **line}), flush=True)


def main(boards: list[str]) -> None:
    """Print the lines of each board."""
    for board in boards or MODELS:
        choose(board)
        with felt.binary(felt.plant_of(board)) as bench:
            felt.prepare(bench)
            cost = felt.tick_cost(bench)
        _tell(
            board,
            scenario="tick",
            instructions=cost.instructions,
            tick_time_ns=cost.tick_time_ns,
            tick_share=_short(cost.tick_time_ns / MODELS[board].tick_ns),
            interrupt_share=_short(cost.interrupt_share),
        )
        for one in SCENARIOS:
            known = {"scenario": one.name, "law": one.law, **one.what}
            found = run(one)
            for kind, rows in found.items():
                _tell(board, **known, of=kind, **one.measure(rows))
            apart = {f"{kind.split()[-1]}_nm": apart_nm(found, kind) for kind in (NOISE, BINARY)}
            _tell(board, **known, apart=apart)


if __name__ == "__main__":
    main(sys.argv[1:])
