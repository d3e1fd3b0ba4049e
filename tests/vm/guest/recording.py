"""Plays effects as a real host does, and prints the reports that the host makes of them.

``python -m tests.vm.guest.recording wine`` or ``linux``, in a guest; see tests/vm/record_hosts.py.
"""

from __future__ import annotations

import json
import platform
import socket
import struct
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from tests.vm.guest import direct_input, effect_forms, gamepad
from tests.vm.guest.direct_input import LENGTH_MS, PUSHED
from tests.vm.guest.gamepad import Effect, Gamepad
from tests.vm.guest.torque_log import let_pass, plug
from tests.vm.guest.udev import running as running_udev
from tests.vm.guest.virtual_bus import VirtualBus

# USB/IP 1.1.1: a header, then the data of a transfer out.
_HEADER = struct.Struct(">5I4xI12x8s")
_SUBMIT, _OUT = 1, 0
_SET_REPORT = bytes((0x21, 0x09))
_GAME_INTERFACE, _GAME_ENDPOINT = 1, 2


class Recorder:
    """A cable that keeps what the host tells the game interface."""

    def __init__(self) -> None:
        self._told = bytearray()

    def cable(self, knob: socket.socket) -> socket.socket:
        """Return the host's end."""
        with socket.create_server(("127.0.0.1", 0)) as listener:
            host = socket.create_connection(listener.getsockname())
            middle, _ = listener.accept()
        for end in (host, middle):
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for source, sink, kept in ((knob, middle, None), (middle, knob, self._told)):
            threading.Thread(target=_pump, args=(source, sink, kept), daemon=True).start()
        return host

    def take(self) -> list[str]:
        """Return the reports since the last call, in hexadecimal digits."""
        return [report.hex(" ") for report in self._reports()]

    def _reports(self) -> Iterator[bytes]:
        while len(self._told) >= _HEADER.size:
            command, _, _, direction, endpoint, length, setup = _HEADER.unpack_from(self._told)
            size = length if (command, direction) == (_SUBMIT, _OUT) else 0
            if len(self._told) < _HEADER.size + size:
                return
            data = bytes(self._told[_HEADER.size : _HEADER.size + size])
            del self._told[: _HEADER.size + size]
            if not data:
                continue
            is_feature = setup[:2] == _SET_REPORT and setup[4] == _GAME_INTERFACE
            if endpoint == _GAME_ENDPOINT or (endpoint == 0 and is_feature):
                yield data


def _pump(source: socket.socket, sink: socket.socket, kept: bytearray | None) -> None:
    with suppress(OSError):
        while data := source.recv(1 << 16):
            if kept is not None:
                kept += data
            sink.sendall(data)
    with suppress(OSError):
        sink.shutdown(socket.SHUT_RDWR)  # ends the other direction too
    source.close()


def wine(bus: VirtualBus, folder: Path) -> dict[str, list[str]]:
    """Play what the tests under Wine do, and conditions."""
    recorder = Recorder()
    plug(bus, folder, cable=recorder.cable, range_deg=90)
    words = {name: told for name, (told, _) in direct_input.PLAYED.items()}
    conditions = ("spring", "damper", "inertia", "friction")
    words |= {kind: f"{kind} {LENGTH_MS} {PUSHED}" for kind in conditions}
    with direct_input.acquired(*direct_input.DIRECT_INPUT) as game:
        found = {"begin": recorder.take()}
        for name, told in words.items():
            game.play(name, told)
            found[name] = recorder.take()
    found["end"] = recorder.take()
    subprocess.run(["wineserver", "-k"], env=direct_input.environment(), check=False)
    return found


def linux(bus: VirtualBus, folder: Path) -> dict[str, list[str]]:
    """Play what the tests with event devices do, and conditions of three quarters' saturation."""
    recorder = Recorder()
    knob, _ = plug(bus, folder, cable=recorder.cable, range_deg=90)
    pad = Gamepad(knob)
    let_pass(knob, 0.1)
    played = {name: (case.effect, case.loops) for name, case in effect_forms.cases().items()}
    half = gamepad.condition(16384, saturation=0xC000)
    for name, kind in (("spring", gamepad.SPRING), ("damper", gamepad.DAMPER)):
        played[name] = (Effect(kind, half, LENGTH_MS), 1)
    for name, kind in (("inertia", gamepad.INERTIA), ("friction", gamepad.FRICTION)):
        played[name] = (Effect(kind, half, LENGTH_MS), 1)
    found = {"begin": recorder.take()}
    for name, (effect, loops) in played.items():
        number = pad.upload(effect)
        pad.play(number, loops=loops)
        pad.erase(number)
        let_pass(knob, 0.1)
        found[name] = recorder.take()
    pad.close()
    return found


def main(host: str) -> None:
    """Print the reports of one host as JSON."""
    bus = VirtualBus()
    with tempfile.TemporaryDirectory() as folder, running_udev():
        found = {"wine": wine, "linux": linux}[host](bus, Path(folder))
        bus.end()
    print(json.dumps({"kernel": platform.release(), "reports": found}))


if __name__ == "__main__":
    main(sys.argv[1])
