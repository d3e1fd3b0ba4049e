"""Error against cost: every way to step the plant, on one model, in one run.

Two visits to a virtual wall are recorded in closed loop: a hand that pushes in and comes out
(scenario 2 of the paper), and a weight on a string that is cut (scenario 3). The commands to motor
and brake are then played to each simulator, so that all of them solve the same problem, and what
they make of it is set beside a solution with proven digits, or SciPy's.
"""

from __future__ import annotations

import importlib
import itertools
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, Final, get_args

import numpy as np
import numpy.typing as npt
from rich.console import Console

from torsio.closed_loop import simulate
from torsio.common.screen import table
from torsio.demos import wall
from torsio.emulator import Plant
from torsio.printed.hands import Hand, ImpedanceHand, TorqueHand
from torsio_studies.common import Results, Study
from torsio_studies.fidelity import batch, drake_model
from torsio_studies.fidelity.figure import draw
from torsio_studies.fidelity.mujoco_model import Settings, Simulation, mujoco_version
from torsio_studies.fidelity.truth import (
    PLANT,
    HandTorque,
    Method,
    Truth,
    hand_torque,
    simulate_truth,
)
from torsio_studies.steppers import METHODS, make_plant

Array = npt.NDArray[np.float64]

PERIOD_S: Final = 1e-3
TARGET_ERROR: Final = 1e-3
STEPS_US: Final = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
MUJOCO_STEPS_US: Final = (1, 2, 4, 5, 8, 10, 20, 25, 40, 50, 100, 125, 200, 250, 500, 1000)
QUICK_STEPS_US: Final = (100, 200, 500, 1000)
SCIPY: Final = tuple(itertools.product(get_args(Method), (1e-4, 1e-6, 1e-8)))
"""Methods of `scipy.integrate.solve_ivp`, with their relative tolerances."""
ROUNDS: Final = 5
"""How often the summary's two are timed, in turns."""


@dataclass(frozen=True)
class Scenario:
    """A scenario and its truth."""

    number: int
    about: str
    hand: Hand
    motor_nm: Array
    brake_nm: Array
    angle_rad: Array
    twist_rad: Array
    friction_events: int

    @property
    def duration_s(self) -> float:
        """Duration of the visit."""
        return PERIOD_S * len(self.motor_nm)

    def errors(self, angles: Array) -> tuple[float, float]:
        """Largest and RMS error, relative; the worse one of knob angle and spring torque."""
        pairs = (
            (angles[:, 0] - self.angle_rad, float(np.ptp(self.angle_rad))),
            (angles[:, 0] - angles[:, 1] - self.twist_rad, float(np.abs(self.twist_rad).max())),
        )
        largest = max(float(np.abs(error).max()) / scale for error, scale in pairs)
        rms = max(math.sqrt(float(np.mean(error**2))) / scale for error, scale in pairs)
        return largest, rms


def visits(quick: bool) -> dict[int, tuple[str, Hand, float]]:
    """Give what happens in each scenario: in words, the hand, and for how long."""
    push = wall.hand()
    cut = TorqueHand(torque_nm=[(0.0, 0.0), (0.3, 0.05), (0.6, 0.05), (0.6, 0.0)])
    duration_s, cut_duration_s = 2.4, 1.6
    if quick:
        faster = [(time_s / 5, angle) for time_s, angle in _knots(push.intended_angle_rad)]
        push = ImpedanceHand(
            intended_angle_rad=faster,
            stiffness_nm_per_rad=push.stiffness_nm_per_rad,
            damping_nm_s_per_rad=push.damping_nm_s_per_rad,
            inertia_kg_m2=push.inertia_kg_m2,
        )
        cut = TorqueHand(torque_nm=[(0.0, 0.0), (0.1, 0.05), (0.2, 0.05), (0.2, 0.0)])
        duration_s, cut_duration_s = 0.48, 0.4
    return {
        2: ("a hand pushes in and comes out", push, duration_s),
        3: ("a weight pulls in, and its string is cut", cut, cut_duration_s),
    }


def _knots(profile: Any) -> list[tuple[float, float]]:
    return [(float(time_s), float(value)) for time_s, value in profile]


def _prepare(study: Study, number: int, about: str, hand: Hand, duration_s: float) -> Scenario:
    rows = simulate(batch.at_the_wall(hand), duration_s=duration_s)
    motor_nm = rows["motor_command_nm"].astype(np.float64)
    brake_nm = rows["brake_command_nm"].astype(np.float64)
    truth = _truth(study, f"scenario {number}: truth", hand_torque(hand), motor_nm, brake_nm)
    return Scenario(
        number,
        about,
        hand,
        motor_nm,
        brake_nm,
        truth.angle_rad,
        truth.angle_rad - truth.brake_angle_rad,
        truth.friction_events,
    )


