"""Output, questions and files of `torsio calibrate`."""

from __future__ import annotations

import re
from dataclasses import asdict
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from rich.console import Console

from torsio import calibration
from torsio.calibration import report
from torsio.common.screen import line, table
from torsio.common.whole_file import beside
from torsio.knob import Knob

_UNIT = re.compile("_(ohm|h|nm_per_a)$")

__all__ = ["draw", "measure", "save", "show", "words_of"]


def measure(
    knob: Knob,
    say: Console,
    *,
    drift: bool,
    ambient_c: float | None,
    supply_v: float | None,
) -> dict[str, Any]:
    """Calibrate with a line of progress a step, and give all as JSON has it."""
    before = calibration.kept(knob.info.serial)
    board = knob.board_config()
    watched = board.supply_sense_pin != 0 or not knob.motor_current().measured
    if not (drift or watched or supply_v is not None):
        line(
            say,
            f"supply   taken for {board.supply_v:g} V. Measure it and give --supply VOLTS. "
            "Otherwise the torque constant stays uncertain, and the configured one is kept",
        )
    lasts = "13 seconds" if drift else "half a minute"
    say.print(f"hands off: the knob turns by itself for {lasts}")

    def step(name: str) -> None:
        say.print(f"step     {name}")

    found = calibration.calibrate(
        knob, drift=drift, ambient_c=ambient_c, supply_v=supply_v, progress=step
    )
    changed = [] if before is None else calibration.drifts(before, found)
    return {
        "calibration": found,
        "changed": changed,
        "compared_with": None if before is None else before["conditions"].get("date"),
    }


def show(knob: Knob, measured: dict[str, Any], out: Console) -> None:
    """Print what was found, what has drifted, and what is proposed."""
    found: calibration.Calibration = measured["calibration"]
    headings = ("quantity", "value +- standard uncertainty", "to a finger", "what it is")
    quantities = table(*headings, words=len(headings))
    for row in report.lines(found):
        quantities.add_row(*row)
    out.print(quantities)
    out.print("all torques are as true as the motor's torque constant")
    out.print(f"\n{found.seconds:.0f} s of the knob's time")
    if not found.conditions["current_measured"]:
        out.print(
            "this device does not measure the motor's current: its winding and its torque constant "
            "stay as they are configured"
        )
    if measured["compared_with"] is not None:
        out.print(
            f"compared with {measured['compared_with']}: "
            + ("nothing has drifted" if not measured["changed"] else "drifted"),
        )
        for drift in measured["changed"]:
            out.print(f"  {report.change(drift.name, drift.before, drift.now)}")
    proposed = report.proposals(knob, found)
    if proposed:
        out.print("\nproposed for the configuration:")
    for name, old, new in proposed:
        out.print(f"  {report.change(name, old, new)}{report.cause(name, old, new)}")
    if found.board is not None:
        out.print("the motor's values take effect when you plug the knob in again")


def save(knob: Knob, found: calibration.Calibration, say: Console) -> None:
    """Configure the device as proposed, keep that in its flash, and all findings in a file."""
    calibration.apply(knob, found)
    knob.save()
    path = calibration.keep(found)
    where = "until this command ends" if knob.is_emulated else "on the device"
    line(say, f"saved    {where}, and all that was found in {path}")


def draw(found: calibration.Calibration, picture: Path, say: Console) -> None:
    """Draw all fits and their residuals."""
    with beside(picture) as part:
        found.plot().savefig(part)
    line(say, f"picture  {picture}")


def words_of(knob: Knob) -> dict[str, Any]:
    """Give what `torsio info` shows of how well the values of a knob are known."""
    known = knob.calibration_config()
    if known.values_are == "assumed":
        return {"values_are": "assumed; torsio calibrate measures them"}
    words: dict[str, Any] = {"values_are": known.values_are}
    if known.calibrated_unix_s:
        when = datetime.fromtimestamp(known.calibrated_unix_s, timezone.utc)
        words["date"] = when.isoformat(timespec="seconds")
        words["control_rate_hz"] = known.calibrated_rate_hz
    if known.ambient_k:
        words["ambient_c"] = round(known.ambient_k - 273.15, 1)
    values = asdict(knob.actuator_config()) | asdict(knob.shaft_config())
    for name, sigma in asdict(known).items():
        of = name.removeprefix("sigma_")
        if of != name and of in values and sigma:
            words[of] = report.number(values[of], sigma)
    board = asdict(knob.board_config())
    for of in ("motor_resistance_ohm", "motor_inductance_h", "motor_torque_constant_nm_per_a"):
        permille = getattr(known, f"sigma_{_UNIT.sub('', of)}_permille")
        if permille:
            words[of] = f"{board[of]:.4g} +- {0.1 * permille:.1f} %"
    law = knob.control_config().law
    uses = ", which uses" if law == "calibrated" else "; calibrated would use"
    words["law"] = f"{law}{uses} all of these values"
    return words
