"""Knobs of the study of calibration, measured through the RP2350's real binary, as JSON lines.

``./dev bench calibration`` takes the first twenty knobs that ``torsio study calibration`` hides
from the routine, gives each the board's electrics, and calibrates it through the firmware in the
emulated chip, over its USB endpoints. A line tells for one knob what was found of each quantity,
with its standard uncertainty, and the truth; the last line counts how many of the stated 95 %
intervals hold it.

Through the emulated chip a knob takes five to eleven minutes of a core. What is done is kept in
``out/calibration-binary/``, a file for each knob, so a run that was interrupted goes on where it
was. Arguments are ``quick``, for the calibration of 13 seconds, ``emulated``, for the emulated
device in place of the binary, on the same plant, ``pico`` for the RP2040's, and numbers of knobs
instead of all twenty.
"""

from __future__ import annotations

import json
import math
import sys
import time
from pathlib import Path
from typing import Any

from tests.board.pico import choose
from tests.studies.hidden import calibrate_hidden
from torsio_studies.calibration.driven import ALL
from torsio_studies.calibration.knobs import FIRST, hidden_knob
from torsio_studies.common import plain, write_atomically

KNOBS = range(FIRST, FIRST + 20)
FOLDER = Path("out") / "calibration-binary"


def measure(number: int, *, model: str, quick: bool, emulated: bool) -> dict[str, Any]:
    """Calibrate one knob, or give what was found before."""
    kind = ("-emulated" if emulated else "") + ("-quick" if quick else "")
    if model != "pico2":
        kind += f"-{model}"
    path = FOLDER / f"{number}{kind}.json"
    if path.exists():
        return dict(json.loads(path.read_text()))
    begin = time.perf_counter()
    row = calibrate_hidden(hidden_knob(number), quick=quick, emulated=emulated)
    row["seconds"] = round(time.perf_counter() - begin, 1)
    FOLDER.mkdir(parents=True, exist_ok=True)
    write_atomically(path, lambda partial: partial.write_text(json.dumps(plain(row)) + "\n"))
    return dict(json.loads(path.read_text()))


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Count intervals that hold the truth."""
    held: dict[str, list[bool]] = {name: [] for name in ALL}
    for row in rows:
        for name, (value, sigma, truth) in row["found"].items():
            if truth is not None:
                held[name].append(abs(value - truth) <= 1.96 * sigma)
    counts = {name: [sum(of), len(of)] for name, of in held.items() if of}
    return {
        "knobs": len(rows),
        "complete": sum(row["refused"] is None for row in rows),
        "reversed_refused": all(row["refused_rightly"] for row in rows),
        "held_of": counts,
        "coverage": sum(of[0] for of in counts.values())
        / max(1, sum(of[1] for of in counts.values())),
        "hours": round(math.fsum(row["seconds"] for row in rows) / 3600, 2),
    }


def main(arguments: list[str]) -> None:
    """Measure the knobs, one after the other."""
    quick = "quick" in arguments
    emulated = "emulated" in arguments
    numbers = [int(one) for one in arguments if one.isdigit()] or list(KNOBS)
    model = "pico" if "pico" in arguments else "pico2"
    choose(model)
    rows = []
    for number in numbers:
        rows.append(measure(number, model=model, quick=quick, emulated=emulated))
        print(json.dumps(rows[-1]), flush=True)
    print(json.dumps(summary(rows)), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
