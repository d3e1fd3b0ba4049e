"""`torsio study calibration`: whether intervals hold the truth, and what is broken is refused."""

from __future__ import annotations

import collections
import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.table import Table
from scipy.stats import binomtest

from torsio import perception
from torsio.calibration import figure as fits
from torsio.calibration.proposal import certain_assist_nm
from torsio.calibration.quantity import Quantity
from torsio.common.screen import table
from torsio_studies.calibration import figure
from torsio_studies.calibration.driven import ALL, example
from torsio_studies.calibration.evaluation import DRIVEN, evaluate_batch
from torsio_studies.calibration.knobs import EVALUATION, QUANTITIES, batches
from torsio_studies.calibration.sabotages import SABOTAGES, try_out
from torsio_studies.common import Results, Study, StudyError
from torsio_studies.design.spread import complete
from torsio_studies.design.store import Store

Array = npt.NDArray[np.float64]
_BATCH = 4
_NEAR = 1.2  # so much larger the error in a wall may be than with the true values


def run(study: Study) -> Results:
    """Run the study; what an earlier run has left in the results folder is not computed again."""
    settings = study.settings
    knobs = int(settings.get("knobs") or (8 if study.quick else 200))
    if knobs < 4:
        raise StudyError(f"at least 4 knobs make a sample, not {knobs}")
    folder = settings.get("results") or (study.out or Path("out")) / "calibration"
    store = Store(Path(folder), {"evaluation": EVALUATION, "batch_size": _BATCH})
    work = list(batches(knobs, _BATCH))
    with complete(study, store, work, "knobs", evaluate_batch) as (_, results):
        collections.deque(results, maxlen=0)
    tables = store.read(work)
    table = tables["knob"]
    broken = SABOTAGES[::4] if study.quick else SABOTAGES
    refused = [
        {"sabotage": of.name, "right": of.reason, **dataclasses.asdict(try_out(of))}
        for of in study.track(broken, "sabotages")
    ]
    driven = of_drives(table)
    coverage = [cover(table, name) for name in QUANTITIES]
    through = [cover(driven, name) for name in ALL]
    found = example()
    with study.figure("fits", size=fits.size_of(found.fits)) as picture:
        fits.draw(picture, found.fits, found.title)
    figure.draw(study, "coverage", "hidden parameters", table, coverage)
    figure.draw(study, "coverage_driven", "hidden parameters and electrics", driven, through)
    return {
        "rows": coverage,
        "knobs": knobs,
        **whole(table),
        "driven": {"rows": through, **whole(driven)},
        "far": far(tables["far"]),
        "wall": walls(table),
        "assisted": {"told": assisted(table), "driven": assisted(driven)},
        "sabotages": refused,
    }


def of_drives(table: dict[str, Array]) -> dict[str, Array]:
    """Give the columns of the knobs with electrics."""
    return {
        name.removeprefix(DRIVEN): column
        for name, column in table.items()
        if name.startswith(DRIVEN)
    }


def far(table: dict[str, Array]) -> dict[str, Any]:
    """Give the coverage of the knobs far from the reference, without and with electrics."""
    driven = of_drives(table)
    return {
        "knobs": len(table["number"]),
        "rows": [cover(table, name) for name in QUANTITIES],
        **whole(table),
        "driven": {"rows": [cover(driven, name) for name in ALL], **whole(driven)},
    }


def whole(table: dict[str, Array]) -> dict[str, Any]:
    """Give how many knobs were measured to the end, and whether the reversed were refused."""
    return {
        "complete": int(table["complete"].sum()),
        "reversed_refused": bool(np.all(table["refused_rightly"] == 1.0)),
        "knob_seconds": float(np.nanmax(table["knob_seconds"])),
    }


def walls(table: dict[str, Array]) -> dict[str, float]:
    """Compare the errors in a wall with what was found and with what is true."""
    known = np.isfinite(table["wall_found"])
    found, true = table["wall_found"][known], table["wall_true"][known]
    return {
        "found": float(np.median(found)),
        "true": float(np.median(true)),
        "near": float(np.mean(found <= _NEAR * true)),
        "worst": float(np.max(found / true)),
    }


_FRICTIONS = ("knob_coulomb_nm", "brake_drag_nm")


