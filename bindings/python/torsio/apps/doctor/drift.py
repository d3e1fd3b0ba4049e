"""`torsio doctor --drift`: whether anything has drifted since the knob was calibrated."""

from __future__ import annotations

from dataclasses import asdict

from torsio import calibration
from torsio.apps.doctor.findings import Finding
from torsio.calibration import report
from torsio.errors import Error
from torsio.knob import Knob

__all__ = ["check_drift"]

_CALIBRATE = "run `torsio calibrate` with nobody touching the knob, and keep what it finds"


def check_drift(knob: Knob) -> Finding:
    """Calibrate for 13 seconds and compare with what was kept; the knob turns by itself.

    An armed knob, or one with a fault, is left as it is.
    """
    state = knob.health().state
    if state != "disarmed":
        return Finding(
            "drift",
            False,
            f"drift was not measured, because the knob is {state}",
            "disarm it, or clear its fault, and run this again",
            {"state": state},
        )
    try:
        before = calibration.kept(knob.info.serial)
        if before is None:
            text = f"no calibration of {knob.info.serial} was kept to compare with"
            return Finding("drift", False, text, _CALIBRATE)
        now = calibration.calibrate(knob, drift=True)
    except calibration.Refusal as refusal:
        return Finding(
            "drift",
            False,
            f"the quick calibration stopped: {refusal}",
            "take hand and cables off the knob; docs/reference/calibration.md has other causes",
            {"step": refusal.step, "reason": refusal.reason},
        )
    except Error as error:
        return Finding("drift", False, str(error), _CALIBRATE)
    date = before["conditions"].get("date", "an unknown date")
    changed = calibration.drifts(before, now)
    values = {"compared_with": date, "drifts": [asdict(drift) for drift in changed]}
    if not changed:
        return Finding("drift", True, f"nothing has drifted since {date}", values=values)
    return Finding(
        "drift",
        False,
        f"drifted since {date}: "
        + "; ".join(report.change(drift.name, drift.before, drift.now) for drift in changed),
        "if a part was changed, " + _CALIBRATE + "; if not, look at that part first",
        values,
    )
