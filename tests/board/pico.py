"""The boards' firmware in emulated chips, on a bench with a USB host.

Reports are written and read by ``tests.python.wire``, which shares nothing with the firmware.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import struct
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from tests.board.rp2350.bench import Bench
from tests.board.rp2350.chip import World
from tests.python import wire
from tools import uf2

TREE = Path(__file__).parent.parent.parent
FOLDER = TREE / "tests" / "board"
FIRMWARE = TREE / "build" / "firmware"
BUILD = TREE / "build" / "board-tests"
ROM = BUILD / "boot_rom.bin"
FAST = BUILD / "fast.so"

FLASH_BASE = 0x10000000
SERIAL = bytes.fromhex("E66118604B7A3C2D")
MS = 1_000_000
FEATURE = 3
STRINGS = ("languages", "manufacturer", "product", "serial", "control", "game")


@dataclass(frozen=True)
class Model:
    """Facts about a board."""

    name: str
    number: int  # on the wire
    chip: str
    tick_ns: int
    step_ns: int  # period of the current loop
    clock_hz: int
    flash_size: int
    watchdog_ms: int

    @property
    def motor_lag_s(self) -> float:
        """Return by how much its current loop trails, as a configuration begins with it.

        In each period it goes so much of the way, at 10 kHz, or a tenth of the control rate of the
        simple loop; the predictive one has to wait for a period first. The missing parts add up.
        """
        period_s = 1e-9 * self.step_ns
        predicts = self.chip == "rp2350"
        share = -math.expm1(-2 * math.pi * (1e4 * period_s if predicts else 0.1))
        return period_s * (1 / share - 0.5 + (1 if predicts else 0))

    @property
    def image(self) -> Path:
        """Return the file that a user copies to the board."""
        return FIRMWARE / f"torsio-{self.name}.uf2"

    @property
    def slots_at(self) -> int:
        """Return where in the flash the configuration begins."""
        return self.flash_size - 2 * 4096

    @property
    def pwm_step(self) -> float:
        """Return the smallest change of a bridge's share: half a period of 40 kHz has so many."""
        return 40_000 * 2 / self.clock_hz


MODELS = {
    "pico": Model("pico", 1, "rp2040", 100_000, 100_000, 200_000_000, 2 * 1024 * 1024, 10),
    "pico2": Model("pico2", 2, "rp2350", 50_000, 25_000, 150_000_000, 4 * 1024 * 1024, 8),
}
chosen = MODELS["pico"]


def choose(name: str) -> None:
    """Make every board from now on one of this model."""
    global chosen  # tests run one after the other in a process
    chosen = MODELS[name]


class Commands(Protocol):
    """A chip on a bench, told what to do by name."""

    def do(self, name: str, **details: Any) -> Any:
        """Carry out one command and return its answer."""

    def close(self) -> None:
        """End it."""


