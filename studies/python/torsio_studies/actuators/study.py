"""`torsio study actuators`: every rival actuator in the same scenes."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict

from rich.console import Console
from rich.table import Table

from torsio import perception
from torsio.common.screen import table
from torsio_studies import _studies
from torsio_studies.actuators import figure
from torsio_studies.actuators.trials import (
    ACTUATORS,
    COUNTS_PER_REV,
    FINE,
    FINE_KEYS,
    PERIOD_NS,
    STIFFEST_NM_PER_RAD,
    WALLS_MNM_PER_DEG,
    Actuator,
    Measures,
    exit_text,
    measure,
    step_error,
)
from torsio_studies.common import Results, Study


def run(study: Study) -> Results:
    """Run the study."""
    coarse_steps = 12 if study.quick else 34
    work: list[tuple[Actuator, dict[str, int]]] = [(actuator, {}) for actuator in ACTUATORS]
    work += [(actuator, FINE) for actuator in ACTUATORS if actuator.key in FINE_KEYS]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        measured = list(
            study.track(
                pool.map(lambda one: measure(one[0], coarse_steps=coarse_steps, **one[1]), work),
                "thirteen actuators in the same scenes",
                total=len(work),
            )
        )
    rows, fine_rows = measured[: len(ACTUATORS)], measured[len(ACTUATORS) :]
    figure.draw(study, rows)
    return {
        "rows": [asdict(row) | {"jnds": jnds(row)} for row in rows],
        "fine_rows": [asdict(row) | {"jnds": jnds(row)} for row in fine_rows],
        "walls_mnm_per_deg": list(WALLS_MNM_PER_DEG),
        "stiffest_tried_nm_per_rad": STIFFEST_NM_PER_RAD,
        "parts": _studies.actuator_parts(),
        "step_error": step_error(),
    }


def jnds(row: Measures) -> dict[str, float]:
    """Give the errors in the middle wall, and the drag, in just noticeable differences."""
    wall = row.walls[1]
    return perception.wall_jnds(
        peak_nm=wall.peak_nm,
        tracking_in=wall.tracking_in,
        tracking_out=wall.tracking_out,
        torque_gap_nm=wall.torque_gap_nm,
    ) | {"drag": perception.torque_jnds(row.drag_nm)}


def show(results: Results, console: Console) -> None:
    """Print the results as tables."""
    for key, options in (("rows", {}), ("fine_rows", FINE)):
        counts = options.get("counts_per_rev", COUNTS_PER_REV)
        rate_khz = 1e6 / options.get("period_ns", PERIOD_NS)
        console.print(_table(f"{counts:,} counts, {rate_khz:.0f} kHz", results[key]))
        console.print()
    console.print("in, out, gap: a wall of 30 mN·m/deg")
    console.print(f"1 JND: {perception.MEANING}")


def _table(first: str, rows: list[Results]) -> Table:
    told = table(
        first, "in", "out", "gap\nmN·m", "gap\nJND", "leaves after\nms",
        "stable to\nN·m/rad", "drag\nmN·m", "peak\nmN·m", "motor\nheat",
        words=1,
    )  # fmt: skip
    for row in rows:
        wall = row["walls"][1]
        limit = row["stable_stiffness_nm_per_rad"]
        told.add_row(
            f"({row['figure']}) {row['title']}" if row["figure"] else row["title"],
            f"{100 * wall['tracking_in']:.1f} %",
            f"{100 * wall['tracking_out']:.1f} %",
            f"{1e3 * wall['torque_gap_nm']:.1f}",
            f"{row['jnds']['torque_gap']:.1f}",
            exit_text(row["outcome"], row["exit_time_s"], row["stuck_torque_nm"]),
            f"{limit:.1f}" if limit is not None else f">{STIFFEST_NM_PER_RAD:.0f}",
            f"{1e3 * row['drag_nm']:.1f}",
            f"{1e3 * row['peak_torque_nm']:.0f}",
            f"{100 * row['motor_heat']:.0f} %",
        )
    return told
