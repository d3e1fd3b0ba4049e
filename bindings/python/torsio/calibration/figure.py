"""Pictures of a calibration's fits and their residuals; needs the extra `plot`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from torsio.calibration.quantity import Fit
from torsio.common.drawing import BLUE, ORANGE, TEXT, drawn

__all__ = ["draw", "plot_fits", "size_of"]

# More points than this only make the picture slow.
_MOST_POINTS = 6000
_MEASURED = "#b8b8b8"
_FEW_POINTS = 200  # are drawn larger


def plot_fits(fits: Sequence[Fit], title: str) -> Figure:
    """Draw each step's data with its model above, and the residuals below."""
    with drawn(size_of(fits), dpi=110) as figure:
        draw(figure, fits, title)
    return figure


def size_of(fits: Sequence[Fit]) -> tuple[float, float]:
    """Give width and height of the figure, in inches."""
    rows = (len(fits) + 1) // 2
    return 14.0, 5.2 * rows + 1.2


def draw(figure: Figure, fits: Sequence[Fit], title: str) -> None:
    """Draw each step's data with its model above, and the residuals below."""
    rows = (len(fits) + 1) // 2
    inches = size_of(fits)[1]
    heights = [part for _ in range(rows) for part in (3.0, 1.1, 0.9)]
    grid = figure.add_gridspec(
        3 * rows, 2, height_ratios=heights, hspace=0.12, wspace=0.2,
        left=0.085, right=0.985, top=1 - 1.1 / inches, bottom=0.0,
    )  # fmt: skip
    figure.suptitle(
        title, x=0.085, y=1 - 0.3 / inches, va="top", ha="left", fontsize=16, fontweight="bold",
    )  # fmt: skip
    for number, fit in enumerate(fits):
        row, column = 3 * (number // 2), number % 2
        upper = figure.add_subplot(grid[row, column])
        lower = figure.add_subplot(grid[row + 1, column], sharex=upper)
        thin = max(len(fit.x) // _MOST_POINTS, 1)
        x, measured, fitted = fit.x[::thin], fit.measured[::thin], fit.fitted[::thin]
        unit = fit.y_label.rpartition(", ")[2]
        # The model lies on top, so what is measured must be wider.
        size = 2.5 if len(x) <= _FEW_POINTS else 1.0
        upper.plot(x, measured, "o", color=_MEASURED, mew=0, ms=4.5 * size, label="measured")
        in_time = bool(np.all(np.diff(x) >= 0))
        upper.plot(
            x, fitted, "-" if in_time else "o", color=BLUE, mew=0, linewidth=1.0,
            ms=2.0 * size, label="model",
        )  # fmt: skip
        upper.set_title(fit.title)
        upper.set_ylabel(fit.y_label)
        upper.tick_params(labelbottom=False)
        lower.plot(x, measured - fitted, ".", color=ORANGE, markersize=2)
        lower.set_ylabel(f"residual, {unit}")
        lower.set_xlabel(fit.x_label)
        lower.text(
            0.99, 0.95, f"RMS {fit.residual_rms:.2g} {unit}", transform=lower.transAxes,
            ha="right", va="top", fontsize=9, color=TEXT,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5},
        )  # fmt: skip
    first = figure.axes[0].get_legend_handles_labels()
    figure.legend(
        *first, loc="upper right", bbox_to_anchor=(0.985, 1 - 0.2 / inches), ncols=2,
        frameon=False, markerscale=2,
    )  # fmt: skip
