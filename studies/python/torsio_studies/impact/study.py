"""`torsio study impact`: whether a wall's knock is at the knob as it was asked for."""

from __future__ import annotations

from dataclasses import asdict

from rich.console import Console

from torsio.common.screen import table
from torsio_studies.common import Results, Study
from torsio_studies.impact import figure, trials

SPEEDS_RAD_S = (0.5, 1.0, 1.5, 2.0)
FREQUENCIES_HZ = (150.0, 300.0, 500.0)
DECAYS_S = (3e-3, 5e-3, 10e-3)
SHOWN_RAD_S = 1.0


def run(study: Study) -> Results:
    """Run the study."""
    taps = [(speed, trials.CUE) for speed in SPEEDS_RAD_S]
    if not study.quick:
        taps += [
            (SHOWN_RAD_S, trials.with_cue(frequency_hz=frequency_hz, decay_s=decay_s))
            for frequency_hz in FREQUENCIES_HZ
            for decay_s in DECAYS_S
        ]
    rows = []
    shown = None
    for speed, impact in study.track(taps, "a finger taps a wall"):
        tap = trials.tap(speed, impact)
        if speed == SHOWN_RAD_S and impact == trials.CUE:
            shown = tap
        rows.append(_row(tap))
    assert shown is not None
    figure.draw(study, shown, rows)
    return {
        "rows": rows,
        "wall_nm_per_rad": trials.WALL_NM_PER_RAD,
        "control_rate_hz": trials.RATE_HZ,
        "counts_per_rev": trials.COUNTS,
        "inertia_kg_m2": trials.inertia_kg_m2(),
    }


def _row(tap: trials.Tap) -> Results:
    found = trials.fit_sine(tap)
    impact = tap.impact
    expected = impact.strength_nm_s_per_rad * tap.speed_rad_s / trials.inertia_kg_m2()
    return {
        "speed_rad_s": tap.speed_rad_s,
        "frequency_hz": impact.frequency_hz,
        "decay_s": impact.decay_s,
        "found": asdict(found),
        "expected_rad_s2": expected,
        "peak_hz": trials.peak_hz(tap.acceleration_rad_s2),
        "energy_j": tap.energy_j,
        "given_j": tap.given_j,
    }


def show(results: Results, console: Console) -> None:
    """Print what was asked for beside what was found at the knob."""
    printed = table(
        "speed\nrad/s", "asked\nHz", "found\nHz", "peak\nHz", "asked\nms", "found\nms",
        "asked\nrad/s²", "found\nrad/s²", "rest",
    )  # fmt: skip
    for row in results["rows"]:
        found = row["found"]
        printed.add_row(
            f"{row['speed_rad_s']:.2f}",
            f"{row['frequency_hz']:.0f}",
            f"{found['frequency_hz']:.0f}",
            f"{row['peak_hz']:.0f}",
            f"{1e3 * row['decay_s']:.1f}",
            f"{1e3 * found['decay_s']:.1f}",
            f"{row['expected_rad_s2']:.0f}",
            f"{found['amplitude_rad_s2']:.0f}",
            f"{100 * found['rest']:.0f} %",
        )
    console.print(printed, highlight=False)
