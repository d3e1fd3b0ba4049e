"""`torsio doctor`: every problem that it knows, and silence when all is well."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import torsio
from tests.python import wire
from tests.python.processes import command
from torsio.apps import doctor
from torsio.apps.cli import app
from torsio.apps.doctor import examination
from torsio.apps.doctor import facts as doctor_facts
from torsio.apps.doctor import linux as doctor_linux
from torsio.apps.doctor import others as doctor_others
from torsio.apps.doctor.facts import ClockFit, KnobFacts, Node, Permission, RoundTrips, UsbKnob
from torsio.printed.statuses import FAULT_ADVICE
from torsio.printed.told import Limits

TREE = Path(__file__).parents[2]

NODE = Node("/dev/hidraw3", exists=True, usable=True, mode=0o660)
PLUGGED_IN = UsbKnob("1-2", "TS-1", "usbhid", NODE)
RULE_IN_FORCE = Permission("/etc/udev/rules.d/60-torsio.rules", udev_runs=True, remote=False)
PRESSES = 40  # each turns back twice, and after a ring the next is 64 turns away


# The system: a sysfs of plain files -----------------------------------------------------------


def plug_in(
    root: Path, *, port: str = "1-2", driver: str = "usbhid", hidraw: str = "hidraw3"
) -> None:
    """Make the part of /sys that the kernel makes for a knob, after sysfs of Linux 6.1."""
    device = root / "sys/bus/usb/devices" / port
    interface = device / f"{port}:1.0"
    interface.mkdir(parents=True)
    vendor, product = wire.USB_ID.split(":")
    for name, text in (("idVendor", vendor), ("idProduct", product), ("serial", "TS-1")):
        (device / name).write_text(text + "\n")
    if driver:
        (root / "sys/bus/usb/drivers" / driver).mkdir(parents=True, exist_ok=True)
        (interface / "driver").symlink_to(root / "sys/bus/usb/drivers" / driver)
    if hidraw:
        (interface / f"0003:{wire.USB_ID}.0001/hidraw" / hidraw).mkdir(parents=True)


def make_node(root: Path, mode: int, name: str = "hidraw3") -> None:
    (root / "dev").mkdir(exist_ok=True)
    (root / "dev" / name).touch()
    (root / "dev" / name).chmod(mode)


def test_knob_in_sysfs_is_found_with_port_serial_driver_and_file(tmp_path: Path) -> None:
    plug_in(tmp_path)
    make_node(tmp_path, 0o600)
    (tmp_path / "sys/bus/usb/devices/1-1").mkdir()
    (tmp_path / "sys/bus/usb/devices/1-1/idVendor").write_text("046d\n")  # a mouse
    path = str(tmp_path / "dev/hidraw3")
    assert doctor_facts.find_usb_knobs(tmp_path) == [
        UsbKnob("1-2", "TS-1", "usbhid", Node(path, exists=True, usable=True, mode=0o600))
    ]


@pytest.mark.parametrize("folder", doctor_facts.RULE_FOLDERS)
def test_rule_is_found_wherever_udev_reads_rules(folder: str, tmp_path: Path) -> None:
    assert doctor_facts.find_permission(tmp_path).rule == ""
    rule = tmp_path / folder / "60-torsio.rules"
    rule.parent.mkdir(parents=True)
    rule.touch()
    assert doctor_facts.find_permission(tmp_path).rule == str(rule)


def test_session_over_ssh_is_known_by_its_connection(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("SSH_CONNECTION", raising=False)
    assert not doctor_facts.find_permission(tmp_path).remote
    monkeypatch.setenv("SSH_CONNECTION", "192.0.2.1 50000 192.0.2.2 22")  # as sshd(8) sets it
    assert doctor_facts.find_permission(tmp_path).remote


def only(root: Path, selector: str = "") -> doctor.Report:
    (report,) = doctor.diagnose(selector, root)
    return report


def problem(report: doctor.Report) -> doctor.Finding:
    assert not report.ok
    (finding,) = [finding for finding in report.findings if not finding.ok]
    assert finding.advice
    return finding


def test_knob_that_another_driver_holds_is_a_problem(tmp_path: Path) -> None:
    plug_in(tmp_path, driver="usbfs", hidraw="")
    finding = problem(only(tmp_path))
    assert "usbfs" in finding.text
    assert "end the program" in finding.advice


def test_missing_file_in_a_container_is_a_problem(tmp_path: Path) -> None:
    plug_in(tmp_path)
    finding = problem(only(tmp_path))
    assert "no such file" in finding.text
    assert "container" in finding.advice


def test_file_that_is_no_hid_device_is_found_out_by_opening_it(tmp_path: Path) -> None:
    plug_in(tmp_path)
    make_node(tmp_path, 0o600)
    finding = problem(only(tmp_path, "TS-1"))
    assert finding.check == "open"
    assert finding.values == {"reason": "not_found"}
    assert "is not a HID device" in finding.text


def test_file_that_everybody_may_write_is_a_problem() -> None:
    knob = dataclasses.replace(PLUGGED_IN, node=dataclasses.replace(NODE, mode=0o666))
    finding = doctor_linux.check_permission(knob, RULE_IN_FORCE)
    assert not finding.ok
    assert "everybody" in finding.text
    assert finding.values["mode"] == "0666"


@pytest.mark.parametrize(
    ("permission", "text", "advice"),
    [
        (Permission("", udev_runs=True, remote=False), "not installed", "./dev udev"),
        (Permission("rule", udev_runs=False, remote=False), "udev does not run", "container"),
        (Permission("rule", udev_runs=True, remote=True), "over ssh", "setfacl"),
        (Permission("rule", udev_runs=True, remote=False), "not applied", "udevadm trigger"),
    ],
)
def test_missing_permission_says_which_step_is_missing(
    permission: Permission, text: str, advice: str
) -> None:
    knob = dataclasses.replace(PLUGGED_IN, node=dataclasses.replace(NODE, usable=False))
    finding = doctor_linux.check_permission(knob, permission)
    assert not finding.ok
    assert finding.text.startswith("you may not open /dev/hidraw3")
    assert text in finding.text
    assert advice in finding.advice
    assert doctor_linux.check_permission(PLUGGED_IN, permission).ok


def test_advice_names_the_rule_that_the_package_brings() -> None:
    rule = shlex.split(doctor_linux.install_rule_line())[4]
    assert Path(rule).read_bytes() == (TREE / "sdk/60-torsio.rules").read_bytes()


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (torsio.DeviceBusy("it is open already"), "busy"),
        (torsio.ProtocolMismatch("version 7 and version 1"), "protocol"),
        (torsio.PermissionDenied("no"), "permission"),
        (torsio.Timeout("no answer"), "timeout"),
        (torsio.Disconnected("gone"), "failed"),
    ],
)
def test_knob_that_cannot_be_opened_says_why(
    error: torsio.Error, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> torsio.Knob:
        raise error

    monkeypatch.setattr(torsio, "open", refuse)
    (finding,) = doctor.examine_device("TS-1")
    assert not finding.ok
    assert finding.text == str(error)
    assert finding.values == {"reason": reason}
    assert finding.advice


# The knob: facts as they should be, and one wrong at a time ---------------------------------


@pytest.fixture(scope="module")
def facts() -> KnobFacts:
    """An emulated knob's answers, with the figures of a good cable."""
    with torsio.open("emulated") as knob:
        health = knob.health()
        return KnobFacts(
            info=knob.info,
            before=health,
            after=health,
            watchdog_s=0.25,
            watches_supply=False,
            limits=knob.limits(),
            clock=ClockFit(offset_s=-12.5, drift_ppm=30.0, uncertainty_ppm=100.0),
            round_trips=RoundTrips(200, 2e-3, 3e-3, 5e-3),
            samples=1000,
            link=knob.statistics(),
        )