def assisted(table: dict[str, Array]) -> float:
    """Give the largest share of its true friction that a knob would have taken off in free air."""
    shares = []
    for row in np.flatnonzero(np.isfinite(table["brake_drag_nm_value"])):
        found = {
            name: Quantity(
                name, float(table[f"{name}_value"][row]), float(table[f"{name}_sigma"][row])
            )
            for name in (*_FRICTIONS, "offset_nm")
        }
        true_nm = float(sum(table[f"{name}_truth"][row] for name in _FRICTIONS))
        shares.append(certain_assist_nm(found, 0.0) / true_nm)
    return max(shares)


def cover(table: dict[str, Array], name: str) -> dict[str, Any]:
    """Give how often the interval of a quantity held the truth, and how wide and right it was."""
    truth, value, sigma = (table[f"{name}_{part}"] for part in ("truth", "value", "sigma"))
    known = np.isfinite(truth) & np.isfinite(value)
    score = (value[known] - truth[known]) / np.maximum(sigma[known], 1e-300)
    size = np.abs(truth[known])
    if not known.any():
        return {"quantity": name, "knobs": 0}
    relative = bool(np.median(size) > 0)
    felt = [
        perception.jnds_of(name, float(true), float(found - true))
        for true, found in zip(truth[known], value[known], strict=True)
    ]
    in_jnds = [one for one in felt if one is not None]
    held = np.abs(score) <= 1.96
    by_chance = binomtest(int(held.sum()), len(held)).proportion_ci(method="wilson")
    scale = np.where(size > 0, size, np.nan) if relative else np.ones(len(size))
    return {
        "quantity": name,
        "knobs": int(known.sum()),
        "coverage": float(np.mean(held)),
        "coverage_interval": [float(by_chance.low), float(by_chance.high)],
        "bias_in_sigmas": float(np.median(score)),
        "median_error": float(np.nanmedian(np.abs(value[known] - truth[known]) / scale)),
        "median_sigma": float(np.nanmedian(sigma[known] / scale)),
        "relative": relative,
        "median_error_jnds": float(np.median(in_jnds)) if in_jnds else None,
    }


def _coverage(rows: list[dict[str, Any]]) -> Table:
    headings = ("knobs", "95 % intervals with the truth", "median error", "to a finger", "stated")
    quantities = table("quantity", *headings, words=1)
    for row in rows:
        if not row["knobs"]:
            continue
        unit = " %" if row["relative"] else ""
        scale = 100.0 if row["relative"] else 1.0
        quantities.add_row(
            row["quantity"],
            f"{row['knobs']}",
            "{:.1f} % ({:.0f} to {:.0f})".format(
                *(100 * share for share in (row["coverage"], *row["coverage_interval"]))
            ),
            f"{scale * row['median_error']:.2g}{unit}",
            "" if row["median_error_jnds"] is None else f"{row['median_error_jnds']:.2g} JND",
            f"{scale * row['median_sigma']:.2g}{unit}",
        )
    return quantities


def show(results: Results, console: Console) -> None:
    """Print the coverage of every quantity, and what was refused for which reason."""
    for title, part, knobs in (
        ("torques are what the motor is told", results, results["knobs"]),
        ("through a board's electrics, hidden too", results["driven"], results["knobs"]),
        ("far from the reference", results["far"], results["far"]["knobs"]),
        ("far, through electrics", results["far"]["driven"], results["far"]["knobs"]),
    ):
        console.print(f"\n{title}:")
        console.print(_coverage(part["rows"]))
        console.print(
            f"{part['complete']} of {knobs} knobs to the end; at most "
            f"{part['knob_seconds']:.0f} s of a knob's time",
        )
    wall = results["wall"]
    console.print(
        f"in a wall of 30 mN m/deg with the law calibrated, error on the way out: "
        f"{100 * wall['found']:.2g} % with what was found, {100 * wall['true']:.2g} % with the "
        f"true values (medians); {100 * wall['near']:.1f} % of the knobs are within "
        f"{100 * (_NEAR - 1):.0f} %, the worst has {wall['worst']:.1f} times",
    )
    most = max(results["assisted"].values())
    console.print(
        f"in free air no knob would have more than {100 * most:.0f} % of its friction off"
    )
    for row in results["sabotages"]:
        right = row["reason"] == row["right"]
        console.print(
            f"  {'refused' if right else 'WRONG  '}  {row['sabotage']}: "
            f"{row['reason'] or 'accepted'}, {row['fastest_rad_s']:.0f} rad/s at most",
        )
