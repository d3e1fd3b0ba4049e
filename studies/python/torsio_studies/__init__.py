"""Studies of the Torsio knob: what `torsio study NAME` runs.

A study is a folder whose module `study` has a function ``run(study: common.Study) -> dict`` that
gives its results, and a function ``show(results: dict, console: rich.console.Console) -> None``
that prints them briefly. To add one, add its line here.
"""

from __future__ import annotations

from typing import Final

__all__ = ["STUDIES"]

STUDIES: Final[dict[str, str]] = {
    "paper": "The paper's experiments and formulas again, each statement beside what came out.",
    "actuators": "Rival actuators in the same scenes: what each does well, and where it fails.",
    "design": "Thousands of devices: what motor, brake, shaft, rate and encoder are worth.",
    "calibration": "Emulated knobs with hidden parameters measure themselves; broken ones are "
    "refused.",
    "falsify": "A search that tries to break the law with any knob, belief, scene and hand.",
    "impact": "Whether a wall's knock is at the knob as it was asked for.",
    "fidelity": "Error against speed of every way to simulate the knob, MuJoCo among them.",
    "enclosure": "The exact stepper beside ball arithmetic: errors with digits that are proven.",
    "trade": "Parts and control rate that the simulation of each scene needs.",
    "extremes": "Where numbers break, and what holds there.",
}
"""Name of the folder in this package: what it is about, in one sentence."""