def with_health(facts: KnobFacts, **values: Any) -> KnobFacts:
    return dataclasses.replace(facts, after=dataclasses.replace(facts.after, **values))


def on_a_board(facts: KnobFacts) -> KnobFacts:
    return dataclasses.replace(facts, info=dataclasses.replace(facts.info, board="pico2"))


@pytest.mark.parametrize("fault", examination._FAULTS_FOUND)
def test_fault_is_told_in_plain_words(fault: str, facts: KnobFacts) -> None:
    finding = examination.check_state(with_health(facts, state="fault", faults=(fault,)))
    assert not finding.ok
    assert finding.values == {"state": "fault", "faults": [fault]}
    assert "_" not in finding.text
    assert "clear_fault" in finding.advice


def test_fault_table_has_every_fault_of_the_protocol() -> None:
    header = (TREE / "firmware" / "protocol" / "enumerations.hpp").read_text(encoding="utf-8")
    body = header.split("namespace fault {")[1].split("}")[0]
    assert (
        set(examination._FAULTS_FOUND)
        == set(FAULT_ADVICE)
        == set(re.findall(r"uint16_t (\w+) =\s+1", body))
    )


def test_fault_of_a_newer_firmware_asks_for_a_newer_library(facts: KnobFacts) -> None:
    finding = examination.check_state(with_health(facts, state="fault", faults=("meltdown",)))
    assert not finding.ok
    assert "update the library" in finding.advice


