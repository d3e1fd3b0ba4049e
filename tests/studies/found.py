"""Where the search for knobs that swing ended, once for each counter-example."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

from torsio.closed_loop import LoopOptions
from torsio_studies.falsify.cases import GAPS_RAD, SPACE, Case, batches, options_of

# Numbers of searches, and where they ended: the first values of `SPACE` in their order. Some
# searches hung more than half on detents, so a weight may exceed 1. The last one rolls still.
with Path(__file__).with_name("found.csv").open(encoding="utf-8") as file:
    next(file)
    FOUND = [(int(row[0]), tuple(map(float, row[1:]))) for row in csv.reader(file)]
*FOUND, ROLLS = FOUND


def found(number: int, values: tuple[float, ...]) -> tuple[Case, LoopOptions]:
    """The first searches moved fewer values: no gains or noise, no more effects, no hand left."""
    case = list(batches(number + 1, 16, "calibrated"))[number].designs[0]
    case = replace(
        case,
        noisy=len(values) > 29 and (case.noisy or number == 13),
        extra=case.extra if len(values) > 32 else "nothing",
        leaves=case.leaves and len(values) > 33,
        helps=case.helps and len(values) > 34,
        simple=case.simple and len(values) > 34,
        also=case.also if len(values) > 35 else "nothing",
        frame_s=case.frame_s if len(values) > 35 else 0.0,
        gap_rad=case.gap_rad if len(values) > 34 and number != 1526 else GAPS_RAD[0],
    )
    return case, options_of(case, dict(zip(SPACE, values, strict=False)))
