"""Linux's own tool ``usbip`` with ``torsio emulate``, as a person uses them."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path
from typing import TextIO

import pytest

import torsio
from tests.python import wire
from tests.vm.guest.child import Child, become_nobody, torsio_command
from tests.vm.guest.virtual_bus import CONTROLLER, VirtualBus, wait_for

# Ubuntu has it among the tools of its kernels.
FOLDERS = ["/usr/sbin", *map(str, Path("/usr/lib/linux-tools").glob("*"))]
# Here everybody is root, and the module is loaded.
GUEST = 'sudo() { "$@"; }; modprobe() { [ "$*" = vhci-hcd ]; }; '


def shell(command: str) -> str:
    """Run a command line, which must end well, and return what it prints."""
    result = subprocess.run(
        ["sh", "-e", "-c", GUEST + command],
        env={**os.environ, "PATH": ":".join([*FOLDERS, os.environ["PATH"]])},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stdout
    return result.stdout


@pytest.mark.kernel("6.12")
@pytest.mark.pulls_cable
def test_printed_command_plugs_the_knob_in_and_usbip_detach_takes_it_out() -> None:
    emulate = torsio_command("emulate", "--port", "0", "--serial", "TOOL")
    listening, linux = emulate.output.readline(), emulate.output.readline()
    port = re.fullmatch(r"listening 127\.0\.0\.1:(\d+) 1-1\n", listening)
    assert port is not None
    assert f"({wire.USB_ID})" in shell(f"usbip --tcp-port {port[1]} list -r 127.0.0.1")
    command = linux.strip().removeprefix("Linux:").strip()
    assert "usbip" in command
    shell(command)

    def serials() -> list[str]:
        return [device.serial for device in torsio.list_devices() if not device.problem]

    wait_for("the knob", lambda: serials() == ["TOOL", "EMULATED"])
    with torsio.open("TOOL") as knob:
        knob.arm()
        assert len(knob.record(duration_s=0.1)) == 100
    assert f"usbip://127.0.0.1:{port[1]}/1-1" in shell("usbip port")
    shell("sudo usbip detach -p 00")
    wait_for("the knob to go", lambda: serials() == ["EMULATED"])
    emulate.interrupt()
    lines = [line.split()[0] for line in emulate.end().splitlines() if line]
    assert [word for word in lines if word in ("attached", "configured", "detached")] == [
        "attached",
        "configured",
        "detached",
    ]


@pytest.mark.kernel("6.12")
def test_nobody_but_root_may_attach_a_knob(bus: VirtualBus) -> None:
    knob = bus.plug()
    knob.unplug()

    def work(output: TextIO) -> None:
        become_nobody()
        try:
            knob.plug(wait=False)  # the server gives it to every client
        except PermissionError as error:
            output.write(f"{error.filename}: {error.strerror}")

    assert Child(work).end() == f"{CONTROLLER}/attach: Permission denied"
