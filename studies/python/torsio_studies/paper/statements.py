"""The paper's statements beside our results; the numbers decide every verdict."""

from __future__ import annotations

import math
from typing import Any

from torsio import perception
from torsio_studies.common import Results
from torsio_studies.paper import critical, runs

FORMULA_ERROR = 0.03
"""Up to here a formula holds: the bisection, and the ticks, leave less than that."""


def statements(results: Results) -> list[dict[str, str]]:
    """Give the table's rows; a verdict is "holds", "partly", "wrong" or "not found"."""
    return [
        *_formulas(results),
        *_characterisation(results["characterisation"]["linear"]["slope_nm_per_rad"]),
        *_scenario_1(results["scenario_1"]),
        *_scenario_2(results["scenario_2"]),
        *_scenario_3(results["scenario_3"]),
    ]


def _row(where: str, paper: str, found: str, verdict: str) -> dict[str, str]:
    return {"where": where, "paper": paper, "found": found, "verdict": verdict}


def _near(value: float, wanted: float, relative: float = FORMULA_ERROR) -> bool:
    return abs(value - wanted) <= relative * abs(wanted)


def _formulas(results: Results) -> list[dict[str, str]]:
    rows = results["critical_torque"]["rows"]
    stiff = [row for row in rows if row["stiffness_ratio"] > 1.0]
    soft = [row for row in rows if row["stiffness_ratio"] <= 1.0]
    half = [row for row in stiff if row["beta"] == 0.5]
    one = min(half, key=lambda row: abs(row["stiffness_ratio"] - 3.0))
    return [
        _limit_of_the_motor(one),
        _critical_torque_of_stiff_walls(one, _worst(stiff), _worst(rows)),
        _critical_torque_of_soft_walls(soft),
        _limit_of_the_brake(rows),
        _empty_shaft(results["zero_crossing"]["rows"]),
    ]


def _worst(rows: list[Results]) -> float:
    return max(abs(float(row["error"])) for row in rows)


def _limit_of_the_motor(one: Results) -> dict[str, str]:
    ratio = one["stiffness_ratio"]
    stiffness = ratio * runs.SHAFT_NM_PER_RAD
    slopes = (stiffness - runs.SHAFT_NM_PER_RAD, 0.5 * stiffness)
    depth = one["found_nm"] / stiffness
    as_min, as_max = (runs.MOTOR_NM / pick(slopes) for pick in (min, max))
    return _row(
        "eq. (7)",
        "the motor's limit is met at the min of two slopes",
        f"the max: at {ratio:.1f} K the limit is met at {1e3 * depth:.1f} mrad, not at "
        f"{1e3 * as_min:.1f}",
        "holds" if _near(depth, as_min) else "wrong" if _near(depth, as_max) else "not found",
    )


def _critical_torque_of_stiff_walls(
    one: Results, stiff_error: float, error: float
) -> dict[str, str]:
    told = f"({1e3 * one['formula_nm']:.0f} mN·m at {one['stiffness_ratio']:.1f} K)"
    return _row(
        "eq. (8)",
        f"critical torque of stiff walls {told}",
        f"found within {100 * error:.1f} %, with (11) and the brake's limit, over all beta",
        "holds" if stiff_error <= FORMULA_ERROR else "wrong",
    )


def _critical_torque_of_soft_walls(soft: list[Results]) -> dict[str, str]:
    error = _worst(soft)
    condition_met = any(row["beta"] * row["stiffness_ratio"] > 1.0 for row in soft)
    return _row(
        "eq. (11)",
        "critical torque of soft walls; 'if beta Kve > K'",
        f"found within {100 * error:.1f} % for Kve < K, where that condition is "
        + ("met" if condition_met else "never met"),
        "wrong" if error > FORMULA_ERROR else "holds" if condition_met else "partly",
    )


def _limit_of_the_brake(rows: list[Results]) -> dict[str, str]:
    most = max(row["found_nm"] for row in rows)
    beyond = any(
        critical.printed_critical_torque(row["stiffness_ratio"], row["beta"])
        > (1.0 + FORMULA_ERROR) * max(row["found_nm"], most)
        for row in rows
    )
    return _row(
        "sec. II-D",
        "no limit from the brake",
        f"never above {1e3 * most:.0f} mN·m, of {1e3 * (runs.MOTOR_NM + runs.BRAKE_NM):.0f} that "
        "motor and brake have together",
        "wrong" if beyond else "holds",
    )