@pytest.mark.parametrize(
    ("drift_ppm", "uncertainty_ppm", "ok"),
    [(150, 0, True), (-150, 0, True), (201, 0, False), (-1000, 0, False), (1000, 900, True)],
)
def test_clock_may_be_as_wrong_as_two_crystals(
    drift_ppm: float, uncertainty_ppm: float, ok: bool, facts: KnobFacts
) -> None:
    clock = ClockFit(offset_s=0.0, drift_ppm=drift_ppm, uncertainty_ppm=uncertainty_ppm)
    on_board = on_a_board(dataclasses.replace(facts, clock=clock))
    assert examination.check_clock(on_board).ok is ok


@pytest.mark.parametrize(
    ("median_s", "p99_s", "text"),
    [(11e-3, 20e-3, "USB needs 1 to 3 ms"), (2e-3, 84e-3, "watchdog of 0.25 s")],
)
def test_slow_round_trips_are_a_problem(
    median_s: float, p99_s: float, text: str, facts: KnobFacts
) -> None:
    slow = dataclasses.replace(facts, round_trips=RoundTrips(200, median_s, p99_s, p99_s))
    finding = examination.check_round_trips(on_a_board(slow))
    assert not finding.ok
    assert text in finding.text
    assert examination.check_round_trips(slow).ok  # has neither cable nor hub


def test_emulated_knob_may_fall_behind_on_a_busy_computer(facts: KnobFacts) -> None:
    late = dataclasses.replace(
        facts,
        clock=ClockFit(offset_s=0.0, drift_ppm=-5e5, uncertainty_ppm=100.0),
        round_trips=RoundTrips(200, 0.1, 0.3, 0.5),
    )
    for check in (examination.check_clock, examination.check_round_trips):
        assert check(late).ok
        assert "is late where the computer is busy" in check(late).text
        assert "hub" not in check(late).advice
        assert not check(on_a_board(late)).ok


@pytest.mark.parametrize("counter", ["samples_dropped", "reports_refused"])
def test_losses_in_the_knob_are_a_problem_only_if_they_are_new(
    counter: str, facts: KnobFacts
) -> None:
    values: dict[str, Any] = {counter: 7}
    old = dataclasses.replace(facts.before, **values)
    assert examination.check_losses(dataclasses.replace(facts, before=old, after=old)).ok
    assert not examination.check_losses(with_health(facts, **values)).ok


def test_late_and_long_ticks_are_a_problem(facts: KnobFacts) -> None:
    assert not examination.check_ticks(with_health(facts, tick_overruns=1)).ok
    assert not examination.check_ticks(with_health(facts, tick_time_max_s=1.1e-3)).ok  # 1 ms
    assert examination.check_ticks(with_health(facts, tick_time_max_s=0.9e-3)).ok
    for swings, ok in ((5, True), (6, False)):
        assert examination.check_beliefs(with_health(facts, unexpected_swings=swings)).ok is ok


# On an emulated knob --------------------------------------------------------------------------


def test_damaged_cable_shows_in_an_examination() -> None:
    with torsio.open(
        "emulated", emulator=torsio.EmulatorOptions(paced=True), command_timeout_s=5.0
    ) as knob:
        knob.emulator.set_link_faults(torsio.LinkFaults(drop_input=0.02))
        try:
            finding = examination.check_losses(doctor_facts.examine(knob))
        except torsio.Timeout as error:  # an answer was lost too
            finding = doctor.check_failure(error)
        assert not finding.ok
        assert finding.advice


def test_pressed_emergency_stop_and_late_ticks_show_in_an_examination(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(paced=True)) as knob:
        monkeypatch.setattr(
            doctor_facts, "time_round_trips", lambda *_: knob.emulator.skip_ticks(count=3)
        )
        knob.emulator.set_emergency_stop(pressed=True)
        facts = doctor_facts.examine(knob)
    state = examination.check_state(facts)
    assert state.values["faults"] == ["emergency_stop"]
    assert "emergency stop is pressed" in state.text
    ticks = examination.check_ticks(facts)
    assert ticks.values["tick_overruns"] == 3
    assert not ticks.ok


