"""Steps or a chirp: what tells more of the knob's side of the shaft, as JSON lines.

``./dev bench ring`` measures hidden knobs 20 to 39 of `torsio study calibration`, on which none of
its figures is counted, with the brake held: once by the torque steps that `torsio calibrate` plays,
and once by a sine of 1.15 times the friction that rises from 10 to 130 Hz in as much of the knob's
time. A line tells for one knob the errors of inertia and damping and what the fit states of them,
as shares; the last two their medians, and what nine of ten errors are below.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

from torsio.calibration.free import estimate_free, find_signs, spin
from torsio.calibration.play import Player
from torsio.calibration.shaft import estimate_shaft, hold_and_push
from torsio_studies.calibration.knobs import emulated, hidden_knob, truth_of

KNOBS = range(20, 40)
QUANTITIES = ("knob_inertia_kg_m2", "shaft_damping_nm_s_per_rad")
MOTOR_NM, BRAKE_NM = 85e-3, 0.1
CHIRP_S, FROM_HZ, TO_HZ, OF_FRICTION = 1.7, 10.0, 130.0, 1.15


def measure(number: int, *, chirps: bool) -> dict[str, Any]:
    """Measure one knob; errors and stated uncertainties as shares of the truth."""
    hidden = hidden_knob(number)
    with emulated(hidden.plant, seed=number) as knob, Player.playing(knob) as player:
        loose_nm = find_signs(player, MOTOR_NM)
        free = estimate_free(spin(player, MOTOR_NM))
        coulomb_nm = max(free.coulomb.value, 0.5 * loose_nm)
        sine = {
            "sine_nm": OF_FRICTION * coulomb_nm, "sine_begin_hz": FROM_HZ, "sine_end_hz": TO_HZ,
        }  # fmt: skip
        held = hold_and_push(
            player, motor_nm=MOTOR_NM, brake_nm=BRAKE_NM, coulomb_nm=coulomb_nm,
            shake=[(CHIRP_S, sine)] if chirps else None,
        )  # fmt: skip
        shaft = estimate_shaft(*held, free.cogging.torque_nm, free.inertia.value)
    truth = truth_of(hidden.plant)
    row: dict[str, Any] = {"number": number, "by": "chirp" if chirps else "steps"}
    for name, found in zip(QUANTITIES, (shaft.knob_inertia, shaft.damping), strict=True):
        assert found is not None
        row[f"{name}_error"] = found.value / truth[name] - 1.0
        row[f"{name}_stated"] = found.standard_uncertainty / truth[name]
    return row


def main(arguments: list[str]) -> None:
    """Measure all, or the knobs whose numbers are given."""
    numbers = [int(one) for one in arguments] or list(KNOBS)
    for chirps in (False, True):
        rows = []
        for number in numbers:
            rows.append(measure(number, chirps=chirps))
            print(json.dumps(rows[-1]), flush=True)
        table = {
            name: np.abs([row[name] for row in rows])
            for name in rows[0]
            if name.endswith(("error", "stated"))
        }
        medians = {name: float(np.median(of)) for name, of in table.items()}
        most = {
            f"{name}_nine_of_ten": float(np.quantile(of, 0.9))
            for name, of in table.items()
            if name.endswith("error")
        }
        print(json.dumps({"by": rows[0]["by"], "knobs": len(rows), **medians, **most}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
