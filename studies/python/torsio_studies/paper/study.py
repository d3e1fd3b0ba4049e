"""`torsio study paper`: the paper's experiments and formulas again.

Keys of the results, besides those that all studies have:

``scenario_1``
    ``rows``: per loop (law, control_rate_hz, delay_ticks, counts_per_rev) and stiffness_nm_per_rad
    the crossings of the spring's middle in 1 s and the oscillation_rad that is left.
    ``limits``: per loop, up to which stiffness every run came to rest.
``scenario_2``
    ``rows``: per law, pull_s (time for the way out) and stiffness, tracking errors as fractions of
    the peak, torque gap, error of the sensor, and zero_crossing: where on the way out the sensed
    torque changes sign, as a fraction of the depth, beside zero_crossing_formula.
    ``events``: time_s of each event of the visit to the wall of 30 mN m/deg.
``scenario_3``
    ``rows``: per law and shaft, depths, exit_s (null: never left), stuck_torque_nm, outcome.
``characterisation``
    slope and offset of a linear and of a hardening shaft.
``zero_crossing``
    ``rows``: found on the ideal plant, beside the formula.
``critical_torque``
    ``rows``: per beta and stiffness_ratio (to the shaft), found_nm, formula_nm, error (relative).
    ``largest_error``.
``better``
    ``rows``: per variant of law, rate and encoder, the measures of scenario 2 at 30 mN m/deg.
``aims``
    ``rows``: per variant what it reaches of ``aims``, with electrics at 20 kHz and 32,768 counts.
``statements``
    per statement of the paper: where, paper, found, verdict ("holds", "partly", "wrong",
    "not found"), which follows from the numbers.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from torsio import perception
from torsio.closed_loop import LoopOptions, simulate, simulate_many
from torsio.common.drawing import BLUE, GREEN, GREY, ORANGE
from torsio.printed.config import Law
from torsio.printed.plant import BrakeHysteresis, PlantParams, ShaftHardening
from torsio.telemetry import Record
from torsio_studies.common import Results, Study
from torsio_studies.paper import aims, critical, law_figures, runs, scenario_figures
from torsio_studies.paper.statements import statements

# name, colour, and what differs from the paper's loop
BOUNCE_LOOPS: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("paper's law, 1 kHz", BLUE, {}),
    ("one sample of delay", ORANGE, {"delay_ticks": 1}),
    ("10 kHz", GREEN, {"rate_hz": 10_000.0}),
    ("motor alone, 1 kHz", GREY, {"law": "motor_only"}),
)
WALLS = (10.0, 20.0, 30.0, 50.0, 70.0, 100.0)  # mN m per degree
PULLS_S = (0.5, 1.0, 2.0, 4.0)
CUT_WALL = 25.0
BETAS = (0.1, 0.3, 0.5, 0.7, 0.9)
SOFT_SHAFT_RATIO = 30.0 / 50.1


def run(study: Study) -> Results:
    """Run everything and draw it."""
    results: Results = {
        "scenario_1": _scenario_1(study),
        "scenario_2": _scenario_2(study),
        "scenario_3": _scenario_3(study),
        "characterisation": _characterisation(study),
        "zero_crossing": _diagrams(study),
        "critical_torque": _critical(study),
        "better": _better(study),
        "aims": aims.run(study),
    }
    results["statements"] = statements(results)
    return results


def _scenario_1(study: Study) -> Results:
    steps = 12 if study.quick else 45
    rows, limits, sweeps = [], [], []
    for name, color, options in study.track(BOUNCE_LOOPS, "scenario 1: bounces"):
        stiffness = np.geomspace(0.5, 40.0, steps)
        loops = [runs.bounce_options(float(k), **options) for k in stiffness]
        every = 1 if "rate_hz" not in options else 10
        outcomes = [
            runs.count_bounces(one)
            for one in simulate_many(loops, duration_s=1.0, record_every=every)
        ]
        loop = {
            "law": loops[0].control.law,
            "control_rate_hz": 1e9 / loops[0].control_period_ns,
            "delay_ticks": loops[0].delay_ticks,
            "counts_per_rev": loops[0].plant.counts_per_rev,
        }
        for k, outcome in zip(stiffness, outcomes, strict=True):
            rows.append({**loop, "stiffness_nm_per_rad": k, **asdict(outcome)})
        limit = runs.largest_stable(stiffness, outcomes)
        limits.append({**loop, "stable_to_nm_per_rad": limit})
        sweeps.append((name, color, stiffness, outcomes))
    examples = {k: simulate(runs.bounce_options(k), duration_s=1.0) for k in (4.0, 15.0)}
    scenario_figures.scenario_1(study, examples, sweeps)
    return {"rows": rows, "limits": limits}


def _push_row(options: LoopOptions, pull_s: float, push: runs.Push) -> Results:
    scene = options.scene
    stiffness = getattr(scene, "stiffness_nm_per_rad", math.nan)
    measured = asdict(push)
    for index in ("in_end", "out_begin", "first", "last"):
        del measured[index]
    beta = options.control.beta
    return {
        "law": options.control.law,
        "wall_mnm_per_deg": 1e3 * math.radians(stiffness),
        "wall_stiffness_nm_per_rad": stiffness,
        "pull_s": pull_s,
        **measured,
        "jnds": push.jnds(),
        "zero_crossing_formula": max(0.0, 1.0 - beta * stiffness / runs.SHAFT_NM_PER_RAD),
    }


def _scenario_2(study: Study) -> Results:
    rows, visits = [], {}
    events: list[Results] = []
    for wall in study.track(WALLS, "scenario 2: into the wall and out"):
        options = runs.push_options(runs.per_degree(wall))
        log, push = runs.run_push(options)
        visits[runs.per_degree(wall)] = (log, push)
        rows.append(_push_row(options, runs.PULL_S, push))
        if wall == 30.0:
            indices = runs.wall_events(log, push, options.control.beta)
            events = [
                {"event": event, "time_s": log["time_s"][index]}
                for event, index in zip(runs.WALL_EVENTS, indices, strict=True)
            ]
            scenario_figures.wall_events(study, log, push, runs.per_degree(wall), indices)
            for pull_s in PULLS_S:
                if pull_s != runs.PULL_S:
                    faster = runs.push_options(runs.per_degree(wall), pull_s=pull_s)
                    _, push = runs.run_push(faster, extra_s=max(0.0, pull_s - runs.PULL_S))
                    rows.append(_push_row(faster, pull_s, push))
    scenario_figures.scenario_2(study, visits)
    return {"rows": rows, "events": events}


def _scenario_3(study: Study) -> Results:
    rows = []
    cuts: dict[str, tuple[Record, runs.Cut]] = {}
    stiffness = runs.per_degree(CUT_WALL)
    rigid = PlantParams(shaft_stiffness_nm_per_rad=50.0)
    cases: tuple[tuple[Law, PlantParams], ...] = (
        ("paper", PlantParams()),
        ("compensated", PlantParams()),
        ("calibrated", PlantParams()),
        ("parallel", PlantParams()),
        ("motor_only", PlantParams()),
        ("parallel", rigid),
    )
    for law, plant in study.track(cases, "scenario 3: the string is cut"):
        log, cut = runs.run_cut(runs.cut_options(stiffness, law, plant=plant))
        shaft = plant.shaft_stiffness_nm_per_rad
        rows.append(
            {"law": law, "shaft_nm_per_rad": shaft, "wall_mnm_per_deg": CUT_WALL, **asdict(cut)}
        )
        if plant is not rigid:
            cuts[law] = (log, cut)
    for wall in (10.0, 50.0, 100.0):
        _, cut = runs.run_cut(runs.cut_options(runs.per_degree(wall)))
        rows.append(
            {
                "law": "paper",
                "shaft_nm_per_rad": runs.SHAFT_NM_PER_RAD,
                "wall_mnm_per_deg": wall,
                **asdict(cut),
            }
        )
    scenario_figures.scenario_3(study, cuts, stiffness)
    return {"rows": rows}


def _characterisation(study: Study) -> Results:
    hard = ShaftHardening(knee_rad=runs.LINEAR_RAD, stiffness_factor=2.0)
    linear, hardened = study.track(
        (runs.characterise(), runs.characterise(hard)), "stiffness of the shaft"
    )
    law_figures.characterisation(study, linear, hardened)
    return {
        name: {"slope_nm_per_rad": one.slope_nm_per_rad, "offset_nm": one.offset_nm}
        for name, one in (("linear", linear), ("hardening", hardened))
    }


def _diagrams(study: Study) -> Results:
    """Torque diagrams, and where the shaft is empty on the way out."""
    beta = 0.5
    panels = []
    for ratio in (3.0, SOFT_SHAFT_RATIO):
        stiffness = ratio * runs.SHAFT_NM_PER_RAD
        peak = critical.critical_torque(stiffness, beta)
        push = critical.ideal_push(stiffness, beta, peak)
        panels.append((stiffness, simulate(push, duration_s=critical.IDEAL_PUSH_S)))
    law_figures.torque_diagrams(study, panels, beta)
    rows = []
    for ratio in study.track((0.2, 0.4, 0.6, 0.8, 1.0, 1.5), "where the shaft is empty"):
        stiffness = ratio * runs.SHAFT_NM_PER_RAD
        log = simulate(
            critical.ideal_push(stiffness, beta, 50e-3), duration_s=critical.IDEAL_PUSH_S
        )
        depth = log["angle_rad"] - 0.01
        turn = int(np.argmax(depth))
        against = turn + np.flatnonzero(log["sensed_spring_torque_nm"][turn:] > 0)
        rows.append(
            {
                "beta": beta,
                "stiffness_ratio": ratio,
                "found": float(depth[against[0]] / depth[turn]),
                "formula": 1.0 - beta * ratio,
            }
        )
    return {"rows": rows}


def _critical(study: Study) -> Results:
    ratios = np.geomspace(0.1, 4.0, 5 if study.quick else 13)
    cases = [(float(r) * runs.SHAFT_NM_PER_RAD, beta) for beta in BETAS for r in ratios]
    halvings = 9 if study.quick else 12
    done = study.counter("critical torque", halvings)
    found = critical.measured_critical_torque(cases, halvings=halvings, on_progress=done)
    rows = []
    for (stiffness, beta), torque in zip(cases, found, strict=True):
        formula = critical.critical_torque(stiffness, beta)
        rows.append(
            {
                "beta": beta,
                "stiffness_ratio": stiffness / runs.SHAFT_NM_PER_RAD,
                "found_nm": torque,
                "formula_nm": formula,
                "error": torque / formula - 1.0,
            }
        )
    law_figures.critical_torques(study, rows)
    return {"rows": rows, "largest_error": max(abs(row["error"]) for row in rows)}


_HYSTERESIS = PlantParams(brake_hysteresis=BrakeHysteresis(half_width_nm=0.05 * runs.BRAKE_NM))
BETTER: tuple[tuple[str, dict[str, Any]], ...] = (
    ("paper's law", {}),
    (
        "'compensated': motor cancels the spring\nboth ways, sensor knows the drag",
        {"law": "compensated"},
    ),
    ("... and 10 kHz", {"law": "compensated", "rate_hz": 10_000.0}),
    (
        "... and four times the counts",
        {"law": "compensated", "rate_hz": 10_000.0, "counts_per_rev": 32_768},
    ),
    (
        "... and 'calibrated': the sensor knows\nthe inertia behind the brake",
        {"law": "calibrated", "rate_hz": 10_000.0, "counts_per_rev": 32_768},
    ),
    ("paper's law, brake with 5 % hysteresis", {"plant": _HYSTERESIS}),
    ("'calibrated', the same brake", {"law": "calibrated", "plant": _HYSTERESIS}),
)


def _better(study: Study) -> Results:
    rows = []
    for name, options in study.track(BETTER, "better than the paper"):
        _, push = runs.run_push(runs.push_options(runs.per_degree(30.0), **options))
        measures = ("tracking_rms_in", "tracking_rms_out", "torque_gap_nm", "sensor_rms_nm")
        found = {measure: getattr(push, measure) for measure in measures}
        rows.append({"variant": name, **found, "jnds": push.jnds()})
    law_figures.better(study, rows)
    return {"rows": [{**row, "variant": str(row["variant"]).replace("\n", " ")} for row in rows]}


def show(results: Results, console: Console) -> None:
    """Print the paper's statements beside what came out."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("where", "the paper", "what came out", "verdict"):
        table.add_column(column, overflow="fold")
    for row in results["statements"]:
        table.add_row(row["where"], row["paper"], row["found"], row["verdict"])
    console.print()
    console.print(table)
    console.print()
    console.print(aims.table(results["aims"]))
    leap_nm = results["aims"]["held_leap_nm"]
    console.print(
        f"off a count that the device holds the motor leaps by {1e3 * leap_nm:.1f} mN·m, "
        f"{perception.torque_jnds(leap_nm):.1f} JND"
    )
    console.print(f"1 JND: {perception.MEANING}")
