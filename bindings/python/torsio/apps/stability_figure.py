"""The picture of `torsio stability`; needs the extra `plot`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from torsio.common.drawing import BLACK, BLUE, ORANGE, TEXT, drawn
from torsio.common.whole_file import beside
from torsio.printed.told import StableStiffness
from torsio.stability import LIMITS, Array, StabilityMap

__all__ = ["save_figure"]


def save_figure(
    found: StabilityMap,
    predicted: tuple[Array, Array],
    told: StableStiffness,
    title: str,
    path: Path,
) -> None:
    """Draw where the knob came to rest and where it swung, and the boundary that theory gives."""
    damping, stiffness = np.meshgrid(
        1e3 * found.damping_nm_s_per_rad, found.stiffness_nm_per_rad, indexing="xy"
    )
    rests = found.is_stable
    with drawn((8.5, 6.2), dpi=120, layout="constrained") as figure:
        axes = figure.subplots()
        axes.plot(damping[rests], stiffness[rests], "o", color=BLUE, ms=4, label="comes to rest")
        axes.plot(
            damping[~rests], stiffness[~rests], "x", color=ORANGE, ms=5, mew=1.4,
            label="swings for ever",
        )  # fmt: skip
        axes.plot(1e3 * predicted[0], predicted[1], color=BLACK, label="predicted boundary")
        axes.plot(
            0.0, told.stiffness_nm_per_rad, "D", color=BLACK, ms=8, clip_on=False, zorder=5,
            label=f"stable_stiffness(): {told.stiffness_nm_per_rad:.3g} N m/rad, "
            f"{LIMITS[told.limited_by]}",
        )  # fmt: skip
        axes.set_yscale("log")
        axes.set_ylim(stiffness.min() / 1.15, stiffness.max() * 1.15)
        span = float(damping.max()) or 1.0
        axes.set_xlim(-0.03 * span, 1.05 * span)
        axes.set_xlabel("the scene's damping, mN m s/rad")
        axes.set_ylabel("the scene's stiffness, N m/rad")
        axes.set_title(title)
        figure.legend(loc="outside lower center", ncols=2, frameon=False, labelcolor=TEXT)
        with beside(path) as part:
            figure.savefig(part)
