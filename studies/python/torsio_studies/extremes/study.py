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
from collections.abc import Callable, Iterator
from functools import partial

from rich.console import Console
from rich.table import Table

from torsio.perception import VIBRATION_NM
from torsio.printed.scenes import MAX_TORQUE_NM
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
    turning = partial(Case, "turning")
    integers = "positions are integers, only differences become float"
    sensed = partial(turning, "error of the sensed torque (N m)", 1e-6, integers)
    for hours in (1.0, 10.0, 1000.0):
        yield sensed(f"{hours:g} h at 10 rev/s", *numbers.turning_error_nm(hours))
    hours = 0.1 if quick else 10.0
    ticks = round(3.6e6 * hours)
    naive = _float_step(2.0 * math.pi * numbers.REVS_PER_S * 3600 * hours) / runs.COUNT_RAD
    wrong = numbers.turned_in_full(hours)
    yield turning("wrong counts", 0.0, integers, f"all {ticks} ticks of {hours:g} h", naive, wrong)
    yield turning(
        "error of the motor's torque (N m)",
        1e-5,
        "angles travel as 64-bit fixed-point turns",
        "a wall 1000 h of turning away",
        runs.per_degree(30) * _float_step(2.0 * math.pi * 3.6e7),
        numbers.far_wall_error_nm(1000.0),
    )
    yield turning(
        "change of its speed (rad/s)",
        1e-9,
        "the plant's angle is whole turns and a rest",
        "the emulated knob itself 1000 h away",
        numbers.naive_far_plant_speed_error_rad_s(1000.0),
        numbers.far_plant_speed_error_rad_s(1000.0),
    )


def _float_step(angle_rad: float) -> float:
    """Half the distance between neighbouring 32-bit floats there."""
    return 0.5 * float(2.0 ** (math.floor(math.log2(angle_rad)) - 23))


def _wraps() -> Iterator[Case]:
    sensed = partial(
        Case,
        "counter wraps",
        "error of the sensed torque (N m)",
        1e-9,
        "differences modulo the counter's width",
    )
    for bits in (16, 32):
        yield sensed(f"{bits}-bit counter, in a wall", *numbers.wrap_errors_nm(bits))


def _clocks() -> Iterator[Case]:
    wraps = partial(Case, "clock wraps")
    yield wraps(
        "error of a step of time (s)",
        1e-9,
        "the device counts ticks in 64 bits",
        "32-bit microseconds, after 71.6 min",
        *numbers.microsecond_errors_s(),
    )
    periodic = partial(
        wraps,
        "error of a periodic torque (share of its amplitude)",
        1e-6,
        "phases are integers that wrap as periods do",
    )
    for name, tick in (("2^32 ticks, 50 days", 2**32 - 500), ("1000 h of a sine", 3_600_000_000)):
        yield periodic(name, *numbers.clock_errors(tick))


def _stiffness() -> Iterator[Case]:
    stiff = partial(Case, "stiffness")
    peak = partial(
        stiff,
        "peak torque commanded to the motor (N m)",
        1.0000001 * runs.MOTOR_NM,
        "the last step before the motor is its limit",
    )
    for stiffness in dynamics.STIFFNESSES:
        yield peak(
            f"wall of {stiffness:g} N m/rad",
            dynamics.stiff_wall_torque_nm(stiffness, motor_limit_nm=MAX_TORQUE_NM),
            dynamics.stiff_wall_torque_nm(stiffness),
        )

    # How stiff the shaft itself is: the plain variant is Runge-Kutta 4 at the same steps.
    swing = partial(
        stiff,
        "error of its free swing (share of the amplitude)",
        1e-6,
        "the plant is stepped with the matrix exponential",
    )
    for stiffness in dynamics.SHAFT_STIFFNESSES:
        yield swing(
            f"shaft of {stiffness:g} N m/rad", *_both(dynamics.shaft_swing_error, stiffness)
        )
    step = partial(
        stiff,
        "change of the motion with the step (share of the peak)",
        1e-6,
        "matrix exponentials between events that are located",
    )
    for stiffness in dynamics.SHAFT_STIFFNESSES:
        yield step(
            f"shaft of {stiffness:g} N m/rad, friction",
            *_both(dynamics.shaft_step_error, stiffness),
        )


def _both(measure: Callable[..., float], *given: float) -> tuple[float, float]:
    """Give a measure of the plain plant's steps, and of the exact ones."""
    return measure(*given, "regularised"), measure(*given, "exact")


def _shares() -> Iterator[Case]:
    critical = partial(
        Case,
        "critical torque",
        "error of the formula against the experiment (relative)",
        0.03,
        "the brake's own limit removes the poles",
    )
    cases = ((1.0, 1.0), (0.5, 1.0), (1.5, 1.0), (2.0, 0.5), (0.5, 0.0))
    for (ratio, beta), errors in zip(cases, dynamics.critical_errors(cases), strict=True):
        yield critical(f"beta {beta:g}, Kve = {ratio:g} K", *errors)
    guard = "the sensor says when the brake must let go"
    for beta in (0.0, 1.0):
        yield Case(
            "beta",
            "tracking error out of a wall (share of the peak)",
            0.15,
            guard,
            f"beta {beta:g} in closed loop",
            dynamics.share_error(beta, "parallel"),
            dynamics.share_error(beta, "paper"),
        )
    yield Case(
        "beta",
        "torque that the knob is stuck with (N m)",
        dynamics.HELD_BY_FRICTION_NM,
        guard,
        "beta 1, the string is cut in a wall",
        dynamics.stuck_torque_nm("parallel", 1.0),
        dynamics.stuck_torque_nm("paper", 1.0),
    )


