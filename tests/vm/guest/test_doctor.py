"""What the doctor finds on a real kernel, with a sound knob and with everything else."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TextIO

import pytest

import torsio
from tests.vm.guest.child import Child, become_nobody
from tests.vm.guest.virtual_bus import VirtualKnob, wait_for
from torsio import doctor

pytestmark = pytest.mark.kernel("6.12")

# A busy host makes these worse, and is no fault of the knob.
TIMED = {"clock", "round_trip", "losses", "ticks"}
USBHID = Path("/sys/bus/usb/drivers/usbhid")


def only_report() -> doctor.Report:
    (report,) = doctor.diagnose()
    return report


def problem(report: doctor.Report) -> doctor.Finding:
    (finding,) = [finding for finding in report.findings if not finding.ok]
    assert finding.advice
    return finding


def test_sound_knob_has_nothing_wrong(knob: VirtualKnob) -> None:
    knob.say("still")
    report = only_report()
    assert report.device == str(knob.hidraw)
    checks = [finding.check for finding in report.findings]
    assert checks[:5] == ["usb", "driver", "permission", "firmware", "state"]
    assert set(checks[5:]) == TIMED
    wrong = [finding for finding in report.findings if not finding.ok]
    assert {finding.check for finding in wrong} <= TIMED, wrong
    assert report.findings[1].text == f"usbhid made {knob.hidraw}"
    assert report.findings[2].text == f"you may open {knob.hidraw}"


def test_nothing_plugged_in_is_said() -> None:
    finding = problem(only_report())
    assert finding.check == "usb"
    assert "no Torsio knob" in finding.text


def test_nobody_is_told_that_the_rule_is_missing(knob: VirtualKnob) -> None:
    doctor.install_rule_line()  # nobody may not read what Python has yet to import for it

    def work(output: TextIO) -> None:
        become_nobody()
        json.dump(only_report().as_dict(), output)

    report = json.loads(Child(work).end())
    assert [finding["check"] for finding in report["findings"]] == ["usb", "driver", "permission"]
    finding = report["findings"][-1]
    assert not finding["ok"]
    assert finding["text"].startswith(f"you may not open {knob.hidraw}")
    assert "rule is not installed" in finding["text"]
    assert "60-torsio.rules" in finding["advice"]
    assert finding["values"]["mode"] == "0600"


def test_knob_that_no_driver_has_taken_is_said(knob: VirtualKnob) -> None:
    (USBHID / "unbind").write_text(knob.interface.name)
    try:
        finding = problem(only_report())
    finally:
        (USBHID / "bind").write_text(knob.interface.name)
    assert finding.check == "driver"
    assert "no driver" in finding.text
    assert "modprobe" in finding.advice
    wait_for("the driver to take it again", lambda: knob.hidraw.exists())


def test_knob_in_use_is_said(knob: VirtualKnob) -> None:
    with torsio.open(knob.serial):
        finding = problem(only_report())
    assert finding.check == "open"
    assert finding.values == {"reason": "busy"}
    assert "other program" in finding.advice