def _truth(study: Study, label: str, hand: HandTorque, motor_nm: Array, brake_nm: Array) -> Truth:
    """Give the middles of balls with proven digits; without python-flint SciPy's solution."""
    if find_spec("flint") is None:
        count = study.counter(label, len(motor_nm))
        return simulate_truth(
            PLANT, hand, motor_nm, brake_nm, period_s=PERIOD_S, on_progress=count
        )  # fmt: skip
    balls = importlib.import_module("torsio_studies.enclosure.balls")
    motor = study.track(motor_nm, label)
    found, run, _ = balls.enclose(PLANT, hand, motor, brake_nm, period_s=PERIOD_S, digits=100)
    assert max(ball.rad() for some in found for ball in some) < 10.0**-balls.DIGITS
    angles = np.array([[float(ball.mid()) for ball in some] for some in found])
    return Truth(angles[:, 0], angles[:, 1], len(run.events))


def _plant_run(plant: Plant, scenario: Scenario) -> tuple[Array, float]:
    plant.restart()
    begin = time.thread_time()
    angles = plant.drive(scenario.motor_nm, scenario.brake_nm, period_ns=round(1e9 * PERIOD_S))
    return angles, time.thread_time() - begin


def _best_time(scenario: Scenario, plant: Plant, first_s: float) -> float:
    """Repeat a short run and take its least time: other programs took some of the others."""
    repeats = min(100, int(0.05 / max(first_s, 1e-6)))
    return min([first_s, *(_plant_run(plant, scenario)[1] for _ in range(repeats))])


def _row(
    scenario: Scenario, method: str, step_s: float | None, angles: Array, cpu_s: float, **more: Any
) -> dict[str, Any]:
    error, error_rms = scenario.errors(angles)
    return {
        "scenario": scenario.number,
        "method": method,
        "step_s": step_s,
        "error": error,
        "error_rms": error_rms,
        "realtime_factor": scenario.duration_s / cpu_s,
        **more,
    }


def _own_rows(scenario: Scenario, steps_us: tuple[int, ...]) -> Iterator[dict[str, Any]]:
    for method, step_us in itertools.product(METHODS, steps_us):
        plant = make_plant(method, PLANT, hand=scenario.hand, step_ns=1000 * step_us)
        angles, cpu_s = _plant_run(plant, scenario)
        cpu_s = _best_time(scenario, plant, cpu_s)
        yield _row(scenario, method, step_us / 1e6, angles, cpu_s)


def _scipy_rows(scenario: Scenario) -> Iterator[dict[str, Any]]:
    """SciPy chooses its own steps, and stops where friction catches or lets go."""
    for method, rtol in SCIPY:
        begin = time.thread_time()
        truth = simulate_truth(
            PLANT,
            hand_torque(scenario.hand),
            scenario.motor_nm,
            scenario.brake_nm,
            period_s=PERIOD_S,
            method=method,
            rtol=rtol,
        )
        angles = np.column_stack([truth.angle_rad, truth.brake_angle_rad])
        cpu_s = time.thread_time() - begin
        yield _row(scenario, "scipy", None, angles, cpu_s, settings=f"{method}, {rtol:g}")


def _drake_rows(scenario: Scenario, work: list[drake_model.Choice]) -> Iterator[dict[str, Any]]:
    hand, motor_nm, brake_nm = hand_torque(scenario.hand), scenario.motor_nm, scenario.brake_nm
    for choice in work:
        contact, step_us, accuracy = choice
        angles, cpu_s = drake_model.simulate(
            PLANT, hand, motor_nm, brake_nm, period_s=PERIOD_S, choice=choice
        )
        settings = contact if accuracy is None else f"{contact}, accuracy {accuracy:g}"
        yield _row(scenario, "drake", step_us / 1e6, angles, cpu_s, settings=settings)


def _candidates(quick: bool) -> list[Settings]:
    integrators = ["Euler", "implicitfast", "implicit", "RK4"]
    solvers = [("Newton", 100), ("Newton", 3), ("CG", 100), ("PGS", 100)]
    impedances = [0.95, 0.99, 0.999, 0.9999, 0.99999]
    if quick:
        integrators, solvers, impedances = ["Euler", "RK4"], [("Newton", 100)], [0.9999]
    return [
        Settings(integrator, solref, impedance, solver, iterations)
        for integrator, solref, impedance, (solver, iterations) in itertools.product(
            integrators, (2.0, 5.0, 20.0), impedances, solvers
        )
    ]


