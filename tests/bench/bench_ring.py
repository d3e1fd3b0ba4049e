"""Steps or a chirp: what tells more of the knob's side of the shaft, as JSON lines.

``./dev bench ring`` measures hidden knobs 20 to 39 of `torsio study calibration`, on which none of
its figures is counted, with the brake held: once by the torque steps that `torsio calibrate` plays,
and by sines that rise from 10 to 130 Hz in as much of the knob's time, of 1.3, 1.7 and 2.2 times
the true friction of the knob's side, which a calibration would have to guess. A line tells for one
knob the errors of inertia and damping and what the fit states of them, as shares, or why it was
refused; the last of each excitation their medians, and what nine of ten errors are below.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

import torsio
from torsio.calibration.brake import hold_and_let_go
from torsio.calibration.free import estimate_free, find_signs, spin
from torsio.calibration.play import Player
from torsio.calibration.quantity import Refusal
from torsio.calibration.shaft import estimate_shaft, hold_and_push
from torsio_studies.calibration.knobs import emulated, hidden_knob, truth_of

KNOBS = range(20, 40)
QUANTITIES = ("knob_inertia_kg_m2", "shaft_damping_nm_s_per_rad")
MOTOR_NM, BRAKE_NM = 85e-3, 0.1
CHIRP_S, FROM_HZ, TO_HZ = 1.7, 10.0, 130.0
OF_FRICTION = (None, 1.3, 1.7, 2.2)  # None: steps


def measure(number: int, of_friction: float | None) -> dict[str, Any]:
    """Measure one knob; errors and stated uncertainties as shares of the truth."""
    hidden = hidden_knob(number)
    truth = truth_of(hidden.plant)
    by = "steps" if of_friction is None else f"chirp of {of_friction} times the friction"
    row: dict[str, Any] = {"number": number, "by": by}
    shake = None
    if of_friction is not None:
        sine = {
            "sine_nm": of_friction * truth["knob_coulomb_nm"], "sine_begin_hz": FROM_HZ,
            "sine_end_hz": TO_HZ,
        }  # fmt: skip
        shake = [(CHIRP_S, sine)]
    with emulated(hidden.plant, seed=number) as knob, Player.playing(knob) as player:
        hold_and_let_go(player, BRAKE_NM)
        find_signs(player, MOTOR_NM, torsio.ActuatorConfig().knob_inertia_kg_m2)
        free = estimate_free(spin(player, MOTOR_NM))
        held = hold_and_push(
            player, motor_nm=MOTOR_NM, brake_nm=BRAKE_NM, shake=shake,
            coulomb_nm=free.coulomb.value,
        )  # fmt: skip
        try:
            shaft = estimate_shaft(*held, free.cogging.torque_nm, free.inertia.value)
        except Refusal as refusal:
            return row | {"refused": str(refusal)}
    for name, found in zip(QUANTITIES, (shaft.knob_inertia, shaft.damping), strict=True):
        assert found is not None
        row[f"{name}_error"] = found.value / truth[name] - 1.0
        row[f"{name}_stated"] = found.standard_uncertainty / truth[name]
    return row


def main(arguments: list[str]) -> None:
    """Measure all, or the knobs whose numbers are given."""
    numbers = [int(one) for one in arguments] or list(KNOBS)
    for of_friction in OF_FRICTION:
        rows = []
        for number in numbers:
            rows.append(measure(number, of_friction))
            print(json.dumps(rows[-1]), flush=True)
        known = [row for row in rows if "refused" not in row]
        figures: dict[str, Any] = {
            "by": rows[0]["by"],
            "knobs": len(rows),
            "refused": len(rows) - len(known),
        }
        for name in known[0] if known else ():
            if name.endswith(("error", "stated")):
                sizes = np.abs([row[name] for row in known])
                figures[name] = float(np.median(sizes))
                if name.endswith("error"):
                    figures[f"{name}_nine_of_ten"] = float(np.quantile(sizes, 0.9))
        print(json.dumps(figures), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
