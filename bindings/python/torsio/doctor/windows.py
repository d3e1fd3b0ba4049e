"""What `torsio doctor` knows of Windows, where the system itself shows every user every knob.

No file of a knob has an owner there and no rule gives permission, so what is left is whether the
system sees the knob, and whether another program keeps it.
"""

from __future__ import annotations

from collections.abc import Iterator

from torsio.doctor.facts import PRODUCT_ID, VENDOR_ID
from torsio.doctor.findings import Finding
from torsio.opening import list_devices
from torsio.records import ListedDevice

__all__ = ["OPEN_ADVICE", "examine_system"]

OPEN_ADVICE = {
    "busy": "close the other program that has the knob open",
    "permission": "close the program that has the knob for itself, or plug the knob in again",
}


def check_usb(knobs: list[ListedDevice]) -> Finding:
    """Look for a knob among those that Windows shows."""
    if knobs:
        serials = ", ".join(f"serial number {knob.serial}" for knob in knobs)
        return Finding("usb", True, f"Windows shows a knob: {serials}")
    return Finding(
        "usb",
        False,
        "Windows shows no Torsio knob",
        "plug it in; if it is, try another port and a cable that carries data, not only power, and "
        "look in the Device Manager, below Human Interface Devices, for one with "
        f"VID_{VENDOR_ID.upper()}&PID_{PRODUCT_ID.upper()} among its hardware ids: a yellow sign "
        "there says what keeps it; without hardware use `--device emulated`",
    )


def examine_system(selector: str) -> Iterator[tuple[str, Finding]]:
    """Yield each knob that is meant, all with an empty selector, and what Windows says of it.

    The device is empty where there is nothing to open.
    """
    knobs = [knob for knob in list_devices() if knob.transport != "emulated"]
    meant = [knob for knob in knobs if selector in ("", knob.serial, knob.path)]
    for knob in meant:
        yield knob.path, check_usb([knob])
    if not meant:
        # What was named may still be a path, which opening explains.
        yield selector, check_usb(knobs)
