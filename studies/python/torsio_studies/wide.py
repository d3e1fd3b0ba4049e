"""The device's controller in 64-bit floating point: what the 32 bits of the device cost."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from torsio.closed_loop import REPLAY_DTYPE, LoopOptions, reports
from torsio.telemetry import Record
from torsio_studies import _studies


def replay(options: LoopOptions, counts: npt.ArrayLike) -> Record:
    """Do what `torsio.closed_loop.replay` does, in the same sources built with 64 bits."""
    rows = _studies.replay_wide(
        reports(options),
        control_period_ns=options.control_period_ns,
        first_tick=options.first_tick,
        counts=np.ascontiguousarray(counts, dtype=np.uint32),
    )
    return rows.view(REPLAY_DTYPE)