def _empty_shaft(rows: list[Results]) -> dict[str, str]:
    zero = max(abs(row["found"] - max(0.0, row["formula"])) for row in rows)
    return _row(
        "fig. 3, P8",
        "the shaft is empty inside a soft wall",
        f"at the depth (1 - beta Kve/K), within {100 * zero:.1f} % of it on the ideal plant",
        "holds" if zero <= 0.01 else "wrong",
    )


def _characterisation(slope: float) -> list[dict[str, str]]:
    per_degree = 1e3 * math.radians(slope)
    quantum = 1e3 * slope * runs.COUNT_RAD
    if _near(slope, 2.873, 0.01):
        fig_6 = "holds" if _near(per_degree, 35.0, 0.01) else "wrong"
    else:
        fig_6 = "partly" if _near(per_degree, 35.0, 0.01) else "not found"
    sec_4 = "holds" if _near(quantum / 4.0, 2.2) else "partly" if _near(quantum, 2.2) else "wrong"
    return [
        _row(
            "fig. 6",
            "K = 2.873 N·m/rad, or 35 mN·m/deg",
            f"the ramp gives {slope:.3f} N·m/rad; that is {per_degree:.1f} mN·m/deg",
            fig_6,
        ),
        _row(
            "sec. IV",
            "smallest change of torque seen: 2.2 mN·m, with 8192 'pulses'",
            f"{quantum:.2f} mN·m with 8192 counts; with as many pulses it would be "
            f"{quantum / 4:.2f}",
            sec_4,
        ),
    ]


def _limit(scenario: Results, **loop: Any) -> float:
    wanted = {"law": "paper", "control_rate_hz": 1000.0, "delay_ticks": 0, **loop}
    for row in scenario["limits"]:
        if all(row[key] == value for key, value in wanted.items()):
            return float(row["stable_to_nm_per_rad"])
    raise KeyError(str(wanted))


def _scenario_1(scenario: Results) -> list[dict[str, str]]:
    limit, motor_limit = _limit(scenario), _limit(scenario, law="motor_only")
    rows = [
        row
        for row in scenario["rows"]
        if row["law"] == "paper" and row["control_rate_hz"] == 1000.0 and row["delay_ticks"] == 0
    ]
    calm = [row["crossings"] for row in rows if row["stiffness_nm_per_rad"] <= limit]
    few, limited = max(calm, default=math.inf) <= 8, 7.0 <= limit <= 15.0
    return [
        _row(
            "scenario 1",
            "few bounces, much the same below 10 N·m/rad, unstable beyond",
            f"{min(calm, default=0)} to {max(calm, default=0)} bounces up to {limit:.1f} N·m/rad, "
            "then no rest",
            "holds" if few and limited else "partly" if few or limited else "wrong",
        ),
        _instability_near_the_shaft(rows),
        _row(
            "scenario 1",
            "'with the brake turned off'",
            "only while spinning up: with the brake off throughout, the motor alone is stable to "
            f"{motor_limit:.1f} N·m/rad",
            "holds" if motor_limit >= 7.0 else "partly",
        ),
    ]


def _instability_near_the_shaft(rows: list[Results]) -> dict[str, str]:
    near = [
        row for row in rows if abs(row["stiffness_nm_per_rad"] / runs.SHAFT_NM_PER_RAD - 1) < 0.25
    ]
    bounces = max((row["crossings"] for row in near), default=0)
    left = ("crossings", "oscillation_rad", "vibration_nm")
    swings = not all(runs.Bounces(*(row[name] for name in left)).at_rest for row in near)
    return _row(
        "scenario 1",
        "another instability where Kve = K",
        f"{bounces} bounces near K, and no rest"
        if swings
        else f"{bounces} bounces near K, like elsewhere: not seen here",
        "holds" if swings else "not found",
    )


