"""`torsio study extremes`: where numbers break, and what holds there.

Keys of the results, besides those that all studies have:

``rows``
    per case: ``extreme``, ``case``, ``measure`` (what is measured, in which unit; small is good),
    ``naive`` (a plain implementation's value, "not finite", or null where there is none to compare
    with), ``guarded`` (this one's), ``bound`` (up to here is good), ``naive_breaks``, ``holds``,
    ``guard`` (what makes it hold).
``all_hold``
    whether every case is within its bound.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

from rich.console import Console
from rich.table import Table

from torsio.scenes import MAX_TORQUE_NM
from torsio_studies.common import Results, Study
from torsio_studies.extremes import dynamics, figures, not_finite, numbers
from torsio_studies.extremes.numbers import Case
from torsio_studies.paper import runs


def run(study: Study) -> Results:
    """Run everything and draw it."""
    cases: list[Case] = []
    groups = (
        _turning(study.quick),
        _wraps(),
        _clocks(),
        _stiffness(),
        _shares(),
        _friction(),
        _brake_lag(),
        _inertia(),
        _rounding(),
        _delay(),
        _not_finite(),
        _precision(),
    )
    for group in study.track(groups, "extremes"):
        cases.extend(group)
    figures.overview(study)
    return {
        "rows": [case.as_row() for case in cases],
        "all_hold": all(case.holds for case in cases),
    }


def _turning(quick: bool) -> Iterator[Case]:
    measure = "error of the sensed torque (N m)"
    guard = "positions are integers, only differences become float"
    for hours in (1.0, 10.0, 1000.0):
        naive, guarded = numbers.turning_error_nm(hours)
        yield Case("turning", f"{hours:g} h at 10 rev/s", measure, naive, guarded, 1e-6, guard)
    hours = 0.1 if quick else 10.0
    wrong = numbers.turned_in_full(hours)
    ticks = round(3.6e6 * hours)
    angle = 2.0 * math.pi * numbers.REVS_PER_S * 3600 * hours
    naive = _float_step(angle) / runs.COUNT_RAD
    yield Case(
        "turning", f"all {ticks} ticks of {hours:g} h", "wrong counts", naive, wrong, 0.0, guard
    )
    yield Case(
        "turning",
        "a wall 1000 h of turning away",
        "error of the motor's torque (N m)",
        runs.per_degree(30) * _float_step(2.0 * math.pi * 3.6e7),
        numbers.far_wall_error_nm(1000.0),
        1e-5,
        "angles travel as 64-bit fixed-point turns",
    )
    yield Case(
        "turning",
        "the emulated knob itself 1000 h away",
        "change of its speed (rad/s)",
        numbers.naive_far_plant_speed_error_rad_s(1000.0),
        numbers.far_plant_speed_error_rad_s(1000.0),
        1e-9,
        "the plant's angle is whole turns and a rest",
    )


def _float_step(angle_rad: float) -> float:
    """Half the distance between neighbouring 32-bit floats there."""
    return 0.5 * float(2.0 ** (math.floor(math.log2(angle_rad)) - 23))


def _wraps() -> Iterator[Case]:
    for bits in (16, 32):
        naive, guarded = numbers.wrap_errors_nm(bits)
        yield Case(
            "counter wraps",
            f"{bits}-bit counter, in a wall",
            "error of the sensed torque (N m)",
            naive,
            guarded,
            1e-9,
            "differences modulo the counter's width",
        )


def _clocks() -> Iterator[Case]:
    naive, guarded = numbers.microsecond_errors_s()
    yield Case(
        "clock wraps",
        "32-bit microseconds, after 71.6 min",
        "error of a step of time (s)",
        naive,
        guarded,
        1e-9,
        "the device counts ticks in 64 bits",
    )
    for name, tick in (("2^32 ticks, 50 days", 2**32 - 500), ("1000 h of a sine", 3_600_000_000)):
        naive, guarded = numbers.clock_errors(tick)
        yield Case(
            "clock wraps",
            name,
            "error of a periodic torque (share of its amplitude)",
            naive,
            guarded,
            1e-6,
            "phases are integers that wrap as periods do",
        )


def _stiffness() -> Iterator[Case]:
    for stiffness in dynamics.STIFFNESSES:
        yield Case(
            "stiffness",
            f"wall of {stiffness:g} N m/rad",
            "peak torque commanded to the motor (N m)",
            dynamics.stiff_wall_torque_nm(stiffness, motor_limit_nm=MAX_TORQUE_NM),
            dynamics.stiff_wall_torque_nm(stiffness),
            1.0000001 * runs.MOTOR_NM,
            "the last step before the motor is its limit",
        )

    # How stiff the shaft itself is: the plain variant is Runge-Kutta 4 at the same steps.
    for stiffness in dynamics.SHAFT_STIFFNESSES:
        yield Case(
            "stiffness",
            f"shaft of {stiffness:g} N m/rad",
            "error of its free swing (share of the amplitude)",
            dynamics.shaft_swing_error(stiffness, "regularised"),
            dynamics.shaft_swing_error(stiffness, "exact"),
            1e-6,
            "the plant is stepped with the matrix exponential",
        )
    for stiffness in dynamics.SHAFT_STIFFNESSES:
        yield Case(
            "stiffness",
            f"shaft of {stiffness:g} N m/rad, friction",
            "change of the motion with the step (share of the peak)",
            dynamics.shaft_step_error(stiffness, "regularised"),
            dynamics.shaft_step_error(stiffness, "exact"),
            1e-6,
            "matrix exponentials between events that are located",
        )


def _shares() -> Iterator[Case]:
    cases = ((1.0, 1.0), (0.5, 1.0), (1.5, 1.0), (2.0, 0.5), (0.5, 0.0))
    for (ratio, beta), (naive, guarded) in zip(cases, dynamics.critical_errors(cases), strict=True):
        yield Case(
            "critical torque",
            f"beta {beta:g}, Kve = {ratio:g} K",
            "error of the formula against the experiment (relative)",
            naive,
            guarded,
            0.03,
            "the brake's own limit removes the poles",
        )
    for beta in (0.0, 1.0):
        yield Case(
            "beta",
            f"beta {beta:g} in closed loop",
            "tracking error out of a wall (share of the peak)",
            dynamics.share_error(beta, "parallel"),
            dynamics.share_error(beta, "paper"),
            0.15,
            "the sensor says when the brake must let go",
        )
    yield Case(
        "beta",
        "beta 1, the string is cut in a wall",
        "torque that the knob is stuck with (N m)",
        dynamics.stuck_torque_nm("parallel", 1.0),
        dynamics.stuck_torque_nm("paper", 1.0),
        dynamics.HELD_BY_FRICTION_NM,
        "the sensor says when the brake must let go",
    )


def _friction() -> Iterator[Case]:
    yield Case(
        "friction",
        "motor weaker than friction, string cut",
        "motion that is left after 1 s (rad)",
        dynamics.weak_motor_motion_rad("regularised"),
        dynamics.weak_motor_motion_rad("exact"),
        1e-9,
        "friction is set-valued: at rest it is what holds",
    )
    yield Case(
        "friction",
        "a torque that friction holds",
        "speed of the knob (rad/s)",
        dynamics.creep_rad_s("regularised"),
        dynamics.creep_rad_s("exact"),
        0.0,
        "friction is set-valued: at rest it is what holds",
    )
    travel = []
    for guarded in (False, True):
        _, angle = dynamics.free_air(guarded)
        travel.append(float(abs(angle[-1] - angle[len(angle) // 2])))
    yield Case(
        "friction",
        "free air, floor of the sensor above friction and drag",
        "travel in the second half of a second after a flick (rad)",
        travel[0],
        travel[1],
        1e-3,
        "no torque is asked: none is given",
    )


def _brake_lag() -> Iterator[Case]:
    for ratio in (0.1, 1.0, 2.5, 10.0):
        euler, model, exact = dynamics.brake_step(ratio)
        yield Case(
            "brake lag",
            f"control period {ratio:g} times the time constant",
            "largest error of the modelled torque (N m)",
            float(abs(euler - exact).max()),
            float(abs(model - exact).max()),
            1e-7,
            "the exponential is exact for a held command",
        )
    for lag in dynamics.TIME_CONSTANTS_S:
        yield Case(
            "brake lag",
            f"time constant {lag:g} s in closed loop",
            "tracking error into a wall (share of the peak)",
            dynamics.lag_tracking(lag, modelled_s=0.0),
            dynamics.lag_tracking(lag, modelled_s=lag),
            0.15,
            "the sensor is bounded by what the brake holds by now, and the motor gives the rest",
        )
    cases = [(1_000_000, lag) for lag in dynamics.TIME_CONSTANTS_S] + [(10_000_000, 1e-3)]
    for period_ns, lag in cases:
        naive, guarded = dynamics.brake_model_errors_nm(period_ns, lag)
        yield Case(
            "brake lag",
            f"{1e-6 * period_ns:g} ms steps, time constant {lag:g} s, closed loop",
            "error of the modelled torque (N m)",
            naive,
            guarded,
            1e-6,
            "the exponential is exact for a held command",
        )


def _inertia() -> Iterator[Case]:
    for ratio in dynamics.INERTIA_RATIOS:
        naive = dynamics.energy_error(ratio, "regularised")
        yield Case(
            "inertia ratio",
            f"brake over knob {ratio:g}",
            "energy that appears from nothing (relative)",
            naive,
            dynamics.energy_error(ratio, "exact"),
            1e-7,
            "the plant is stepped with the matrix exponential",
        )


def _rounding() -> Iterator[Case]:
    naive, guarded = numbers.subnormal_ticks()
    yield Case(
        "subnormals",
        "the controller, a released brake for 60 s",
        "ticks with a subnormal state",
        naive,
        guarded,
        0.0,
        "decaying states end at exactly 0",
    )
    naive, guarded = numbers.subnormal_plant_states()
    yield Case(
        "subnormals",
        "the emulated knob, a released brake for 60 s",
        "subnormal torques of motor and brake in 798 looks",
        naive,
        guarded,
        0.0,
        "decaying states end at exactly 0",
    )


def _delay() -> Iterator[Case]:
    measure = "oscillation that is left after 1 s (rad)"
    oscillation = dynamics.bounce_oscillation_rad
    late = oscillation(7.0, "paper", delay_ticks=1)
    cases = (
        (
            "7 N m/rad: a tick late, and not",
            late,
            oscillation(7.0, "paper"),
            "a command acts in the tick that took the count",
        ),
        (
            "7 N m/rad, a tick late: 1 kHz, and 10 kHz",
            late,
            oscillation(7.0, "paper", delay_ticks=1, rate_hz=10_000.0),
            "a faster loop has a shorter tick",
        ),
        (
            "1.5 N m/rad, a tick late: motor alone, and brake",
            oscillation(1.5, "motor_only", delay_ticks=1),
            oscillation(1.5, "paper", delay_ticks=1),
            "the brake takes half of the torque, and dissipates",
        ),
    )
    for name, naive, guarded, guard in cases:
        yield Case("delay", name, measure, naive, guarded, runs.AT_REST_RAD, guard)


def _not_finite() -> Iterator[Case]:
    offered, accepted = not_finite.accepted_in_python()
    yield Case(
        "not finite",
        f"NaN, +inf, -inf in {offered // 3} quantities of Python",
        "values that were accepted",
        None,
        accepted,
        0.0,
        "every value is checked before anything has effect",
    )
    tried, spoiled = not_finite.spoiled_for_good()
    offered, accepted = not_finite.accepted_as_bytes()
    yield Case(
        "not finite",
        f"{tried} into the bare law; as bytes in {offered // 3} fields",
        "values that pass, or change the motor's torque for good",
        spoiled,
        accepted,
        0.0,
        "every report is checked whole before it has effect",
    )


def _precision() -> Iterator[Case]:
    measure = "32 against 64 bits: difference of the motor's torque (N m)"
    for law in ("paper", "compensated"):
        options = runs.push_options(runs.per_degree(30), law)
        _, difference = numbers.precision_trace(options, runs.PUSH_DURATION_S)
        yield Case(
            "precision",
            f"into a wall and out, law '{law}'",
            measure,
            numbers.turning_error_nm(1.0)[0],
            float(abs(difference).max()),
            1e-6,
            "large numbers are integers, floats stay small",
        )
    _, difference = numbers.precision_trace(runs.bounce_options(15.0), 1.0)
    yield Case(
        "precision",
        "a virtual spring beyond its limit",
        measure,
        numbers.turning_error_nm(1.0)[0],
        float(abs(difference).max()),
        1e-6,
        "large numbers are integers, floats stay small",
    )


def show(results: Results, console: Console) -> None:
    """Print every case."""
    console.print()
    groups = itertools.groupby(results["rows"], lambda row: (row["extreme"], row["measure"]))
    for (extreme, measure), rows in groups:
        table = Table(box=None, pad_edge=False, header_style="bold", title_justify="left")
        table.title = f"{extreme}: {measure}"
        table.title_style = "bold"
        table.add_column("case", width=36)
        for heading in ("plain", "here", "bound"):
            table.add_column(heading, justify="right", width=10)
        table.add_column("holds", width=5)
        for row in rows:
            table.add_row(
                row["case"],
                _text(row["naive"]),
                _text(row["guarded"]),
                _text(row["bound"]),
                "yes" if row["holds"] else "[bold red]no[/bold red]",
            )
        console.print(table)
        console.print()


def _text(value: float | str | None) -> str:
    if value is None:
        return "-"
    return value if isinstance(value, str) else f"{value:.3g}"
