"""Windows and macOS for `torsio doctor`, where the system shows a user every knob.

There a knob has no file, no owner and no rule. Two questions are left: does the system see the
knob, and does another program keep it? No Mac ever ran it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from torsio.apps.doctor.facts import PRODUCT_ID, VENDOR_ID
from torsio.apps.doctor.findings import Finding
from torsio.common.emulated import EMULATED
from torsio.knob.opening import list_devices
from torsio.printed.told import ListedDevice

__all__ = ["NAMES", "OPEN_ADVICE", "examine_system"]

NAMES: Final = {"win32": "Windows", "darwin": "macOS"}
"""The user's name of the system, by Python's name."""

OPEN_ADVICE: Final = {
    "busy": "close the other program that has the knob open",
    "permission": "close the program that has the knob for itself, or plug the knob in again",
}

_WHERE: Final = {
    "Windows": (
        "look in the Device Manager, below Human Interface Devices, for one with "
        f"VID_{VENDOR_ID.upper()}&PID_{PRODUCT_ID.upper()} among its hardware ids: a yellow sign "
        "there says what keeps it"
    ),
    "macOS": (
        "look in System Information, below USB, for one with the vendor ID "
        f"0x{VENDOR_ID} and the product ID 0x{PRODUCT_ID}, or let `system_profiler SPUSBDataType` "
        "list them"
    ),
}


def check_usb(system: str, knobs: list[ListedDevice]) -> Finding:
    """Look for a knob among those that the system shows."""
    if knobs:
        serials = ", ".join(f"serial number {knob.serial}" for knob in knobs)
        return Finding("usb", True, f"{system} shows a knob: {serials}")
    return Finding(
        "usb",
        False,
        f"{system} shows no Torsio knob",
        "plug it in; if it is, try another port and a cable that carries data, not only power, and "
        f"{_WHERE[system]}",
    )


def examine_system(platform: str, selector: str) -> Iterator[tuple[str, Finding]]:
    """Yield each knob that is meant, all with an empty selector, and what the system says of it.

    The device is empty where there is nothing to open.

    Parameters
    ----------
    platform
        One of `NAMES`.
    """
    system = NAMES[platform]
    knobs = [knob for knob in list_devices() if knob.transport != EMULATED]
    meant = [knob for knob in knobs if selector in ("", knob.serial, knob.path)]
    for knob in meant:
        yield knob.path, check_usb(system, [knob])
    if not meant:
        # The name may still be a path, which opening explains.
        yield selector, check_usb(system, knobs)
