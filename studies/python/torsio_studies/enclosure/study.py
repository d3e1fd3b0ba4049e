"""`torsio study enclosure`: the exact stepper's errors, with digits that are proven."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console

from torsio.closed_loop import simulate
from torsio.common.drawing import BLUE, ORANGE, headline
from torsio.common.screen import line, table
from torsio.trading.runs import Kept
from torsio_studies.common import Results, Study, make_folder
from torsio_studies.design.spread import spread
from torsio_studies.enclosure.balls import DIGITS
from torsio_studies.enclosure.cases import Case, electric_case, emulate, random_case
from torsio_studies.enclosure.evaluation import evaluate
from torsio_studies.enclosure.search import PARTS, SPACE, search
from torsio_studies.fidelity import batch
from torsio_studies.fidelity.study import visits
from torsio_studies.fidelity.truth import PLANT

PLANTS: Final = 200


def evaluate_once(work: tuple[Path | None, Case]) -> list[dict[str, Any]]:
    """Evaluate a case unless a file keeps what comes out for this motion of the emulator."""
    path, case = work
    return [Kept(path).get((case, emulate(case).tolist()), lambda: evaluate(case)[0])]


def search_once(work: tuple[Path | None, int, int]) -> list[dict[str, Any]]:
    """Search with some parts unless a file keeps what comes out."""
    path, *given = work
    return [Kept(path).get((*given, repr(SPACE)), lambda: search(*given))]


def scenes(*, quick: bool) -> list[Case]:
    """Give the visits of the study `fidelity`."""
    found = []
    for number, (about, hand, duration_s) in visits(quick).items():
        rows = simulate(batch.at_the_wall(hand), duration_s=duration_s)
        commands = [
            tuple(rows[name].astype(float).tolist())
            for name in ("motor_command_nm", "brake_command_nm")
        ]
        name = f"scenario {number}: {about}"
        found.append(Case(name, PLANT, hand, commands[0], commands[1], with_scipy=True))
    return found


def run(study: Study) -> Results:
    """Enclose the study's scenes and random plants."""
    few, many = (4, 10, [0, 15]), (PLANTS, 100, range(2 ** len(PARTS)))
    plants, tries, searches = few if study.quick else many
    plants = int(study.settings.get("plants") or plants)
    tries = int(study.settings.get("tries") or tries)
    cases = [*scenes(quick=study.quick), *map(random_case, range(plants))]
    circuits = [*map(electric_case, range(max(2, plants // 10)))]
    kept = None
    if study.out is not None:
        make_folder(study.out)
        kept = study.out / "enclosure.jsonl"
    found = _all(study, "cases", [(kept, case) for case in (*cases, *circuits)], evaluate_once)
    extremes = _all(study, "searches", [(kept, one, tries) for one in searches], search_once)
    by_name = {row["name"]: row for row in found}
    rows = [by_name[case.name] for case in cases]
    decided = [row for row in rows if row["decided"]]
    with study.figure("errors", size=(9.0, 5.6)) as figure:
        _draw(figure, decided)
    return {
        "rows": rows,
        "electrics": [by_name[case.name] for case in circuits],
        "extremes": sorted(extremes, key=lambda row: -float(row["error"])),
        "losses": _losses(decided),
        "undecided": len(rows) - len(decided),
        **_errors(decided),
    }


def _errors(decided: list[dict[str, Any]]) -> dict[str, Any]:
    """Give the worst case, and the median of the plants, which stand behind the two scenes."""
    return {
        "worst": max(decided, key=lambda row: float(row["error"])),
        "median_error": float(np.median([row["error"] for row in decided[2:]] or [math.nan])),
        "least_digits": min(row["digits"] for row in decided),
    }


def _all(study: Study, what: str, work: list[Any], once: Callable[[Any], Any]) -> list[Any]:
    """Do all of the work on the study's processors; give the rows as they come."""
    report = study.counter(what, len(work))
    found: list[Any] = []
    with spread(work, workers=study.settings.get("workers"), evaluate=once) as (_, results):
        for _, (row,) in results:
            found.append(row)
            report(len(found))
    return found


def _losses(decided: list[dict[str, Any]]) -> dict[str, float]:
    """Give the most that the error grew in a period with each event, the largest first."""
    losses: dict[str, float] = {}
    for row in decided:
        for name, growth in row["losses"].items():
            losses[name] = max(losses.get(name, 0.0), growth)
    return dict(sorted(losses.items(), key=lambda one: -one[1]))


def _draw(figure: Figure, decided: list[dict[str, Any]]) -> None:
    axes = figure.subplots()
    axes.set(xscale="log", yscale="log")
    axes.set(xlabel="events", ylabel="error, share of the largest angle")
    for colour, marker, label, some in (
        (ORANGE, "D", "the scenes", decided[:2]), (BLUE, "o", "random plants", decided[2:]),
    ):  # fmt: skip
        points = [(row["events"] + 0.5, max(row["error"], 1e-18)) for row in some]
        axes.plot(*zip(*points, strict=True), marker, color=colour, label=label)
    axes.axhline(2.0**-53, color=ORANGE, lw=1.0, label="half a unit of 64 bits")
    axes.legend(frameon=False)
    headline(
        figure,
        "What 64 bits lose",
        f"The exact stepper beside balls of {DIGITS} digits. Each point is a plant.",
        width=90,
    )
    figure.subplots_adjust(left=0.1, right=0.97, top=0.8, bottom=0.12)


def show(results: Results, console: Console) -> None:
    """Print the scenes, the worst plant, and where 64 bits lose."""
    _show_cases(results, console)
    _show_circuits(results["electrics"], console)
    extremes = results["extremes"]
    tries, undecided, cut = (
        sum(row[name] for row in extremes) for name in ("tries", "undecided", "cut")
    )
    line(
        console,
        f"the worst of {tries} extreme plants: {extremes[0]['error']:.1e} of the angle, or rad "
        f"where that is less; {undecided} undecided, {cut} for their first periods only",
    )
    losses = table("in a period with", "the error grows at most by", words=1)
    for name, growth in results["losses"].items():
        losses.add_row(name, f"{growth:.1e}")
    console.print(losses)


def _show_cases(results: Results, console: Console) -> None:
    shown = table("case", "events", "proven digits", "error", "SciPy's", words=1)
    for row in [*results["rows"][:2], results["worst"]]:
        if row["decided"]:
            scipy = f"{row['scipy_error']:.1e}" if "scipy_error" in row else ""
            digits = f"{row['digits']:.0f}"
            shown.add_row(row["name"], str(row["events"]), digits, f"{row['error']:.1e}", scipy)
    plants = f"median of {len(results['rows']) - 2} plants"
    digits = f"{results['least_digits']:.0f} or more"
    shown.add_row(plants, "", digits, f"{results['median_error']:.1e}", "")
    console.print(shown)
    if results["undecided"]:
        line(console, f"cases undecided, two events being too near: {results['undecided']}")


def _show_circuits(rows: list[dict[str, Any]], console: Console) -> None:
    circuits = [row for row in rows if row["decided"]]
    most = {key: max(row[key] for row in circuits) for key in ("error", "current_error")}
    line(
        console,
        f"with electrics, {len(circuits)} plants: {min(row['digits'] for row in circuits):.0f} "
        f"digits, angles {most['error']:.1e}, current {most['current_error']:.1e}",
    )
