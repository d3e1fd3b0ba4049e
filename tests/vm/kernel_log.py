"""What in a kernel's log is worth a complaint."""

from __future__ import annotations

import re

WARNING = 4  # levels up to this one are warnings and worse

# What a virtual machine says of itself while it boots; nothing here speaks of USB or HID.
BOOT_NOISE = (
    r"x86/cpu: .*",
    r"(?:RETBleed|Spectre|MDS|TAA|MMIO|SRBDS|L1TF|ITS|VMSCAPE|TSA)\b.*",
    r"Speculative .*",
    r"(?:ACPI|acpi|pci|PCI|PCI:|MTRR|mtrr|i8042|rtc_cmos|clocksource|TSC|tsc|sched_clock)\b.*",
    r"Unknown kernel command line parameters .*",
    r"Initramfs unpacking .*",
    r"Booting paravirtualized kernel .*",
    r"platform (?:eisa|rtc_cmos).*",
    r"(?:9p|9pnet|9pnet_virtio|overlayfs|netfs|FS-Cache): .*",
    r"random: .*",
    r"loop: module .*",
)
_NOISE = re.compile("|".join(BOOT_NOISE))
_LINE = re.compile(r"<(\d+)>(?:\[ *[\d.]+\] ?)?(.*)")
# Said at any level, these mean trouble.
_TROUBLE = re.compile(r"Call Trace|\bBUG\b|\bWARNING\b|Oops|\bleak|use-after-free|hung task")


def complaints(raw_log: str) -> list[str]:
    """Return the lines of ``dmesg -r`` that are warnings, errors or worse, boot noise left out."""
    found = []
    for line in raw_log.splitlines():
        match = _LINE.match(line)
        if match is None:
            continue
        level, text = int(match.group(1)) & 7, match.group(2)
        if (level <= WARNING and not _NOISE.match(text)) or _TROUBLE.search(text):
            found.append(text)
    return found
