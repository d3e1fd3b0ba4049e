"""The bench itself: what it reads, packs and complains about."""

from __future__ import annotations

from tests.vm import kernel_log


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
