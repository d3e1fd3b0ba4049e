"""What the paper says, beside what came out."""

from __future__ import annotations

import math
from typing import Any

from torsio.studies import paper_runs as runs
from torsio.studies.common import Results

__all__ = ["statements"]


def statements(results: Results) -> list[dict[str, str]]:
    """Give the table's rows; a verdict is "holds", "partly", "wrong" or "not found"."""
    return [
        *_formulas(results),
        *_characterisation(results),
        *_scenario_1(results["scenario_1"]),
        *_scenario_2(results["scenario_2"]),
        *_scenario_3(results["scenario_3"]),
    ]


def _row(where: str, paper: str, found: str, verdict: str) -> dict[str, str]:
    return {"where": where, "paper": paper, "found": found, "verdict": verdict}


def _formulas(results: Results) -> list[dict[str, str]]:
    stiff = 3.0 * runs.SHAFT_NM_PER_RAD
    printed = stiff / (stiff - min(runs.SHAFT_NM_PER_RAD, 0.5 * stiff)) * runs.MOTOR_NM
    depth = runs.MOTOR_NM / max(stiff - runs.SHAFT_NM_PER_RAD, 0.5 * stiff)
    as_min = runs.MOTOR_NM / min(stiff - runs.SHAFT_NM_PER_RAD, 0.5 * stiff)
    zero = max(
        abs(row["found"] - max(0.0, row["formula"])) for row in results["zero_crossing"]["rows"]
    )
    error = 100 * results["critical_torque"]["largest_error"]
    return [
        _row(
            "eq. (7)",
            "the motor's limit is met at the min of two slopes",
            f"the max: at 3 K the limit is met at {1e3 * depth:.1f} mrad, not at "
            f"{1e3 * as_min:.1f}",
            "wrong",
        ),
        _row(
            "eq. (8)",
            f"critical torque of stiff walls ({1e3 * printed:.0f} mN·m at 3 K)",
            f"found within {error:.1f} %, with (11) and the brake's limit, over all beta",
            "holds",
        ),
        _row(
            "eq. (11)",
            "critical torque of soft walls; 'if beta Kve > K'",
            "the formula holds, for Kve < K; the condition is misprinted",
            "partly",
        ),
        _row(
            "sec. II-D",
            "no limit from the brake",
            f"never above {1e3 * (runs.MOTOR_NM + runs.BRAKE_NM):.0f} mN·m, motor and "
            f"brake together",
            "wrong",
        ),
        _row(
            "fig. 3, P8",
            "the shaft is empty inside a soft wall",
            f"at the depth (1 - beta Kve/K), within {100 * zero:.1f} % of it on the ideal plant",
            "holds",
        ),
    ]


def _characterisation(results: Results) -> list[dict[str, str]]:
    one = results["characterisation"]["linear"]
    slope = one["slope_nm_per_rad"]
    quantum = runs.SHAFT_NM_PER_RAD * runs.COUNT_RAD
    return [
        _row(
            "fig. 6",
            "K = 2.873 N·m/rad, or 35 mN·m/deg",
            f"the ramp gives {slope:.3f} N·m/rad; that is {1e3 * math.radians(slope):.1f} mN·m/deg",
            "wrong",
        ),
        _row(
            "sec. IV",
            "smallest change of torque seen: 2.2 mN·m, with 8192 'pulses'",
            f"{1e3 * quantum:.2f} mN·m with 8192 counts; with as many pulses it would be "
            f"{1e3 * quantum / 4:.2f}",
            "partly",
        ),
    ]


def _limit(scenario: Results, **loop: Any) -> float:
    wanted = {"law": "paper", "control_rate_hz": 1000.0, "delay_ticks": 0, **loop}
    for row in scenario["limits"]:
        if all(row[key] == value for key, value in wanted.items()):
            return float(row["stable_to_nm_per_rad"])
    raise KeyError(str(wanted))