@pytest.mark.parametrize(
    ("name", "factor", "shown"),
    [
        *(("spring_stiffness_nm_per_rad", factor, factor > 1.1) for factor in (1.0, 1.05, 1.2)),
        *(("brake_inertia_kg_m2", factor, True) for factor in (0.5, 2.0)),
        # These need an excitation.
        *((name, 2.0, False) for name in ("brake_drag_nm", "brake_time_constant_s")),
        ("knob_coulomb_nm", 2.0, False),
    ],
)
def test_ordinary_use_shows_another_shaft_or_inertia_and_nothing_else(
    name: str, factor: float, *, shown: bool
) -> None:
    fine = torsio.EmulatorOptions(
        plant=torsio.PlantParams(counts_per_rev=32_768), control_rate_hz=20_000
    )
    with torsio.open("emulated", emulator=fine) as knob:
        told = factor * getattr(knob.actuator_config(), name)
        knob.update(counts_per_rev=32_768, **{name: told})
        knob.update(law="calibrated")
        press = [(0.0, 0.0), (0.1, 40e-3), (1.5, 40e-3), (1.6, -10e-3), (1.99, 0.0)]
        path = [(2.0 * n + at_s, torque_nm) for n in range(PRESSES) for at_s, torque_nm in press]
        knob.emulator.set_hand(torsio.TorqueHand(torque_nm=path))
        back = torsio.Spring(stiffness_nm_per_rad=0.3)
        knob.play([torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=1.5), back])
        knob.arm()
        knob.emulator.advance(2.0 * PRESSES)
        knob.disarm()
        finding = examination.check_beliefs(doctor_facts.examine(knob))
    assert finding.ok != shown


def test_armed_knob_is_examined_and_stays_armed() -> None:
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(paced=True)) as knob:
        knob.arm()
        facts = doctor_facts.examine(knob)
        assert knob.health().state == "armed"
    assert facts.round_trips is None
    assert examination.check_round_trips(facts).ok


def _run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return command("doctor", *arguments, env={**os.environ, "COLUMNS": "400"})


def test_command_examines_the_emulated_knob_and_its_status_is_its_verdict() -> None:
    result = _run("--device", "emulated", "--json")
    verdict = json.loads(result.stdout)
    (report,) = verdict["reports"]
    checks = [finding["check"] for finding in report["findings"]]
    assert checks == [
        *("firmware", "state", "start", "parts"),
        *("clock", "round_trip", "losses", "ticks", "beliefs"),
    ]
    for finding in report["findings"]:
        assert finding["ok"], finding
        assert set(finding) == {
            *("check", "ok", "text", "advice", "values", "faults", "more", "links")
        }
    assert verdict["ok"] is report["ok"] is all(f["ok"] for f in report["findings"])
    assert result.returncode == (0 if verdict["ok"] else 1)
    values = {finding["check"]: finding["values"] for finding in report["findings"]}
    assert values["firmware"]["fingerprint"] == torsio.protocol.fingerprint()
    assert 0 < values["round_trip"]["median_s"] <= values["round_trip"]["p99_s"]
    assert values["losses"]["samples"] == 1000


def test_command_without_a_knob_says_so_and_examines_the_emulated_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(doctor, "find_usb_knobs", lambda root: [])
    result = CliRunner().invoke(app, ["doctor", "--json"])
    (report,) = json.loads(result.stdout)["reports"]
    assert report["device"] == "emulated"
    assert [finding["check"] for finding in report["findings"][:2]] == ["usb", "firmware"]
    assert "no Torsio knob" in report["findings"][0]["text"]
    assert "another port" in report["findings"][0]["advice"]
    assert report["findings"][0]["links"]
    assert report["findings"][0]["ok"]
    assert result.exit_code == (0 if all(each["ok"] for each in report["findings"]) else 1)


def test_command_says_what_to_do_about_a_device_that_is_not_there() -> None:
    result = _run("--device", "TS-9999")
    assert result.returncode == 1
    assert result.stderr == ""
    assert "there is no knob" in result.stdout
    assert "-> `torsio list` shows what is there" in result.stdout


@pytest.mark.parametrize("cause", ["brown_out", "watchdog", "hard_fault", "stack"])
def test_restart_that_nobody_asked_for_is_told(facts: KnobFacts, cause: str) -> None:
    finding = examination.check_start(with_health(facts, reset_cause=cause))
    assert not finding.ok
    assert finding.advice
    assert examination.check_start(with_health(facts, reset_cause="power")).ok


def test_board_whose_parts_are_not_confirmed_is_told_how_to_confirm_them(facts: KnobFacts) -> None:
    low = Limits(
        motor_torque_max_nm=0.015, motor_torque_continuous_max_nm=0.0125, brake_torque_max_nm=0.03,
        speed_limit_rad_s=10.0, held_low=True,
    )  # fmt: skip
    finding = examination.check_parts(dataclasses.replace(facts, limits=low))
    assert not finding.ok
    assert "motor 15 mN m (12.5 continuously), brake 30 mN m, 10 rad/s" in finding.text
    assert "confirmed=on" in finding.advice


