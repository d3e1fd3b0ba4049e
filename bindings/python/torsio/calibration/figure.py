"""Pictures of a calibration's fits and of what they leave; needs the extra `plot`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from torsio.calibration.procedure import Calibration
from torsio.drawing import BLUE, GREY, ORANGE, TEXT, drawn
from torsio.whole_file import beside

__all__ = ["save_figure"]

# More points than this only make the picture slow.
_MOST_POINTS = 6000


def save_figure(calibration: Calibration, path: Path) -> None:
    """Draw each step's data with its model above, and the residuals below, as PNG."""
    fits = calibration.fits
    rows = (len(fits) + 1) // 2
    with drawn((14, 5.2 * rows + 0.8), dpi=110) as figure:
        heights = [part for _ in range(rows) for part in (3.0, 1.1, 0.9)]
        grid = figure.add_gridspec(
            3 * rows, 2, height_ratios=heights, hspace=0.12, wspace=0.2,
            left=0.07, right=0.985, top=1 - 0.9 / (5.2 * rows + 0.8), bottom=0.0,
        )  # fmt: skip
        serial = calibration.conditions["serial"]
        figure.suptitle(
            f"Calibration of {serial}: {calibration.seconds:.0f} s of the knob's time",
            x=0.07, ha="left", fontsize=16, fontweight="bold",
        )  # fmt: skip
        for number, fit in enumerate(fits):
            row, column = 3 * (number // 2), number % 2
            upper = figure.add_subplot(grid[row, column])
            lower = figure.add_subplot(grid[row + 1, column], sharex=upper)
            thin = max(len(fit.x) // _MOST_POINTS, 1)
            x, measured, fitted = fit.x[::thin], fit.measured[::thin], fit.fitted[::thin]
            unit = fit.y_label.rpartition(", ")[2]
            upper.plot(x, measured, ".", color=GREY, markersize=3, label="measured")
            in_time = bool(np.all(np.diff(x) >= 0))
            upper.plot(
                x, fitted, "-" if in_time else ".", color=BLUE, linewidth=1.2, markersize=2,
                label="model",
            )  # fmt: skip
            upper.set_title(fit.title)
            upper.set_ylabel(fit.y_label)
            upper.tick_params(labelbottom=False)
            upper.legend(frameon=False, loc="best", markerscale=3)
            lower.plot(x, measured - fitted, ".", color=ORANGE, markersize=2)
            lower.set_ylabel(f"left, {unit}")
            lower.set_xlabel(fit.x_label)
            lower.text(
                0.99, 0.95, f"RMS {fit.residual_rms:.2g} {unit}", transform=lower.transAxes,
                ha="right", va="top", fontsize=9, color=TEXT,
            )  # fmt: skip
        with beside(path) as part:
            figure.savefig(part)