def _friction() -> Iterator[Case]:
    friction, set_valued = (
        partial(Case, "friction"),
        "friction is set-valued: at rest it is what holds",
    )
    yield friction(
        "motion that is left after 1 s (rad)",
        1e-9,
        set_valued,
        "motor weaker than friction, string cut",
        *_both(dynamics.weak_motor_motion_rad),
    )
    yield friction(
        "speed of the knob (rad/s)",
        0.0,
        set_valued,
        "a torque that friction holds",
        *_both(dynamics.creep_rad_s),
    )
    travel = []
    for guarded in (False, True):
        _, angle = dynamics.free_air(guarded)
        travel.append(float(abs(angle[-1] - angle[len(angle) // 2])))
    yield friction(
        "travel in the second half of a second after a flick (rad)",
        1e-3,
        "no torque is asked: none is given",
        "free air, floor of the sensor above friction and drag",
        *travel,
    )


def _brake_lag() -> Iterator[Case]:
    lags, exponential = partial(Case, "brake lag"), "the exponential is exact for a held command"
    for ratio in (0.1, 1.0, 2.5, 10.0):
        euler, model, exact = dynamics.brake_step(ratio)
        yield lags(
            "largest error of the modelled torque (N m)",
            1e-7,
            exponential,
            f"control period {ratio:g} times the time constant",
            float(abs(euler - exact).max()),
            float(abs(model - exact).max()),
        )
    for lag in dynamics.TIME_CONSTANTS_S:
        yield lags(
            "tracking error into a wall (share of the peak)",
            0.15,
            "the sensor is bounded by what the brake holds by now, and the motor gives the rest",
            f"time constant {lag:g} s in closed loop",
            dynamics.lag_tracking(lag, modelled_s=0.0),
            dynamics.lag_tracking(lag, modelled_s=lag),
        )
    cases = [(1_000_000, lag) for lag in dynamics.TIME_CONSTANTS_S] + [(10_000_000, 1e-3)]
    for period_ns, lag in cases:
        yield lags(
            "error of the modelled torque (N m)",
            1e-6,
            exponential,
            f"{1e-6 * period_ns:g} ms steps, time constant {lag:g} s, closed loop",
            *dynamics.brake_model_errors_nm(period_ns, lag),
        )


def _inertia() -> Iterator[Case]:
    energy = partial(
        Case,
        "inertia ratio",
        "energy that appears from nothing (relative)",
        1e-7,
        "the plant is stepped with the matrix exponential",
    )
    for ratio in dynamics.INERTIA_RATIOS:
        yield energy(f"brake over knob {ratio:g}", *_both(dynamics.energy_error, ratio))


def _rounding() -> Iterator[Case]:
    for measure, case, counts in (
        (
            "ticks with a subnormal state",
            "the controller, a released brake for 60 s",
            numbers.subnormal_ticks,
        ),
        (
            "subnormal torques of motor and brake in 798 looks",
            "the emulated knob, a released brake for 60 s",
            numbers.subnormal_plant_states,
        ),
    ):
        guard = "decaying states end at exactly 0"
        yield Case("subnormals", measure, 0.0, guard, case, *counts())


def _delay() -> Iterator[Case]:
    left = partial(Case, "delay", "torque above 20 Hz after 1 s (N m)", VIBRATION_NM)
    vibration = dynamics.bounce_vibration_nm
    late = vibration(7.0, "paper", delay_ticks=1)
    yield left(
        "a command acts in the tick that took the count",
        "7 N m/rad: a tick late, and not",
        late,
        vibration(7.0, "paper"),
    )
    yield left(
        "a faster loop has a shorter tick",
        "7 N m/rad, a tick late: 1 kHz, and 10 kHz",
        late,
        vibration(7.0, "paper", delay_ticks=1, rate_hz=10_000.0),
    )
    yield left(
        "the brake takes half of the torque, and dissipates",
        "1.5 N m/rad, a tick late: motor alone, and brake",
        vibration(1.5, "motor_only", delay_ticks=1),
        vibration(1.5, "paper", delay_ticks=1),
    )


def _not_finite() -> Iterator[Case]:
    offered, accepted = not_finite.accepted_in_python()
    tried, spoiled = not_finite.spoiled_for_good()
    yield Case(
        "not finite",
        "values that were accepted, or change the motor's torque for good",
        0.0,
        "every value is checked before anything has effect",
        f"in {offered // 3} quantities of Python; {tried} values into the bare law",
        spoiled,
        accepted,
    )


def _precision() -> Iterator[Case]:
    precise = partial(
        Case,
        "precision",
        "32 against 64 bits: difference of the motor's torque (N m)",
        1e-6,
        "large numbers are integers, floats stay small",
    )
    wall, wall_s = runs.per_degree(30), runs.PUSH_DURATION_S
    cases = (
        ("into a wall and out, law 'paper'", runs.push_options(wall, "paper"), wall_s),
        ("into a wall and out, law 'compensated'", runs.push_options(wall, "compensated"), wall_s),
        ("a virtual spring beyond its limit", runs.bounce_options(15.0), 1.0),
    )
    naive = numbers.turning_error_nm(1.0)[0]
    for case, options, duration_s in cases:
        _, difference = numbers.precision_trace(options, duration_s)
        yield precise(case, naive, float(abs(difference).max()))


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