def test_real_board_without_a_speed_limit_is_told_to_set_one(facts: KnobFacts) -> None:
    free = dataclasses.replace(facts.limits, speed_limit_rad_s=0.0, held_low=False)
    emulated = dataclasses.replace(facts, limits=free)
    assert emulated.info.board == "emulated"
    finding = examination.check_parts(emulated)
    assert finding.ok
    assert "any speed" in finding.text
    board = dataclasses.replace(facts.info, board="pico2")
    finding = examination.check_parts(dataclasses.replace(emulated, info=board))
    assert not finding.ok
    assert "any speed" in finding.text
    assert "speed_limit_rad_s=160`" in finding.advice
    limited = dataclasses.replace(free, speed_limit_rad_s=160.0)
    sound = dataclasses.replace(facts, info=board, limits=limited)
    assert examination.check_parts(sound).ok
    assert "does not measure its supply" in examination.check_parts(sound).text
    watching = dataclasses.replace(sound, watches_supply=True)
    assert "its supply" not in examination.check_parts(watching).text


# Windows, as far as this system can play it ----------------------------------------------------


def listed(serial: str) -> torsio.ListedDevice:
    return torsio.ListedDevice(
        path=rf"\\?\hid#{serial}", serial=serial, product="", board="", transport="hid", problem=""
    )


@pytest.mark.parametrize(
    ("platform", "system", "where", "ids"),
    [
        ("win32", "Windows", "Device Manager", "VID_{0:04X}&PID_{1:04X}"),
        ("darwin", "macOS", "System Information", "ID 0x{0:04x} and the product ID 0x{1:04x}"),
    ],
)
def test_other_systems_without_a_knob_tell_where_to_look(
    monkeypatch: pytest.MonkeyPatch, platform: str, system: str, where: str, ids: str
) -> None:
    monkeypatch.setattr(doctor_others, "list_devices", lambda: [])
    monkeypatch.setattr(sys, "platform", platform)
    (report,) = doctor.diagnose()
    told = problem(report)
    assert told.text == f"{system} shows no Torsio knob"
    assert where in told.advice
    assert ids.format(*(int(number, 16) for number in wire.USB_ID.split(":"))) in told.advice
    for foreign in ("lsusb", "udev", "hidraw"):
        assert foreign not in told.text + told.advice


@pytest.mark.parametrize("platform", ["win32", "darwin"])
def test_other_systems_open_each_knob_and_know_nothing_of_linux(
    monkeypatch: pytest.MonkeyPatch, platform: str
) -> None:
    def refuse(selector: str) -> torsio.Knob:
        raise torsio.DeviceBusy(f"{selector} is open already")

    monkeypatch.setattr(doctor_others, "list_devices", lambda: [listed("A"), listed("B")])
    monkeypatch.setattr(torsio, "open", refuse)
    monkeypatch.setattr(sys, "platform", platform)
    reports = doctor.diagnose()
    assert [report.device for report in reports] == [r"\\?\hid#A", r"\\?\hid#B"]
    for report in reports:
        seen, opened = report.findings
        assert seen.ok
        assert opened.check == "open"
        assert "fuser" not in opened.advice
    assert [report.device for report in doctor.diagnose("B")] == [r"\\?\hid#B"]


def test_clock_fit_recovers_offset_drift_and_doubt() -> None:
    # A clock 5 s ahead at 100 s that runs 250 ppm fast; asking takes 2 and 4 ms, a tick 1 ms.
    first = doctor_facts._ClockSample(99.999, 100.001, 105.0)
    last = doctor_facts._ClockSample(101.998, 102.002, 107.0 + 2 * 250e-6)
    fit = doctor_facts.fit_clock(first, last, 1e-3)
    assert fit.offset_s == pytest.approx(5.0005)
    assert fit.drift_ppm == pytest.approx(250.0)
    assert fit.uncertainty_ppm == pytest.approx(1e6 * (3e-3 + 1e-3) / 2)


@pytest.mark.parametrize("counter", ["samples_lost", "reports_undecodable"])
def test_losses_of_the_link_are_a_problem(counter: str, facts: KnobFacts) -> None:
    values: dict[str, Any] = {counter: 7}
    link = dataclasses.replace(facts.link, **values)
    finding = examination.check_losses(dataclasses.replace(facts, link=link))
    assert not finding.ok
    assert finding.values[counter] == 7
    assert finding.text.endswith(": 7")
