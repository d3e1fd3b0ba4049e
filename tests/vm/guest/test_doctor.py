"""The doctor's findings on a real kernel, with a sound knob and with faults."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TextIO

import pytest
from typer.testing import CliRunner

import torsio
from tests.python import wire
from tests.vm.guest.child import Child, become_nobody
from tests.vm.guest.virtual_bus import VirtualKnob, wait_for
from torsio.apps import doctor
from torsio.apps.cli import app
from torsio.apps.doctor import linux as doctor_linux

pytestmark = pytest.mark.kernel("6.12")

# A busy host makes these worse now and then, and is no fault of the knob.
ALWAYS = {"firmware", "state", "start", "parts", "beliefs"}
TIMED = {"clock", "round_trip", "losses", "ticks"}
USBHID = Path("/sys/bus/usb/drivers/usbhid")
HID_GENERIC = Path("/sys/bus/hid/drivers/hid-generic")


def only_report() -> doctor.Report:
    (report,) = doctor.diagnose()
    return report


def problem(report: doctor.Report) -> doctor.Finding:
    (finding,) = [finding for finding in report.findings if not finding.ok]
    assert finding.advice
    return finding


def test_all_is_well_with_a_sound_knob_and_the_status_is_0(knob: VirtualKnob) -> None:
    knob.say("still")
    for _ in range(5):
        result = CliRunner().invoke(app, ["doctor", "--json"])
        verdict = json.loads(result.stdout)
        [report] = verdict["reports"]
        assert report["device"] == str(knob.hidraw)
        found = {finding["check"]: finding for finding in report["findings"]}
        assert set(found) == {"usb", "driver", "permission", *ALWAYS, *TIMED}
        assert found["driver"]["text"] == f"usbhid made {knob.hidraw}"
        assert found["permission"]["text"] == f"you may open {knob.hidraw}"
        wrong = {check: finding for check, finding in found.items() if not finding["ok"]}
        assert set(wrong) <= TIMED, wrong
        assert verdict["ok"] is report["ok"] is (not wrong)
        assert result.exit_code == (1 if wrong else 0)
        if not wrong:
            break
    else:
        pytest.fail(f"never was all well: {wrong}")


def test_nothing_plugged_in_is_said() -> None:
    finding = problem(only_report())
    assert finding.check == "usb"
    assert "no Torsio knob" in finding.text


def test_nobody_is_told_that_the_rule_is_missing(knob: VirtualKnob) -> None:
    doctor_linux.install_rule_line()  # imported lazily

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


def test_knob_that_usbhid_has_and_that_has_no_file_is_said(knob: VirtualKnob) -> None:
    [hid] = knob.interface.glob(f"*:{wire.USB_ID}.*")
    (HID_GENERIC / "unbind").write_text(hid.name)
    try:
        finding = problem(only_report())
    finally:
        (HID_GENERIC / "bind").write_text(hid.name)
    assert (knob.interface / "driver").resolve() == USBHID
    assert finding.check == "driver"
    assert finding.text == "the kernel made no hidraw file"
    assert "hid-generic" in finding.advice
    wait_for("the file to come again", lambda: knob.hidraw.exists())


def test_missing_file_is_said(knob: VirtualKnob) -> None:
    path = knob.hidraw
    path.unlink()  # as in a container
    finding = problem(only_report())
    assert finding.check == "driver"
    assert finding.text == f"the kernel has {path}, but here is no such file"
    assert "container" in finding.advice


def test_knob_in_use_is_said(knob: VirtualKnob) -> None:
    with torsio.open(knob.serial):
        finding = problem(only_report())
    assert finding.check == "open"
    assert finding.values == {"reason": "busy"}
    assert "other program" in finding.advice
