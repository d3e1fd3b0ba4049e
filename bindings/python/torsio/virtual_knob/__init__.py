"""The virtual USB knob: a program that an operating system sees as a knob on a USB port.

The program is C++ and comes with the package if the package was built with TinyUSB. Each run is one
knob; see docs/reference/usb.md.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

from torsio.errors import Error

__all__ = ["Address", "attach_commands", "program_path"]

_PROGRAM = Path(__file__).parent.parent / "bin" / "torsio_virtual_knob"


def program_path() -> Path:
    """Return where the program is.

    Raises
    ------
    torsio.Error
        If the package was built without it, or on Windows or macOS, for which there is none.
    """
    if sys.platform == "win32":
        raise Error(
            "the virtual USB knob is a program for Linux: run it there, and attach it to this "
            "Windows over the network as docs/reference/usb.md tells"
        )
    if sys.platform == "darwin":
        raise Error(
            "the virtual USB knob is a program for Linux: run it there, or in a virtual machine"
        )
    if not _PROGRAM.exists():
        raise Error(
            "this package was built without the virtual USB knob, which needs TinyUSB. Run "
            "./dev build python in the source tree, which fetches TinyUSB, or add "
            "-C cmake.define.TORSIO_TINYUSB_PATH=FOLDER to pip install"
        )
    return _PROGRAM


@dataclass(frozen=True)
class Address:
    """Where a virtual knob listens, as its program's first line says."""

    host: str
    port: int
    bus_id: str

    @classmethod
    def from_line(cls, line: str) -> Address:
        """Read ``listening HOST:PORT BUS_ID``.

        Raises
        ------
        torsio.Error
            If the line is another one.
        """
        words = line.split()
        host, colon, port = words[1].rpartition(":") if len(words) == 3 else ("", "", "")
        if words[:1] != ["listening"] or not colon or not port.isdecimal():
            raise Error(f"the virtual knob said {line!r} in place of its address")
        return cls(host, int(port), words[2])


def attach_commands(address: Address) -> dict[str, str]:
    """Return the command with which each system plugs a virtual knob in."""
    # Listening on every address, it is reached through the nearest one.
    host = "127.0.0.1" if address.host == "0.0.0.0" else address.host
    port = "" if address.port == 3240 else f"--tcp-port {address.port} "
    attach = f"{port}attach -r {host} -b {address.bus_id}"
    return {
        "Linux": f"sudo modprobe vhci-hcd; sudo usbip {attach}",
        "Windows": f"usbip {attach}",
    }