def _scenario_1(scenario: Results) -> list[dict[str, str]]:
    limit = _limit(scenario)
    calm = [
        row
        for row in scenario["rows"]
        if row["law"] == "paper"
        and row["control_rate_hz"] == 1000.0
        and row["delay_ticks"] == 0
        and row["stiffness_nm_per_rad"] <= limit
    ]
    crossings = [row["crossings"] for row in calm]
    shaft = [
        row["crossings"]
        for row in calm
        if abs(row["stiffness_nm_per_rad"] / runs.SHAFT_NM_PER_RAD - 1) < 0.25
    ]
    return [
        _row(
            "scenario 1",
            "few bounces, much the same below 10 N·m/rad, unstable beyond",
            f"{min(crossings)} to {max(crossings)} bounces up to {limit:.1f} N·m/rad, then no rest",
            "holds",
        ),
        _row(
            "scenario 1",
            "another instability where Kve = K",
            f"{max(shaft, default=0)} bounces near K, like elsewhere: not seen here",
            "not found",
        ),
        _row(
            "scenario 1",
            "'with the brake turned off'",
            "only while spinning up: with the brake off throughout, the motor alone is stable to "
            f"{_limit(scenario, law='motor_only'):.1f} N·m/rad",
            "partly",
        ),
    ]


def _scenario_2(scenario: Results) -> list[dict[str, str]]:
    rows = [row for row in scenario["rows"] if row["pull_s"] == runs.PULL_S]
    soft, stiff = rows[0], rows[-1]
    worst_in = max(row["tracking_rms_in"] for row in rows)
    worst_out = max(row["tracking_rms_out"] for row in rows)
    gap = next(row for row in rows if round(row["wall_mnm_per_deg"]) == 30)
    gap_depth = gap["peak_torque_nm"] / 30e-3 * gap["zero_crossing"]
    return [
        _row(
            "scenario 2",
            "stiff walls are followed closely",
            f"at {stiff['wall_mnm_per_deg']:.0f} mN·m/deg within "
            f"{100 * stiff['tracking_rms_in']:.1f} % in and "
            f"{100 * stiff['tracking_rms_out']:.1f} % out; no wall worse than "
            f"{100 * worst_in:.1f} and {100 * worst_out:.1f} % (RMS of the peak)",
            "holds",
        ),
        _row(
            "scenario 2",
            "soft walls show a torque gap on the way out",
            f"{1e3 * soft['torque_gap_nm']:.0f} mN·m at {soft['wall_mnm_per_deg']:.0f} mN·m/deg, "
            f"{1e3 * stiff['torque_gap_nm']:.0f} at {stiff['wall_mnm_per_deg']:.0f}",
            "holds",
        ),
        _row(
            "scenario 2",
            "the gap is at 1.7 and 3.4 rad",
            f"degrees: at 30 mN·m/deg it begins at a depth of {gap_depth:.1f} degrees",
            "wrong",
        ),
        _row(
            "scenario 2",
            "total torque Tb + Tm",
            "what the hand feels is Tk + Tm: the brake only bounds Tk",
            "wrong",
        ),
    ]


def _scenario_3(scenario: Results) -> list[dict[str, str]]:
    def cut(law: str, wall: float, rigid: bool = False) -> Results:
        for row in scenario["rows"]:
            stiff = row["shaft_nm_per_rad"] > runs.SHAFT_NM_PER_RAD
            if row["law"] == law and row["wall_mnm_per_deg"] == wall and stiff == rigid:
                return dict(row)
        raise KeyError(law)

    paper = cut("paper", 25.0)
    soft = cut("paper", 10.0)
    rigid = cut("parallel", 25.0, rigid=True)
    return [
        _row(
            "scenario 3",
            "the knob leaves the wall by itself when the string is cut",
            f"yes, {1e3 * paper['exit_s']:.0f} ms after the cut; from a wall of 10 mN·m/deg "
            + (
                "too"
                if soft["exit_s"] is not None
                else f"friction stops it, at {1e3 * soft['stuck_torque_nm']:.1f} mN·m"
            ),
            "holds",
        ),
        _row(
            "scenario 3",
            "brake and motor in parallel without a sensor would stick",
            f"they do, at {1e3 * rigid['stuck_torque_nm']:.0f} of {1e3 * runs.WEIGHT_NM:.0f} mN·m",
            "holds",
        ),
        _row(
            "scenario 3",
            "a wall of 25 mN·m/rad",
            "mN·m/deg: 50 mN·m would press 2 rad into the former",
            "wrong",
        ),
    ]
