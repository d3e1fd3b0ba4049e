"""Results of a hidden knob: by itself, and through the electrics of a board."""

from __future__ import annotations

from typing import Final

from torsio_studies.calibration.driven import measure_driven
from torsio_studies.calibration.knobs import Batch, hidden_knob, measure

__all__ = ["DRIVEN", "evaluate_batch"]

DRIVEN: Final = "driven_"
"""With this begin the names of the columns that are of the knob with electrics."""


def evaluate_batch(batch: Batch) -> list[dict[str, float]]:
    """Calibrate the knobs of a batch."""
    rows = []
    for number in batch.designs:
        hidden = hidden_knob(number)
        driven = {f"{DRIVEN}{name}": value for name, value in measure_driven(hidden).items()}
        rows.append(measure(hidden) | driven)
    return rows
