"""The bench itself: what it reads, packs and complains about."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.vm import guests, initramfs, kernel_log


def test_kernel_log_complains_about_warnings_and_traces_but_not_about_boot_noise() -> None:
    log = f"""\
<4>[    0.1] ACPI: no such table
<12>[    0.9] {kernel_log.MARK}
<6>[    1.0] usb 1-1: new full-speed USB device number 2 using vhci_hcd
<3>[    2.0] usb 1-1: device descriptor read/64, error -71
<4>[    2.1] hid-generic 0003:046D:C24F.0001: control queue full
<6>[    3.0] Call Trace:
"""
    assert kernel_log.complaints(log) == [
        "usb 1-1: device descriptor read/64, error -71",
        "hid-generic 0003:046D:C24F.0001: control queue full",
        "Call Trace:",
    ]


def test_kernel_log_may_speak_of_what_a_test_provokes_only_where_its_mark_says_so() -> None:
    log = """\
<3>[    1.0] usb 1-1: enqueue for inactive port 0
<3>[    1.1] vhci_hcd: sendmsg failed!, ret=-104 for 112
<3>[    1.2] vhci_hcd: sendmsg failed!, ret=-12 for 112
<4>[    1.3] hid-generic 0003:046D:C24F.000A: output queue full
"""
    out_of_memory, full = (
        "vhci_hcd: sendmsg failed!, ret=-12 for 112",
        "hid-generic 0003:046D:C24F.000A: output queue full",
    )
    assert len(kernel_log.complaints(log)) == 4
    assert kernel_log.complaints(log, ["pulls_cable"]) == [out_of_memory, full]
    assert len(kernel_log.complaints(log, ["floods_queue"])) == 3
    assert kernel_log.complaints(log, kernel_log.HARMLESS_WITH_MARK) == [out_of_memory]


@pytest.fixture
def fake_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Give a way to say what QEMU does; the console is where it always is."""

    def behave(script: str) -> None:
        program = tmp_path / "bin/qemu-system-x86_64"
        program.parent.mkdir(exist_ok=True)
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)

    monkeypatch.setenv("PATH", f"{tmp_path}/bin", prepend=os.pathsep)
    monkeypatch.setenv("TORSIO_VM_ACCEL", "tcg")
    monkeypatch.setattr(initramfs, "build", lambda _: b"")
    monkeypatch.setattr(guests, "share", lambda kernel: tmp_path / kernel)
    monkeypatch.setattr(guests, "junit", lambda kernel: tmp_path / f"out/{kernel}.xml")
    return behave


def test_guest_without_results_has_failed_though_its_machine_ended_well(
    fake_machine: Callable[[str], None],
) -> None:
    fake_machine("echo all is well >&2; exit 1")
    assert "no readable results" in guests.run_guest("6.1", ["a test"])
