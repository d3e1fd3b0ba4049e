"""`torsio doctor`: checks a knob and says what to do about each problem.

Facts are gathered in `facts`; small functions, one for each matter, turn facts into findings: about
the system in `linux` and `others`, about the knob in `knob`. Checks that move the knob are in
`drift`, and done only when asked for.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import torsio
from torsio.apps.doctor import others
from torsio.apps.doctor.drift import check_drift
from torsio.apps.doctor.examination import KNOB_CHECKS
from torsio.apps.doctor.facts import (
    Permission,
    UsbKnob,
    examine,
    failure_name,
    find_permission,
    find_usb_knobs,
)
from torsio.apps.doctor.findings import Finding
from torsio.apps.doctor.linux import check_driver, check_permission, check_usb
from torsio.common.emulated import EMULATED, selects_emulated
from torsio.errors import Error

__all__ = ["Finding", "Report", "diagnose", "diagnose_any", "examine_drift"]


@dataclass(frozen=True)
class Report:
    """All findings about one knob, or about there being none."""

    device: str
    findings: list[Finding]

    @property
    def ok(self) -> bool:
        """All is well."""
        return all(finding.ok for finding in self.findings)

    @property
    def reaches_knob(self) -> bool:
        """The knob was opened, and told of itself."""
        return any(finding.check == "firmware" for finding in self.findings)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        findings = [
            {**asdict(finding), "more": finding.more, "links": finding.links}
            for finding in self.findings
        ]
        return {"device": self.device, "ok": self.ok, "findings": findings}


_OPEN_ADVICE = {
    "busy": "close the other program (`fuser -v /dev/hidraw*` names it)",
    "permission": "follow the advice on the permission",
    "protocol": "install firmware and library of the same release: update the older of the two",
    "not_found": "`torsio list` shows what is there",
    "timeout": "plug the knob in again; if that goes on, load its firmware again",
    "failed": "plug the knob in again and run this once more",
}


def check_failure(error: Error) -> Finding:
    """Say what kept the knob from being opened or examined."""
    name = failure_name(error)
    advice = _OPEN_ADVICE
    if sys.platform in others.NAMES:
        advice = _OPEN_ADVICE | others.OPEN_ADVICE
    return Finding("open", False, str(error), advice[name], {"reason": name})


def examine_device(selector: str, **options: Any) -> Iterator[Finding]:
    """Open a knob and judge it; options go to `torsio.open`."""
    try:
        with torsio.open(selector, **options) as knob:
            facts = examine(knob)
    except Error as error:
        yield check_failure(error)
        return
    for check in KNOB_CHECKS:
        yield check(facts)


def examine_drift(selector: str) -> Finding:
    """Open a knob that nobody touches, and see whether anything has drifted."""
    try:
        with torsio.open(selector) as knob:
            return check_drift(knob)
    except Error as error:
        return check_failure(error)


def _examine_plugged_in(knob: UsbKnob, permission: Permission) -> Report:
    findings = [check_usb([knob]), check_driver(knob)]
    device = knob.serial or knob.port
    if knob.node is not None and knob.node.exists:
        device = knob.node.path
        findings.append(check_permission(knob, permission))
        if knob.node.usable:
            findings += examine_device(knob.node.path)
    return Report(device, findings)


def diagnose(selector: str = "", root: Path = Path("/")) -> list[Report]:
    """Examine one knob, or with an empty selector all that are plugged in.

    It takes about three seconds a knob, which stays as it is: what is armed is not disarmed.
    """
    if selects_emulated(selector):
        return [
            Report(
                selector, [*examine_device(selector, emulator=torsio.EmulatorOptions(paced=True))]
            )
        ]
    if sys.platform in others.NAMES:
        return [
            Report(device, [finding, *(examine_device(device) if device else ())])
            for device, finding in others.examine_system(sys.platform, selector)
        ]
    knobs = find_usb_knobs(root)
    permission = find_permission(root)
    if selector:
        meant = [
            knob
            for knob in knobs
            if selector in (knob.serial, knob.port, knob.node.path if knob.node else None)
        ]
        # Otherwise it is a path that sysfs does not show, which opening may explain.
        if not meant:
            return [Report(selector, [check_usb(knobs), *examine_device(selector)])]
        knobs = meant
    if not knobs:
        return [Report("", [check_usb(knobs)])]
    return [_examine_plugged_in(knob, permission) for knob in knobs]


def diagnose_any(selector: str = "") -> list[Report]:
    """Do as `diagnose`, but examine the emulated knob where none is named and none plugged in."""
    reports = diagnose(selector)
    if selector or reports[0].device:
        return reports
    (none,) = reports[0].findings
    note = replace(none, ok=True, text=f"{none.text}; this is about the emulated one")
    return [Report(EMULATED, [note, *diagnose(EMULATED)[0].findings])]
