"""Lines of a kernel's log that are worth a complaint."""

from __future__ import annotations

import re
from collections.abc import Collection

WARNING = 4  # levels up to this one are warnings and worse

# init.sh says so before it loads the first module. Earlier lines are about the processor and the
# board that QEMU makes up, differs from one kernel to the next, and never of USB.
MARK = "torsio: boot noise ends here"
# Harmless later lines, as regular expressions of whole lines, each with the reason.
HARMLESS = (
    # The virtual host controller knows high and low speed by name, and says this of full speed.
    # From 7.0 on or so kernels name the device twice.
    r"vhci_hcd(?: vhci_hcd\.\d+)?: vhci_device speed not set",
)
# Lines that are harmless only in tests that provoke them, by the tests' mark.
HARMLESS_WITH_MARK = {
    # Between the end of the connection and the moment when the rest of the kernel hears of it,
    # drivers and programs go on asking, and the virtual host controller says:
    "pulls_cable": (
        # EPIPE, ECONNRESET: a request, 48 bytes or with an output report 112, was about to be sent
        r"vhci_hcd(?: vhci_hcd\.\d+)?: sendmsg failed!, ret=-(?:32|104) for (?:48|112)",
        # one was refused at once, with ENODEV
        r"usb \d+-\d+: enqueue for inactive port \d+",
    ),
    "kernels_own_tests": (
        # The driver says so at the level of errors when it unlinks a transfer that is just ending.
        r"usbtest [0-9-]+:1\.0: unlink retry",
        # usbhid's words for a knob whose endpoints seem to be for bulk.
        r"usbhid [0-9-]+:1\.0: couldn't find an input interrupt endpoint",
    ),
    # Linux drops a game's report for which its queue has no place.
    "floods_queue": (r"hid-generic [0-9A-F:.]+: output queue full",),
    # Programs name trigger buttons that no report can hold.
    "odd_trigger": (
        r"hid-generic \S+: implement\(\) called with too large value \d+ \(n: 8\)! .*",
    ),
}
_LINE = re.compile(r"<(\d+)>(?:\[ *[\d.]+\] ?)?(.*)")
# Said at any level, these mean trouble.
_TROUBLE = re.compile(r"Call Trace|\bBUG\b|\bWARNING\b|Oops|\bleak|use-after-free|hung task")


def complaints(raw_log: str, marks: Collection[str] = ()) -> list[str]:
    """Return the lines of ``dmesg -r`` that are warnings, errors or worse, boot noise left out.

    Parameters
    ----------
    raw_log
        The log.
    marks
        Marks of `HARMLESS_WITH_MARK` that the tests of that time carry.
    """
    harmless = [*HARMLESS, *(text for mark in marks for text in HARMLESS_WITH_MARK[mark])]
    found: list[str] = []
    for line in raw_log.splitlines():
        match = _LINE.match(line)
        if match is None:
            continue
        level, text = int(match.group(1)) & 7, match.group(2)
        if text == MARK:
            found.clear()
        elif any(re.fullmatch(pattern, text) for pattern in harmless):
            continue
        elif level <= WARNING or _TROUBLE.search(text):
            found.append(text)
    return found