class NodeBench:
    """The emulated RP2040, a process of its own."""

    def __init__(self) -> None:
        theirs, ours = os.pipe()
        self._answers = os.fdopen(ours, "w")
        self._process = subprocess.Popen(
            [shutil.which("node") or "node", FOLDER / "host.mjs", str(theirs)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            pass_fds=[theirs],
            text=True,
        )
        os.close(theirs)
        self._world: World

    def do(self, name: str, **details: Any) -> Any:
        if "world" in details:
            self._world = details.pop("world")
        assert self._process.stdin
        assert self._process.stdout
        self._process.stdin.write(json.dumps({"do": name, **details}) + "\n")
        self._process.stdin.flush()
        while "world" in (answer := json.loads(self._process.stdout.readline())):
            amperes, edges = self._world(*answer["world"])
            self._answers.write(json.dumps({"amperes": amperes, "edges": edges}) + "\n")
            self._answers.flush()
        if "error" in answer:
            raise RuntimeError(answer["error"])
        return answer["ok"]

    def close(self) -> None:
        assert self._process.stdin
        assert self._process.stdout
        self._process.stdin.close()
        self._answers.close()
        self._process.wait(timeout=30)
        self._process.stdout.close()


def chips_bench(model: Model) -> Commands:
    """Give the bench of a board's emulated chip."""
    return NodeBench() if model.chip == "rp2040" else Bench(FAST)


class UsbStall(Exception):
    """The device stalled a request."""


class PowerCut(Exception):
    """The power went while the flash was being written."""


class EmulatedPico:
    """One board on the bench. Time passes only inside its methods."""

    def __init__(
        self,
        make_bench: Callable[[Model], Commands] | None = None,
        image: Path | None = None,
    ) -> None:
        self.model = chosen
        self._image = image or self.model.image
        self.bench = (make_bench or chips_bench)(self.model)
        self._sequence = 0
        self.telemetry: list[dict[str, Any]] = []
        self.events: list[dict[str, Any]] = []
        self._acknowledgements: list[dict[str, Any]] = []

    def __enter__(self) -> EmulatedPico:
        return self

    def __exit__(self, *_: object) -> None:
        self.bench.close()

    def do(self, name: str, **details: Any) -> Any:
        """Give the bench one command and return its answer."""
        answer = self.bench.do(name, **details)
        if answer == "power cut":
            raise PowerCut
        return answer

    # Power and bus ----------------------------------------------------------------------------

    def boot(self) -> None:
        """Power up with freshly flashed firmware."""
        pages = uf2.check(self._image.read_bytes(), self.model.chip)
        image = {str(address - FLASH_BASE): page.hex() for address, page in pages.items()}
        self.do("boot", rom=str(ROM), image=image, serial=SERIAL.hex())

    def power_cycle(self) -> None:
        """Switch off and on again; the flash keeps what it has."""
        self.do("power_cycle")

    def run(self, ms: float) -> int:
        """Let time pass and return it, in ns since the first power-up."""
        return int(self.do("run", ns=ms * MS))

    def status(self) -> dict[str, Any]:
        """Return what the bench knows without asking the device."""
        return dict(self.do("status"))

    def control(
        self, kind: int, request: int, value: int, index: int, length: int, data: bytes = b""
    ) -> bytes:
        """Carry out a control transfer; return what the device sent."""
        setup = struct.pack("<BBHHH", kind, request, value, index, length)
        answer = self.do("control", setup=setup.hex(), data=data.hex())
        if answer.get("stall"):
            raise UsbStall
        assert "timeout" not in answer, "the device does not answer"
        return bytes.fromhex(answer["data"])

    def enumerate(self) -> dict[str, bytes]:
        """Do what a host does with a new device; return the descriptors."""
        assert self.do("wait_attached", within_ns=500 * MS)
        self.do("bus_reset")
        found = {"device": self.control(0x80, 6, 0x0100, 0, 18)}
        self.control(0x00, 5, 7, 0, 0)
        self.run(2)  # the time that USB 2.0, 9.2.6.3 allows a device
        assert self.status()["address"] == 7
        (size,) = struct.unpack_from("<H", self.control(0x80, 6, 0x0200, 0, 9), 2)
        found["configuration"] = self.control(0x80, 6, 0x0200, 0, size)
        for index, name in enumerate(STRINGS):
            found[name] = self.control(0x80, 6, 0x0300 | index, 0x0409 if index else 0, 255)
        self.control(0x00, 9, 1, 0, 0)
        self.control(0x21, 0x0A, 0, 0, 0)
        (size,) = struct.unpack_from("<H", found["configuration"], 9 + 9 + 7)
        found["report"] = self.control(0x81, 6, 0x2200, 0, size)
        return found

    # Reports ----------------------------------------------------------------------------------

    def get(self, name: str) -> dict[str, Any]:
        """Read a feature report."""
        found, values = wire.decode(self.get_raw(wire.REPORTS[name].id))
        assert found == name
        return values

    def get_raw(self, report: int) -> bytes:
        """Read a feature report as bytes."""
        return self.control(0xA1, 0x01, FEATURE << 8 | report, 0, wire.REPORT_SIZE)

    def set_raw(self, report: int, data: bytes) -> None:
        """Send any bytes as a feature report."""
        self.control(0x21, 0x09, FEATURE << 8 | report, 0, len(data), data)

    def set(self, name: str, **changes: Any) -> dict[str, Any]:
        """Change fields of a feature report; return its acknowledgement."""
        values = {**self.get(name), **changes, "sequence": self._next()}
        self.set_raw(wire.REPORTS[name].id, wire.encode(name, values))
        return self.acknowledgement()

    def write(self, data: bytes, within_ms: float = 50, endpoint: int = 1) -> str:
        """Send bytes to an interrupt OUT endpoint: ``ack`` or ``nak``."""
        return str(self.do("out", endpoint=endpoint, data=data.hex(), within_ns=within_ms * MS))

    def read(self, within_ms: float = 5) -> tuple[str, dict[str, Any]] | None:
        """Fetch one input report."""
        answer = self.do("in", endpoint=1, within_ns=within_ms * MS)
        return None if answer == "nak" else wire.decode(bytes.fromhex(answer["data"]))

    def send(self, name: str, **values: Any) -> dict[str, Any]:
        """Send an output report and return its acknowledgement."""
        self.post(name, **values)
        return self.acknowledgement()

    def post(self, name: str, **values: Any) -> None:
        """Send an output report that is not acknowledged."""
        if "slot" in values:
            target = {"sequence": self._next(), "axis": 0, "slot": values.pop("slot")}
            full: dict[str, Any] = {"target": target, **values}
        else:
            full = {"sequence": self._next(), "axis": 0, **values}
        assert self.write(wire.encode(name, full)) == "ack"

    def command(self, op: str) -> str:
        """Give a command and return the name of its status."""
        return STATUS[self.send("command", op=op)["status"]]

    def arm_at_wall(self, walls: int = 1, **values: Any) -> None:
        """Arm with a wall that begins at angle 0, or with so many of them."""
        self.play_walls(walls, **values)
        assert self.command("arm") == "ok"

    def play_walls(self, walls: int, **values: Any) -> None:
        """Commit so many walls that begin at angle 0."""
        wall = {
            "angle_turns_q32": 0,
            "side": "above",
            "stiffness_nm_per_rad": 2.0,
            "damping_nm_s_per_rad": 0.0,
        }
        for slot in range(walls):
            assert self.send("wall", slot=slot, **wall | values)["status"] == 0
        assert self.send("commit", active=(1 << walls) - 1)["status"] == 0

    def acknowledgement(self, reads: int = 400) -> dict[str, Any]:
        """Return the acknowledgement of the newest report; keep whatever else comes."""
        for _ in range(reads):
            self.listen(1)
            for answer in self._acknowledgements:
                if answer["sequence"] == self._sequence:
                    self._acknowledgements.clear()
                    return answer
        raise AssertionError("no acknowledgement")

    def listen(self, reads: int, within_ms: float = 5) -> None:
        """Fetch input reports and sort them."""
        for _ in range(reads):
            found = self.read(within_ms)
            if found is None:
                continue
            name, values = found
            kept = {
                "telemetry": self.telemetry,
                "event": self.events,
                "acknowledgement": self._acknowledgements,
            }
            kept[name].append(values)

    def _next(self) -> int:
        self._sequence = (self._sequence + 1) & 0xFFFF
        return self._sequence

    # The world around the board ----------------------------------------------------------------

    def turn(self, edges: int, period_us: float = 20) -> None:
        """Turn the encoder by so many edges."""
        self.do("turn", edges=edges, period_ns=period_us * 1000)

    def slip(self, times: int, period_us: float = 20) -> None:
        """Have both channels of the encoder change at once, so often."""
        self.do("turn", edges=times, period_ns=period_us * 1000, step=2)

    def couple(self, world: World) -> None:
        """Have motor and encoder moved by a world from now on."""
        self.do("couple", world=world)

    def emergency_stop(self, pressed: bool) -> None:
        """Press the button, which opens its contact as a cut wire does, or release it."""
        self.do("pin", pin=11, high=pressed)

    def motor(self) -> float | None:
        """Return the share of the supply's voltage on the motor; None while the stage is off."""
        first, second, enable = self.do("high_share", pins=[6, 7, 10])
        if not enable:
            assert not first
            assert not second
            return None
        return float(first - second)

    def brake(self) -> float | None:
        """Return the share of the supply's voltage on the brake; None while the stage is off."""
        first, second, enable = self.do("high_share", pins=[8, 9, 10])
        if not enable:
            assert not first
            assert not second
            return None
        return float(first - second)


STATUS = (
    *("ok", "bad_length", "bad_padding", "unknown_report", "not_finite", "out_of_range"),
    *("inconsistent", "bad_axis", "empty_slot", "not_armed", "not_disarmed", "fault_latched"),
    *("fault_persists", "stale", "busy", "not_owner", "unsupported"),
)


def make_parts() -> None:
    """Compile the RP2040's boot ROM, and what the RP2350 does too often for Python."""
    BUILD.mkdir(parents=True, exist_ok=True)
    elf = BUILD / "boot_rom.elf"
    flags = ["-mcpu=cortex-m0plus", "-mthumb", "-O1", "-ffreestanding", "-nostdlib"]
    warnings = ["-Wall", "-Wextra", "-Werror"]
    layout = ["-Wl,--section-start=.header=0", "-Wl,-Ttext=0x100", "-Wl,-e,0x100"]
    source = str(FOLDER / "boot_rom.c")
    command = ["arm-none-eabi-gcc", *flags, *warnings, *layout, source, "-o", str(elf)]
    subprocess.run(command, check=True)
    part = BUILD / "boot_rom.part"
    subprocess.run(["arm-none-eabi-objcopy", "-O", "binary", elf, part], check=True)
    content = part.read_bytes()
    ROM.write_bytes(content.ljust(16 * 1024, b"\0"))
    fast = ["cc", "-O2", "-shared", "-fPIC", str(FOLDER / "rp2350/fast.c"), "-o", str(FAST)]
    subprocess.run(fast, check=True)


def confirm(pico: EmulatedPico) -> None:
    """Confirm the configured parts. Then the board gives full torque."""
    assert pico.set("board_config", confirmed="on")["status"] == 0
    assert pico.set("calibration_config", values_are="stated")["status"] == 0


@contextmanager
def rewired(
    image: Path | None = None, report: str = "board_config", **config: Any
) -> Iterator[EmulatedPico]:
    """Give a board that was started anew with another wiring, disarmed, and knows its host."""
    with enumerated(image) as pico:
        assert pico.set(report, **config)["status"] == 0
        restart_saved(pico)
        yield pico


def restart_saved(pico: EmulatedPico) -> None:
    """Save the configuration, and start the board anew with it."""
    pico.do("erase_time", ns=MS)
    assert pico.command("save") == "ok"
    pico.power_cycle()
    pico.enumerate()


@contextmanager
def enumerated(image: Path | None = None) -> Iterator[EmulatedPico]:
    """Give a board that has booted and knows its host."""
    with EmulatedPico(image=image) as pico:
        pico.boot()
        pico.enumerate()
        confirm(pico)
        yield pico


if __name__ == "__main__":
    make_parts()