class _MuJoCo:
    """All that is done with MuJoCo in one scenario."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._hand = hand_torque(scenario.hand)

    def simulation(self, settings: Any, step_us: int) -> Any:
        return Simulation(
            PLANT,
            self._hand,
            self._scenario.motor_nm,
            self._scenario.brake_nm,
            period_s=PERIOD_S,
            step_s=step_us / 1e6,
            settings=settings,
        )

    def row(self, settings: Any, step_us: int, *, repeat: bool = True) -> dict[str, Any]:
        simulation = self.simulation(settings, step_us)
        angles, cpu_s = simulation.run()
        if repeat and cpu_s < 0.1:
            cpu_s = min(cpu_s, *(simulation.run()[1] for _ in range(3)))
        name = "mujoco_default" if settings.is_default else "mujoco"
        return _row(self._scenario, name, step_us / 1e6, angles, cpu_s, settings=settings.as_text())

    def rows(self, study: Study, steps_us: tuple[int, ...]) -> Iterator[dict[str, Any]]:
        """Search at one step, then take the best settings of the search to every step."""
        label = f"scenario {self._scenario.number}: MuJoCo"
        search_us = 200 if study.quick else 100
        tried = [
            (self.row(settings, search_us, repeat=False), settings)
            for settings in study.track(_candidates(study.quick), f"{label}, search")
        ]
        # The best of each integrator goes on: which one wins depends on the step.
        finalists: dict[str, Any] = {}
        for _, settings in sorted(tried, key=lambda item: _error_key(item[0])):
            finalists.setdefault(settings.integrator, settings)
        yield from (row for row, _ in tried)
        work = [
            (settings, step_us)
            for settings in (*finalists.values(), Settings())
            for step_us in steps_us
            # Smaller errors are far below the target.
            if step_us >= 4 or settings.is_default or settings.integrator == "Euler"
        ]
        for settings, step_us in study.track(work, f"{label}, steps"):
            yield self.row(settings, step_us)


def _error_key(row: dict[str, Any]) -> float:
    error = row["error"]  # None in a file, for a run that blew up
    return float(error) if error is not None and math.isfinite(error) else math.inf


def _fastest(rows: list[dict[str, Any]], number: int, method: str) -> dict[str, Any] | None:
    """Give the fastest row that keeps the target."""
    good = [
        row
        for row in rows
        if row["scenario"] == number and row["method"] == method and _error_key(row) <= TARGET_ERROR
    ]
    return max(good, key=lambda row: float(row["realtime_factor"]), default=None)


def _summary(scenario: Scenario, rows: list[dict[str, Any]], mujoco: _MuJoCo) -> dict[str, Any]:
    exact = _fastest(rows, scenario.number, "exact")
    other = _fastest(rows, scenario.number, "mujoco")
    summary: dict[str, Any] = {
        "scenario": scenario.number,
        "about": scenario.about,
        "duration_s": scenario.duration_s,
        "friction_events": scenario.friction_events,
        "target_error": TARGET_ERROR,
        "exact": exact,
        "mujoco": other,
        "exact_realtime_factor": exact["realtime_factor"] if exact else None,
        "mujoco_realtime_factor": other["realtime_factor"] if other else None,
        "ratio": None,
    }
    if exact is None or other is None:
        return summary
    # Once more, both warm, in turns and equally long, so that other load meets both alike. The best
    # turn of each counts.
    step_us = round(1e6 * other["step_s"])
    settings = next(one for one in _candidates(False) if one.as_text() == other["settings"])
    simulation = mujoco.simulation(settings, step_us)
    plant = Plant(PLANT, scenario.hand, step_ns=round(1e9 * exact["step_s"]))
    _, other_once_s = simulation.run()
    _plant_run(plant, scenario)
    repeats = max(1, round(other_once_s / _plant_run(plant, scenario)[1]))
    times: list[tuple[float, float]] = []
    for _ in range(ROUNDS):
        own = sum(_plant_run(plant, scenario)[1] for _ in range(repeats)) / repeats
        times.append((own, simulation.run()[1]))
    own_s, other_s = (min(column) for column in zip(*times, strict=True))
    summary["exact_realtime_factor"] = scenario.duration_s / own_s
    summary["mujoco_realtime_factor"] = scenario.duration_s / other_s
    summary["ratio"] = other_s / own_s
    return summary


def run(study: Study) -> Results:
    """Measure, and draw the picture."""
    version = mujoco_version()
    rows: list[dict[str, Any]] = []
    summaries: list[dict[str, Any]] = []
    steps_us = QUICK_STEPS_US if study.quick else STEPS_US
    mujoco_steps_us = QUICK_STEPS_US if study.quick else MUJOCO_STEPS_US
    scenarios = []
    for number, (about, hand, duration_s) in visits(study.quick).items():
        scenario = _prepare(study, number, about, hand, duration_s)
        scenarios.append(scenario)
        label = f"scenario {number}: own methods"
        rows += study.track(_own_rows(scenario, steps_us), label, len(METHODS) * len(steps_us))
        rows += study.track(_scipy_rows(scenario), f"scenario {number}: SciPy", len(SCIPY))
        if work := drake_model.choices(mujoco_steps_us):
            rows += study.track(_drake_rows(scenario, work), f"scenario {number}: Drake", len(work))
        mujoco = _MuJoCo(scenario)
        rows += mujoco.rows(study, mujoco_steps_us)
        summaries.append(_summary(scenario, rows, mujoco))
    together = _together(study, summaries[0])
    with study.figure("pareto", size=(13.5, 7.0)) as figure:
        draw(figure, rows, summaries)
    return {"mujoco": version, "rows": rows, "summary": summaries, **together}


def _together(study: Study, summary: dict[str, Any]) -> Results:
    """Many knobs at once, with the hand of scenario 2 and MuJoCo's best settings there."""
    _, hand, duration_s = visits(study.quick)[2]
    assert isinstance(hand, ImpedanceHand)
    known = {one.as_text(): one for one in _candidates(False)}
    best = str((summary["mujoco"] or {}).get("settings"))
    settings = known.get(best, Settings("Euler", 2.0, 0.9999))
    knobs = 16 if study.quick else 256
    steps_us = batch.QUICK_MUJOCO_STEPS_US if study.quick else batch.MUJOCO_STEPS_US
    closed = batch.closed_loop_rows(hand, duration_s, knobs=max(2, knobs // 16))
    played = batch.played_rows(hand, duration_s, settings, knobs=knobs, steps_us=steps_us)
    return {"closed_loop": closed, "law": batch.law_error(hand, duration_s), "played": played}


def show(results: Results, console: Console) -> None:
    """Print what was found."""
    fastest = table("scenario", "method", "step", "error", "times real time", words=2)
    names = {"exact": "exact", "mujoco": f"MuJoCo {results['mujoco']}"}
    names |= {"drake": "Drake", "scipy": "SciPy"}
    there = {row["method"] for row in results["rows"]}
    for summary in results["summary"]:
        number = summary["scenario"]
        for key, name in names.items():
            row = _fastest(results["rows"], number, key)
            if row is None:
                if key in there:
                    fastest.add_row(str(number), name, "", "never", "")
                continue
            step_s = row["step_s"]
            factor = summary.get(f"{key}_realtime_factor", row["realtime_factor"])
            fastest.add_row(
                str(number),
                f"{name}: {row['settings']}" if key in ("drake", "scipy") else name,
                "" if step_s is None else f"{1e6 * step_s:.0f} µs",
                f"{row['error']:.1e}",
                f"{factor:,.0f}" if factor >= 10 else f"{factor:.1f}",
            )
    _show_together(results, console)
    console.print(f"\nFastest at an error of at most {TARGET_ERROR:g}, on one core:")
    console.print(fastest)
    for summary in results["summary"]:
        if summary["ratio"] is not None:
            console.print(
                f"Scenario {summary['scenario']}, {summary['about']}: the exact stepper is "
                f"{summary['ratio']:,.0f} times as fast as MuJoCo.",
            )


def _show_together(results: Results, console: Console) -> None:
    loops = table(
        "parts", "precision", "control rate", "error", "RMS", "knobs in real time", words=2
    )
    for row in results["closed_loop"]:
        loops.add_row(
            row["parts"],
            row["precision"],
            f"{row['control_rate_hz'] / 1e3:g} kHz",
            f"{row['error']:.1e}",
            f"{row['error_rms']:.1e}",
            f"{row['knobs_in_real_time']:,.0f}",
        )
    console.print("\nMany knobs in closed loop, on one core; the error is of what is felt:")
    console.print(loops)
    console.print(
        "Single precision, which the law is computed in, makes its commands wrong by "
        f"{results['law']['error']:.1e} of their peak."
    )
    played = table("commands played by", "step", "error", "knobs in real time", words=1)
    for row in results["played"]:
        played.add_row(
            row["method"],
            f"{1e6 * row['step_s']:.0f} µs",
            f"{row['error']:.1e}",
            f"{row['knobs_in_real_time']:,.0f}",
        )
    console.print()
    console.print(played)
