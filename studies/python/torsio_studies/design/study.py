"""`torsio study design`: what each choice of a designer is worth."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import numpy.typing as npt
from rich.console import Console

from torsio import perception
from torsio.common.screen import line, table
from torsio.demos.wall import PEAK_TORQUE_NM
from torsio.printed.config import Law
from torsio_studies.common import Results, Study, StudyError
from torsio_studies.design import figure
from torsio_studies.design.devices import EVALUATION, SPACE, Batch, batches, columns
from torsio_studies.design.spread import complete
from torsio_studies.design.store import Store

Array = npt.NDArray[np.float64]

WALLS_NM_PER_RAD = (1.0, 3.0, 10.0, 30.0, 100.0)
"""For which it is told how many counts they need, beside the one that is wanted."""


def run(study: Study) -> Results:
    """Run the study; what an earlier run has left in the results folder is not computed again."""
    settings = study.settings
    devices = int(settings.get("devices") or (24 if study.quick else 2000))
    law: Law = settings.get("law", "paper")
    wanted = settings.get("wall_nm_per_rad")
    walls = sorted({*WALLS_NM_PER_RAD, *([] if wanted is None else [float(wanted)])})
    counts = [counts_for_wall(one) for one in walls]
    side = 3 if study.quick else 13
    size = 4 if study.quick else 16
    if devices < 8:
        raise StudyError(f"at least 8 devices make a sample, not {devices}")
    folder = settings.get("results") or (study.out or Path("out")) / "design"
    store = Store(Path(folder), {"evaluation": EVALUATION, "law": law, "batch_size": size})
    work = list(batches(devices, side, law, size))

    workers, computed, growth = _complete(study, store, work)
    table = store.read(work)
    merged = store.merge(work, store.folder.parent / f"{store.folder.name}.parquet")
    figure.draw(study, table, side)
    sample = table["sample"]
    return {
        "rows": figure.influences(sample),
        "devices": sum(len(batch.designs) for batch in work),
        "computed_now": computed,
        "law": law,
        "workers": workers,
        "parquet": str(merged),
        "columns": columns(),
        "space": {name: asdict(span) for name, span in SPACE.items()},
        "cost_by_rate": cost_by_rate(sample),
        "cost_by_devices": cost_by_devices(growth),
        "formula_error": formula_error(sample),
        "exits": count_exits(sample),
        "jnds": jnds(sample),
        "counts_for_walls": counts,
    }


def _complete(
    study: Study, store: Store, work: Sequence[Batch]
) -> tuple[int, int, list[dict[str, float]]]:
    """Compute what is missing; give numbers of workers and devices, and the seconds' growth."""
    growth: list[dict[str, float]] = []
    begin, devices, core_s = time.perf_counter(), 0, 0.0
    with complete(study, store, work, "devices") as (workers, results):
        for rows in results:
            devices += len(rows)
            core_s += sum(row["seconds"] for row in rows)
            wall_s = time.perf_counter() - begin
            growth.append({"devices": devices, "core_seconds": core_s, "wall_seconds": wall_s})
    return workers, devices, growth


def counts_for_wall(stiffness_nm_per_rad: float) -> dict[str, float]:
    """Give the counts per turn with which one count in a wall is one JND, and half of one."""
    return {
        "stiffness_nm_per_rad": stiffness_nm_per_rad,
        "one_jnd": perception.counts_for(stiffness_nm_per_rad),
        "half_jnd": perception.counts_for(stiffness_nm_per_rad, jnds=0.5),
    }


def jnds(sample: dict[str, Array]) -> dict[str, dict[str, float]]:
    """Give each error in JNDs: its median, and the share of devices in which it is below one."""
    devices = [
        perception.wall_jnds(
            peak_nm=PEAK_TORQUE_NM, tracking_in=way_in, tracking_out=way_out, torque_gap_nm=gap
        )
        for way_in, way_out, gap in zip(
            *(sample[name].tolist() for name in ("tracking_in", "tracking_out", "torque_gap_nm")),
            strict=True,
        )
    ]
    found = {}
    for name in devices[0]:
        values = np.array([one[name] for one in devices])
        known = values[np.isfinite(values)]
        found[name] = {
            "median": float(np.median(known)) if len(known) else float("nan"),
            "unfelt": float(np.mean(values < 1.0)),
        }
    return found


