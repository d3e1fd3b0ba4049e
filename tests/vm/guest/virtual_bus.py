"""Virtual USB knobs plugged into this computer: programs, and the kernel's virtual controller."""

from __future__ import annotations

import os
import socket
import struct
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

CONTROLLER = Path("/sys/devices/platform/vhci_hcd.0")
DEVICES = Path("/sys/bus/usb/devices")
TREE = Path(__file__).parent.parent.parent.parent
PROGRAM = TREE / "build/release/emulator/usbip/torsio_virtual_knob"

_FREE, _USED = 4, 6  # VDEV_ST_NULL, VDEV_ST_USED
_FULL_SPEED = 2
_INTERFACES = 2
_DEVICE_ID = 0x0001_0002
_LONGEST_S = 120.0  # a busy machine takes long
_LOOK_EVERY_S = 0.03

_T = TypeVar("_T")
Cable = Callable[[socket.socket], socket.socket]


def plain_cable(connection: socket.socket) -> socket.socket:
    return connection


def wait_for(what: str, ready: Callable[[], _T | None]) -> _T:
    """Wait until a call returns something true, and return that.

    Raises
    ------
    TimeoutError
        If it takes longer than two minutes.
    """
    end = time.monotonic() + _LONGEST_S
    while True:
        if found := ready():
            return found
        if time.monotonic() > end:
            raise TimeoutError(f"waited in vain for {what}")
        time.sleep(_LOOK_EVERY_S)


def ports() -> dict[int, tuple[int, str]]:
    """Return status and bus id of each of the controller's ports for full speed."""
    rows = [line.split() for line in (CONTROLLER / "status").read_text().splitlines()]
    return {int(row[1]): (int(row[2]), row[6]) for row in rows if row[0] == "hs"}


def import_device(tcp_port: int) -> socket.socket:
    """Ask a USB/IP server for its knob, and return the connection."""
    connection = socket.create_connection(("127.0.0.1", tcp_port), timeout=_LONGEST_S)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.sendall(struct.pack(">HHI32s", 0x0111, 0x8003, 0, b"1-1"))
    head = connection.recv(8, socket.MSG_WAITALL)
    status = struct.unpack(">HHI", head)[2]
    if status != 0:
        connection.close()
        raise ConnectionRefusedError(f"the virtual knob answers with status {status}")
    connection.recv(312, socket.MSG_WAITALL)
    connection.settimeout(None)
    return connection


class VirtualKnob:
    """A program that is one virtual knob, plugged into this computer or not."""

    def __init__(
        self,
        serial: str,
        rate_hz: int,
        hand: str,
        options: Sequence[str] = (),
        seed: int = 0,
    ) -> None:
        self.serial = serial
        self.bus_id = ""
        self._port = -1
        self._is_pulled = False  # and the kernel may not have noticed yet
        numbers = ("--port", "0", "--rate-hz", str(rate_hz), "--seed", str(seed))
        self.process = subprocess.Popen(
            [str(PROGRAM), *numbers, "--serial", serial, "--hand", hand, *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        assert self.process.stdout is not None
        word, address, _ = self.process.stdout.readline().split()
        assert word == "listening"
        self.tcp_port = int(address.rpartition(":")[2])

    @property
    def is_plugged(self) -> bool:
        """True between `plug` and `unplug`."""
        return self._port >= 0

    @property
    def sysfs(self) -> Path:
        """The USB device's folder."""
        return DEVICES / self.bus_id

    @property
    def interface(self) -> Path:
        """The folder of the interface for the SDK."""
        return self.sysfs / f"{self.bus_id}:1.0"

    @property
    def hidraw(self) -> Path:
        """The device file of that interface."""
        found = wait_for("a hidraw device", lambda: list(self.interface.glob("*/hidraw/hidraw*")))
        return wait_for("a device file", lambda: _existing(Path("/dev") / found[0].name))

    def plug(self, *, wait: bool = True, cable: Cable = plain_cable) -> None:
        """Plug it in; return when the kernel has got to know it, or at once.

        A cable makes of the connection to the knob the one that the kernel gets.
        """
        with cable(import_device(self.tcp_port)) as connection:
            self._port = next(n for n, (status, _) in ports().items() if status == _FREE)
            (CONTROLLER / "attach").write_text(
                f"{self._port} {connection.fileno()} {_DEVICE_ID} {_FULL_SPEED}"
            )
        if wait:
            self.wait_plugged()

    def wait_addressed(self) -> None:
        """Wait until the kernel has given it an address, whether a driver wants it or not."""

        def bus_id() -> str:
            status, found = ports()[self._port]
            return found if status == _USED else ""

        self.bus_id = wait_for("an address", bus_id)
        wait_for("interfaces", self.interface.exists)

    def wait_plugged(self) -> None:
        """Wait until the kernel has got to know it."""
        self.wait_addressed()
        folders = [f"{self.sysfs}/{self.bus_id}:1.{number}" for number in range(_INTERFACES)]
        wait_for("the drivers", lambda: all(map(_is_bound, folders)))

    def unplug(self, *, wait: bool = True) -> None:
        """Pull the cable; return when the kernel has let go, or at once."""
        self._is_pulled = True
        (CONTROLLER / "detach").write_text(str(self._port))
        if wait:
            self.wait_unplugged()

    def wait_unplugged(self) -> None:
        """Wait until the kernel has let go of it."""
        wait_for(
            "the kernel to let go",
            lambda: ports()[self._port][0] == _FREE and not self.sysfs.exists(),
        )
        self._port = -1
        self._is_pulled = False

    def say(self, line: str) -> None:
        """Send a line to the program, "angle 0.3" for example."""
        assert self.process.stdin is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def end(self) -> None:
        """Unplug it and end the program, which must end well."""
        if self._is_pulled:
            self.wait_unplugged()
        elif self.is_plugged:
            self.unplug()
        self.process.terminate()
        _, errors = self.process.communicate(timeout=_LONGEST_S)
        assert self.process.returncode == 0, errors
        assert "warning" not in errors
        assert "ERROR" not in errors


def _is_bound(interface: str) -> bool:
    """Tell whether the kernel's drivers have asked an interface all that they want to know."""
    # Not pathlib, which an emulated processor would spend most of a plug cycle with.
    try:
        names = os.listdir(interface)
    except FileNotFoundError:
        return False
    # Their last act.
    return any(os.path.exists(f"{interface}/{name}/country") for name in names if "." in name)


def _existing(path: Path) -> Path | None:
    return path if path.exists() else None


class VirtualBus:
    """All virtual knobs of a test."""

    def __init__(self) -> None:
        self.knobs: list[VirtualKnob] = []

    def plug(
        self,
        serial: str = "KNOB-1",
        *,
        rate_hz: int = 1000,
        hand: str = "pushes",
        options: Sequence[str] = (),
        wait: bool = True,
        cable: Cable = plain_cable,
    ) -> VirtualKnob:
        """Start a knob and plug it in."""
        knob = VirtualKnob(serial, rate_hz, hand, options)
        self.knobs.append(knob)
        knob.plug(wait=wait, cable=cable)
        return knob

    def end(self) -> None:
        """Unplug all and end all programs."""
        while self.knobs:
            self.knobs.pop().end()
