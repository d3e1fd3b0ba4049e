"""The calls between a board's program and its device, and the same calls on this machine.

The program is the file that ships. Its places are found by their symbols; nothing is compiled in.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from tests.board.pico import TREE, EmulatedPico
from tests.python import wire

RETRACE = TREE / "build/mcu/host/retrace"
REPORT_BYTES, INPUTS_BYTES, OUTPUTS_BYTES = 64, 20, 9  # the outputs' padding is left out

_TICK = "_ZN6torsio6device11ControlLoop4tickERKNS0_10TickInputsE"
_GIVE = "_ZN6torsio6device11ControlLoop4giveERKNS0_5OrderE"
_RECEIVE = "_ZN6torsio6device6Device7receiveESt4spanIKhLj4294967295EE"
_FEATURE = "_ZN6torsio6device6Device11set_featureESt4spanIKhLj4294967295EE"
_CONNECTED = "_ZN6torsio6device6Device13set_connectedEb"
_SERVICE = "_ZN6torsio6device6Device7serviceEv"
_NEXT = "_ZN6torsio6device6Device10next_inputERSt5arrayIhLj64EEb"


@dataclass
class Trace:
    """Events as lines for ``retrace``, and their results.

    Attributes
    ----------
    outputs
        Of each tick, as its bytes in hex.
    reports
        To the host, in hex.
    """

    lines: list[str] = field(default_factory=list)
    outputs: list[str] = field(default_factory=list)
    reports: list[str] = field(default_factory=list)


def _places(elf: str) -> list[dict[str, Any]]:
    """Find where calls begin and end."""
    command = ["arm-none-eabi-objdump", "-d", "--no-show-raw-insn", elf]
    listing = subprocess.run(command, capture_output=True, text=True, check=True).stdout

    def begin(symbol: str) -> int:
        found = re.search(rf"^([0-9a-f]+) <{symbol}>:$", listing, re.MULTILINE)
        assert found, symbol
        return int(found[1], 16)

    def ends(symbol: str) -> list[int]:
        """Return the addresses behind the calls of a function."""
        called = rf"^\s*[0-9a-f]+:\s+bl\s+[0-9a-f]+ <{symbol}>\s*\n\s*([0-9a-f]+):"
        found = re.findall(called, listing, re.MULTILINE)
        assert found, symbol
        jumped = rf"^\s*[0-9a-f]+:\s+b(?:\.[nw])?\s+[0-9a-f]+ <{symbol}>"
        assert not re.search(jumped, listing, re.MULTILINE), f"{symbol} ends elsewhere"
        return [int(address, 16) for address in found]

    def last_stores(symbol: str, count: int) -> list[int]:
        """Return the addresses of a function's last stores; a tick may come behind each."""
        body = listing.split(f" <{symbol}>:\n")[1].split("\n\n")[0]
        found = re.findall(r"^\s*([0-9a-f]+):\s+(?:str|stl)\s", body, re.MULTILINE)
        return [int(address, 16) for address in found[-count:]]

    def place(name: str, at: int, pointer: tuple[str, int] | None = None, size: int = 0) -> Any:
        return {"name": name, "at": at, "pointer": pointer, "size": size}

    # An order is in its ring, and then the tick is told to look.
    stored, given = last_stores(_GIVE, 2)
    return [
        place("tick", begin(_TICK), ("tick", 2), INPUTS_BYTES),
        *(place("ticked", at, ("tick", 0), OUTPUTS_BYTES) for at in ends(_TICK)),
        place("receive", begin(_RECEIVE), ("receive", 1), REPORT_BYTES),
        place("feature", begin(_FEATURE), ("feature", 1), REPORT_BYTES),
        place("connected", begin(_CONNECTED)),
        place("service", begin(_SERVICE)),
        place("stored", stored),
        place("given", given),
        place("next", begin(_NEXT)),
        *(place("nexted", at, ("next", 1), REPORT_BYTES) for at in ends(_NEXT)),
    ]


@contextmanager
def traced(board: EmulatedPico) -> Iterator[Trace]:
    """Trace a board from its power-up on."""
    elf = board.model.image.with_suffix(".elf")
    board.do("trace", places=_places(str(elf)))
    trace = Trace()
    yield trace
    _read(board.do("passed"), trace)


def _read(passed: list[Any], trace: Trace) -> None:  # noqa: C901 - a table
    """Put calls of the main loop, which ticks interrupt, to where they took effect.

    A host's action takes effect where an order is given; a service without an order where it
    looked for one. A tick may come when an order is in its ring and the tick is not yet told to
    look: whether it looked all the same, as it does while something fades, its answer says.
    """
    given = looked = stored = ticks = 0
    for index, (name, *registers, memory) in enumerate(passed):
        match name:
            case "tick":
                trace.lines.append(f"tick {memory}")
                ticks += 1
            case "ticked":
                trace.outputs.append(memory)
            case "receive":
                trace.lines.append(f"receive {memory[: 2 * registers[2]]}")
            case "feature":
                trace.lines.append(f"feature {memory[: 2 * registers[2]]}")
            case "connected":
                trace.lines.append(f"connected {registers[1] & 1}")
            case "service":
                given, looked = 0, len(trace.lines)
                trace.lines.append("service")
            case "given":
                early = stored < len(trace.lines) and _answered_at(passed[index:]) == ticks - 1
                trace.lines.insert(stored if early else len(trace.lines), "service")
                if given == 0:
                    del trace.lines[looked]
                given += 1
            case "stored":
                stored = len(trace.lines)
            case "nexted":
                trace.lines.append("next")
                if registers[0] & 0xFF:
                    trace.reports.append(memory)
    if ticks > len(trace.outputs):  # the trace has ended within a tick
        last = next(n for n, line in enumerate(reversed(trace.lines)) if line.startswith("tick"))
        del trace.lines[-1 - last :]


def _answered_at(passed: list[Any]) -> int | None:
    """Return the tick that the next acknowledgement names."""
    for name, *registers, memory in passed:
        if name == "nexted" and registers[0] & 0xFF and memory.startswith("41"):
            return int(wire.decode(bytes.fromhex(memory))[1]["tick"])
    return None


def again(board: EmulatedPico, trace: Trace) -> Trace:
    """Do the same on this machine."""
    result = subprocess.run(
        [RETRACE, board.model.name],
        input="\n".join(trace.lines) + "\n",
        capture_output=True,
        text=True,
        check=True,
    )
    found = Trace(lines=trace.lines)
    for line in result.stdout.splitlines():
        what, content = line.split()
        (found.outputs if what == "tick" else found.reports).append(content)
    return found
