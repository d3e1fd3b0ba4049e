"""`torsio study enclosure`: the exact stepper's errors, with digits that are proven."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from flint import arb
from rich.console import Console

from torsio.closed_loop import simulate
from torsio.common.drawing import BLUE, ORANGE, headline
from torsio.common.screen import line, table
from torsio_studies.common import Results, Study
from torsio_studies.design.spread import spread
from torsio_studies.enclosure.balls import DIGITS, UndecidedError, enclose
from torsio_studies.enclosure.cases import PERIOD_S, Case, electric_case, emulate, random_case
from torsio_studies.fidelity import batch
from torsio_studies.fidelity.study import visits
from torsio_studies.fidelity.truth import PLANT, hand_torque, simulate_truth

Array = npt.NDArray[np.float64]

PLANTS: Final = 200
_DIGITS: Final = (150, 300, 600)  # tried in this order


def evaluate(case: Case) -> list[dict[str, Any]]:
    """Enclose a case; give the stepper's error, and in which event it grew."""
    motor, brake = np.array(case.motor_nm), np.array(case.brake_nm)
    torque = hand_torque(case.hand)
    emulated = emulate(case)
    row: dict[str, Any] = {"name": case.name, "periods": len(motor)}
    for digits in _DIGITS:
        try:
            balls, run, counts = enclose(
                case.plant, torque, motor, brake, period_s=PERIOD_S, digits=digits
            )
        except UndecidedError as why:
            row = {**row, "decided": False, "why": str(why)}
            continue
        radius = max(float(ball.rad()) for some in balls for ball in some)
        row = {**row, "decided": True}
        if radius < 10.0**-DIGITS:
            break
    if not row["decided"]:
        return [row]
    middles = np.array([[float(ball.mid()) for ball in some] for some in balls])
    range_rad = float(np.abs(middles[:, :2]).max()) or 1.0

    def errors(values: Array) -> Array:
        return np.array([
            [float((arb(one) - ball).abs_upper()) for one, ball in zip(own, some, strict=True)]
            for own, some in zip(values.tolist(), balls, strict=True)
        ])  # fmt: skip

    each = errors(emulated)
    error = each[:, :2].max(axis=1)
    grown = np.diff(error, prepend=0.0) / range_rad
    losses: dict[str, float] = {}
    for growth, begin, end in zip(grown.tolist(), [0, *counts[:-1]], counts, strict=True):
        for name in set(run.events[begin:end]) or {"between events"}:
            losses[name] = max(losses.get(name, 0.0), growth)
    row |= {
        "events": len(run.events),
        "error": float(error.max()) / range_rad,
        "digits": -math.log10(radius / range_rad) if radius else math.inf,
        "losses": losses,
    }
    if case.plant.electrics:
        row["current_error"] = float(each[:, 2].max() / np.abs(middles[:, 2]).max())
    if case.with_scipy:
        truth = simulate_truth(case.plant, torque, motor, brake, period_s=PERIOD_S)
        angles = np.column_stack([truth.angle_rad, truth.brake_angle_rad])
        row["scipy_error"] = float(errors(angles).max()) / range_rad
    return [row]


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
    plants = int(study.settings.get("plants") or (4 if study.quick else PLANTS))
    cases = [*scenes(quick=study.quick), *(random_case(number) for number in range(plants))]
    work = [*cases, *(electric_case(number) for number in range(max(2, plants // 10)))]
    report = study.counter("cases", len(work))
    found: dict[str, Any] = {}
    with spread(work, workers=study.settings.get("workers"), evaluate=evaluate) as (_, results):
        for case, (row,) in results:
            found[case.name] = row
            report(len(found))
    rows = [found[case.name] for case in cases]
    circuits = [found[case.name] for case in work[len(cases) :]]
    decided = [row for row in rows if row["decided"]]
    losses: dict[str, float] = {}
    for row in decided:
        for name, growth in row["losses"].items():
            losses[name] = max(losses.get(name, 0.0), growth)
    with study.figure("errors", size=(9.0, 5.6)) as figure:
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
    return {
        "rows": rows,
        "electrics": circuits,
        "losses": dict(sorted(losses.items(), key=lambda one: -one[1])),
        "undecided": len(rows) - len(decided),
        "worst": max(decided, key=lambda row: float(row["error"])),
        "median_error": float(np.median([row["error"] for row in decided[2:]] or [math.nan])),
        "least_digits": min(row["digits"] for row in decided),
    }


def show(results: Results, console: Console) -> None:
    """Print the scenes, the worst plant, and where 64 bits lose."""
    shown = table("case", "events", "proven digits", "error", "SciPy's", words=1)
    for row in [*results["rows"][:2], results["worst"]]:
        if row["decided"]:
            scipy = f"{row['scipy_error']:.1e}" if "scipy_error" in row else ""
            digits = f"{row['digits']:.0f}"
            shown.add_row(row["name"], str(row["events"]), digits, f"{row['error']:.1e}", scipy)
    plants = f"median of {len(results['rows']) - 2} plants"
    shown.add_row(plants, "", "", f"{results['median_error']:.1e}", "")
    console.print(shown)
    if results["undecided"]:
        line(console, f"{results['undecided']} cases are undecided: two events too near")
    circuits = [row for row in results["electrics"] if row["decided"]]
    most = {key: max(row[key] for row in circuits) for key in ("error", "current_error")}
    line(
        console,
        f"with electrics, {len(circuits)} plants: {min(row['digits'] for row in circuits):.0f} "
        f"digits, angles {most['error']:.1e}, current {most['current_error']:.1e}",
    )
    losses = table("in a period with", "the error grows at most by", words=1)
    for name, growth in results["losses"].items():
        losses.add_row(name, f"{growth:.1e}")
    console.print(losses)