def cost_by_rate(sample: dict[str, Array]) -> list[dict[str, float]]:
    """Give the seconds of one core per device, in bands of the control rate."""
    rows = []
    span = SPACE["control_rate_hz"]
    for low, high in itertools.pairwise(np.geomspace(span.low, span.high, 6)):
        rate = sample["control_rate_hz"]
        chosen = (rate >= low) & (rate <= high)
        if np.any(chosen):
            seconds = float(sample["seconds"][chosen].mean())
            rows.append(
                {
                    "rate_from_hz": float(low),
                    "rate_to_hz": float(high),
                    "devices": int(chosen.sum()),
                    "seconds_per_device": seconds,
                }
            )
    return rows


def cost_by_devices(growth: list[dict[str, float]]) -> list[dict[str, float]]:
    """Give the cores' own time and the clock's, after parts of this run's devices.

    An eighth, a quarter, half and all of them. The clock begins before the workers are started.
    """
    if not growth:
        return []
    total = growth[-1]["devices"]
    rows = []
    for share in (0.125, 0.25, 0.5, 1.0):
        entry = next(entry for entry in growth if entry["devices"] >= share * total)
        rows.append(entry | {"seconds_per_device": entry["core_seconds"] / entry["devices"]})
    return rows


def count_exits(sample: dict[str, Array]) -> dict[str, int]:
    """Count what became of the knobs after the cut of a string, by outcome."""
    inside = np.isnan(sample["exit_time_s"])
    stays = int(sample["stays"].sum())
    return {
        "leaves": int((~inside).sum()),
        "held by friction": int(inside.sum()) - stays,
        "stays": stays,
    }


def formula_error(sample: dict[str, Array]) -> float:
    """Give the median of how far the simulated critical torque is from the formula's."""
    relative = sample["critical_torque_nm"] / sample["critical_formula_nm"] - 1
    return float(np.median(np.abs(relative)))


def show(results: Results, console: Console) -> None:
    """Print what the devices cost, and what matters most."""
    line(
        console,
        f"devices: {results['devices']}, computed now: {results['computed_now']}, workers: "
        f"{results['workers']}; all are in {results['parquet']}",
    )
    cost = table("control rate, Hz", "devices", "ms of one core a device")
    for row in results["cost_by_rate"]:
        cost.add_row(
            f"{row['rate_from_hz']:.0f} to {row['rate_to_hz']:.0f}",
            f"{row['devices']}",
            f"{1e3 * row['seconds_per_device']:.0f}",
        )
    console.print(cost)
    headings = ("seconds of cores", "ms of one core a device", "seconds by the clock")
    growth = table("devices done", *headings)
    for row in results["cost_by_devices"]:
        growth.add_row(
            f"{row['devices']}",
            f"{row['core_seconds']:.1f}",
            f"{1e3 * row['seconds_per_device']:.0f}",
            f"{row['wall_seconds']:.1f}",
        )
    console.print(growth)
    for name, error in results["jnds"].items():
        console.print(
            f"{name.replace('_', ' ')}: {perception.text(error['median'])} in the median, less "
            f"than one in {100 * error['unfelt']:.0f} % of the devices",
        )
    counts = table("wall, N·m/rad", "counts a turn for 1 JND", "for half a JND")
    for row in results["counts_for_walls"]:
        counts.add_row(
            f"{row['stiffness_nm_per_rad']:g}", f"{row['one_jnd']:,}", f"{row['half_jnd']:,}"
        )
    console.print(counts)
    console.print(f"1 JND: {perception.MEANING}")
