"""What in a kernel's log is worth a complaint."""

from __future__ import annotations

import re

WARNING = 4  # levels up to this one are warnings and worse

# init.sh says so before it loads the first module. What is older speaks of the processor and the
# board that QEMU makes up, differs from one kernel to the next, and never of USB.
MARK = "torsio: boot noise ends here"
# What is harmless later, as regular expressions of whole lines, each with the reason.
HARMLESS = (
    # The virtual host controller knows high and low speed by name, and says this of full speed.
    r"vhci_hcd: vhci_device speed not set",
    # EPIPE: it was about to send a request, 48 bytes or with an output report 112, into the cable
    # that was pulled.
    r"vhci_hcd: sendmsg failed!, ret=-32 for (?:48|112)",
    # A test floods the game interface on purpose; that others lose nothing shows in their torques.
    r"hid-generic 0003:1209:0001\.[0-9A-F]{4}: output queue full",
)
_HARMLESS = [re.compile(pattern) for pattern in HARMLESS]
_LINE = re.compile(r"<(\d+)>(?:\[ *[\d.]+\] ?)?(.*)")
# Said at any level, these mean trouble.
_TROUBLE = re.compile(r"Call Trace|\bBUG\b|\bWARNING\b|Oops|\bleak|use-after-free|hung task")


def complaints(raw_log: str) -> list[str]:
    """Return the lines of ``dmesg -r`` that are warnings, errors or worse, boot noise left out."""
    found: list[str] = []
    for line in raw_log.splitlines():
        match = _LINE.match(line)
        if match is None:
            continue
        level, text = int(match.group(1)) & 7, match.group(2)
        if text == MARK:
            found.clear()
        elif any(pattern.fullmatch(text) for pattern in _HARMLESS):
            continue
        elif level <= WARNING or _TROUBLE.search(text):
            found.append(text)
    return found
