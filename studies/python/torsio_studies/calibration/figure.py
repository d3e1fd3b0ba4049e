"""Pictures of the study `calibration`."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from torsio.common.drawing import BLUE, GREEN, GREY, ORANGE, headline
from torsio_studies.common import Study

Array = npt.NDArray[np.float64]


def draw(
    study: Study,
    name: str,
    hidden: str,
    table: dict[str, Array],
    coverage: list[dict[str, Any]],
) -> None:
    """Draw the coverage of every quantity, and how far each knob's values were off.

    `hidden` says in words what the routine does not know of them.
    """
    rows = [row for row in coverage if row["knobs"]]
    with study.figure(name, size=(13.5, 0.42 * len(rows) + 3.0)) as picture:
        headline(
            picture,
            "What a knob says of itself, and what it really is",
            f"{len(table['complete'])} emulated knobs with {hidden} measured themselves. "
            "Left: "
            "how many of the stated 95 % intervals hold the truth; the band is 90 to 98 %. "
            "Right: how "
            "far each value is off, in its own stated standard uncertainties.",
        )
        inch = 1.0 / picture.get_size_inches()[1]
        grid = picture.add_gridspec(
            1, 2, left=0.22, right=0.98, bottom=0.6 * inch, top=1 - 1.25 * inch, wspace=0.06
        )
        left, right = picture.add_subplot(grid[0]), picture.add_subplot(grid[1])
        places = np.arange(len(rows))[::-1]
        shares = np.array([100 * row["coverage"] for row in rows])
        left.axvspan(90, 98, color="#e5f2ea", zorder=0)
        inside = (shares >= 90) & (shares <= 98)
        left.barh(places, shares, color=np.where(inside, GREEN, ORANGE), height=0.6)
        left.set_xlim(50, 100)
        left.set_yticks(places, [row["quantity"] for row in rows])
        left.set_xlabel("intervals that hold the truth, %")
        for place, row in zip(places, rows, strict=True):
            of = row["quantity"]
            score = (table[f"{of}_value"] - table[f"{of}_truth"]) / table[f"{of}_sigma"]
            score = np.clip(score[np.isfinite(score)], -6, 6)
            spread = np.random.default_rng(0).uniform(-0.25, 0.25, len(score))
            right.plot(score, place + spread, ".", color=BLUE, markersize=3)
        for edge in (-1.96, 1.96):
            right.axvline(edge, color=GREY, linewidth=1)
        right.set_yticks(places, [])
        right.set_ylim(left.get_ylim())
        right.set_xlim(-6.2, 6.2)
        right.set_xlabel("error in stated standard uncertainties (clipped at 6)")