def _scenario_2(scenario: Results) -> list[dict[str, str]]:
    rows = [row for row in scenario["rows"] if row["pull_s"] == runs.PULL_S]
    soft, stiff = rows[0], rows[-1]
    worst_in = max(row["tracking_rms_in"] for row in rows)
    worst_out = max(row["tracking_rms_out"] for row in rows)
    follows = stiff["tracking_rms_in"] <= 0.07 and stiff["tracking_rms_out"] <= 0.09
    as_printed = max(row["brake_for_spring_rms"] for row in rows)
    return [
        _row(
            "scenario 2",
            "stiff walls are followed closely",
            f"at {stiff['wall_mnm_per_deg']:.0f} mN·m/deg within "
            f"{100 * stiff['tracking_rms_in']:.1f} % in and "
            f"{100 * stiff['tracking_rms_out']:.1f} % out; no wall worse than "
            f"{100 * worst_in:.1f} and {100 * worst_out:.1f} % (RMS of the peak)",
            "holds" if follows else "wrong",
        ),
        _row(
            "scenario 2",
            "soft walls show a torque gap on the way out",
            f"{1e3 * soft['torque_gap_nm']:.0f} mN·m at {soft['wall_mnm_per_deg']:.0f} mN·m/deg, "
            f"{1e3 * stiff['torque_gap_nm']:.0f} at {stiff['wall_mnm_per_deg']:.0f}; to a finger "
            f"{perception.text(perception.torque_jnds(soft['torque_gap_nm']))} and "
            f"{perception.text(perception.torque_jnds(stiff['torque_gap_nm']))}",
            "holds" if soft["torque_gap_nm"] > 2.0 * stiff["torque_gap_nm"] else "wrong",
        ),
        _place_of_the_gap(rows),
        _row(
            "scenario 2",
            "total torque Tb + Tm",
            "what the hand feels is Tk + Tm: the brake only bounds Tk, and Tb in its place is "
            f"up to {100 * as_printed:.0f} % of the peak off (RMS)",
            "wrong" if as_printed > 0.05 else "holds",
        ),
    ]


def _place_of_the_gap(rows: list[Results]) -> dict[str, str]:
    gap = next(row for row in rows if round(row["wall_mnm_per_deg"]) == 30)
    gap_rad = gap["peak_torque_nm"] / gap["wall_stiffness_nm_per_rad"] * gap["zero_crossing"]
    # Both numbers of the paper, 1.7 and 3.4, and what lies round them.
    in_rad, in_degrees = (1.2 <= depth <= 4.0 for depth in (gap_rad, math.degrees(gap_rad)))
    return _row(
        "scenario 2",
        "the gap is at 1.7 and 3.4 rad",
        f"degrees: at 30 mN·m/deg it begins at a depth of {math.degrees(gap_rad):.1f} degrees",
        "holds" if in_rad else "wrong" if in_degrees else "not found",
    )


def _scenario_3(scenario: Results) -> list[dict[str, str]]:
    def cut(law: str, wall: float, rigid: bool = False) -> Results:
        for row in scenario["rows"]:
            stiff = row["shaft_nm_per_rad"] > runs.SHAFT_NM_PER_RAD
            if row["law"] == law and row["wall_mnm_per_deg"] == wall and stiff == rigid:
                return dict(row)
        raise KeyError(law)

    verdict = {"leaves": "holds", "held by friction": "partly", "stays": "wrong"}
    paper, soft = cut("paper", 25.0), cut("paper", 10.0)
    rigid, parallel = cut("parallel", 25.0, rigid=True), cut("parallel", 25.0)
    as_printed_rad = runs.WEIGHT_NM / 25e-3
    return [
        _row(
            "scenario 3",
            "the knob leaves the wall by itself when the string is cut",
            f"{_exit(paper)}; from a wall of 10 mN·m/deg: {_exit(soft)}",
            verdict[paper["outcome"]],
        ),
        _row(
            "scenario 3",
            "brake and motor in parallel without a sensor would stick",
            f"{_exit(rigid)}, of {1e3 * runs.WEIGHT_NM:.0f} mN·m, on a shaft of "
            f"{rigid['shaft_nm_per_rad']:.0f} N·m/rad; on the paper's: {_exit(parallel)}",
            "holds" if rigid["outcome"] == "stays" else "wrong",
        ),
        _row(
            "scenario 3",
            "a wall of 25 mN·m/rad",
            f"mN·m/deg: the weight presses {paper['depth_at_cut_rad']:.2f} rad into that, and "
            f"{as_printed_rad:.0f} into the former",
            "holds" if _near(paper["depth_at_cut_rad"], as_printed_rad, 0.5) else "wrong",
        ),
    ]


def _exit(cut: Results) -> str:
    if cut["outcome"] == "leaves":
        return f"it leaves {1e3 * cut['exit_s']:.0f} ms after the cut"
    why = "friction holds it" if cut["outcome"] == "held by friction" else "it sticks"
    return f"{why}, at {1e3 * cut['stuck_torque_nm']:.1f} mN·m"
