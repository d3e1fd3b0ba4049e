"""`torsio study falsify`: a search that tries to break the law `calibrated`."""

from __future__ import annotations

import collections
from dataclasses import asdict
from pathlib import Path

import numpy as np
from rich.console import Console

from torsio.common.screen import line, table
from torsio.printed.config import Law
from torsio_studies.common import Results, Study
from torsio_studies.design.spread import complete
from torsio_studies.design.store import Store
from torsio_studies.falsify.cases import SPACE, batches
from torsio_studies.falsify.search import DRIVEN_W, LASTING_RAD, LOUD_NM, evaluate_batch

EVALUATION = 16
"""Raise it when a try gives other numbers: results of different ones are never mixed."""


def run(study: Study) -> Results:
    """Run the study; what an earlier run has left in the results folder is not computed again."""
    settings = study.settings
    cases = int(settings.get("cases") or (4 if study.quick else 1120))
    tries = int(settings.get("tries") or (32 if study.quick else 900))
    law: Law = settings.get("law", "calibrated")
    folder = Path(settings.get("results") or (study.out or Path("out")) / "falsify")
    store = Store(folder, {"evaluation": EVALUATION, "tries": tries})
    work = list(batches(cases, tries, law))
    with complete(study, store, work, "searches", evaluate_batch) as (_, results):
        collections.deque(results, maxlen=0)
    columns = store.read(work)[law]
    worst = np.argsort(-columns["swing_rad"] / LASTING_RAD - columns["loud_nm"] / LOUD_NM)
    found = [
        {**asdict(work[number].designs[0]), **{name: float(columns[name][n]) for name in columns}}
        for n in worst[: max(20, int(columns["breaks"].sum()))].tolist()
        for number in [int(columns["number"][n])]
    ]
    return {
        "rows": [row for row in found if row["breaks"]],
        "worst": found[:5],
        "searches": cases,
        "tries": int(columns["tries"].sum()),
        "counter_examples": int(columns["breaks"].sum()),
        "warned": int(columns["warned"].sum()),
        "broke_early": int(columns["broke_early"].sum()),
        "space": SPACE,
        "lasting_rad": LASTING_RAD,
        "loud_nm": LOUD_NM,
        "driven_w": DRIVEN_W,
    }


def show(results: Results, console: Console) -> None:
    """Print how many tries there were, and what broke."""
    line(
        console,
        f"tries: {results['tries']:,}, searches: {results['searches']}, counter-examples: "
        f"{results['counter_examples']}, of which `play` warns: {results['warned']}; generations "
        f"that broke the law at 1.8 s, and whose worst try ran again: {results['broke_early']:,}",
    )
    shown = table("scene", "hand", "rate, counts", "swing, mrad", "motor, mW", "above 20 Hz, mN·m")
    for row in results["rows"] or results["worst"]:
        shown.add_row(
            row["scene"], row["hand"], f"{row['rate_hz'] // 1000} kHz, {row['counts']:,}",
            f"{1e3 * row['swing_rad']:.3g}", f"{1e3 * row['work_w']:.3g}",
            f"{1e3 * row['loud_nm']:.3g}",
        )  # fmt: skip
    console.print(shown)
