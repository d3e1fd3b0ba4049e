"""How deep the stack of a firmware can get, from its machine code.

A function's frame is everything that it pushes or subtracts from the stack pointer; a path's depth
is the sum along the calls. The bound is the deepest path from the program's start plus the deepest
one of every interrupt, as if each had come at the worst moment of the one before. The tables
below add what the code does not tell. Anything else that it does not tell is an error, not a
guess.
``tools/firmware_report.py`` prints the result.
"""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

from tools import boards

# Calls through pointers: caller and targets, as regular expressions of mangled names. Every target
# must exist, unless nothing is ever called there.
INDIRECT: dict[str, tuple[str, ...]] = {
    # The control law asks game or dial for its force, the control loop for everything else.
    r".*(4core7control|8run_full|ControlLoop4tick|Device4tick|on_tick|on_step).*": (
        r".*(6Forces|7Detents)9torque_nm.*",
    ),
    r".*11ControlLoop.*": (
        r".*(5Guest|6Forces|7Detents)(9take_news|7play_on|10stay_awake|7release|4drop|6forget)E.*",
    ),
    # The device asks its guest in the main loop.
    r".*6Device(C[12]|7service|13set_connected|11set_buttons|11reconfigure).*|tud_umount_cb": (
        r".*(9PidEngine|4Dial|13GuestFunction)"
        r"(6player|7service|9configure|6settle|11set_buttons|10begin_anew)E.*",
    ),
    # The board's rule for its wiring.
    r".*6device11check_rules.*(11BoardConfig|14ActuatorConfig).*": (r".*17find_pin_conflict.*",),
    # An interface of the device's, behind the class driver.
    r".*(15control_request|8poll_hid).*": (
        r".*11get_feature.*",
        r".*9get_input.*",
        r".*11set_feature.*",
        r".*7receive.*",
        r".*10next_input.*",
    ),
    r".*(13transfer_done|N_15reset).*": (r".*10input_over.*",),
    # TinyUSB calls the functions of its class driver, and what is to come after a control transfer.
    r"tud_task_ext|tud_rhport_init|configuration_reset|usbd_control_xfer_cb": (
        r".*torsio3usb12_GLOBAL__N_1.*",
    ),
    # In its interrupt only sof and xfer_isr, which the driver does not have.
    r"dcd_event_handler": (),
    # The SDK calls its own initialisers.
    r"runtime_init|runtime_run_initializers": (r"(__pre_init_)?runtime_init_.*",),
    # Nothing is registered there: no transactional memory.
    r"(de)?register_tm_clones": (),
    # The next handler of the same interrupt is an interrupt of the list below.
    r"irq_handler_chain_.*": (),
}
# The boot ROM cannot be read here. The bytes are an allowance.
ROM_CALLERS = (
    r"rom_.*|flash_.*|__aeabi_(bits|mem)_init|__wrap_.*|_enter_vtable_in_r0|.*bootrom.*"
    r"|_retrieve_unique_id_on_boot"
)
ROM_BYTES = 256
# Before the program: they set the stack pointer, then call these one after the other.
START = r"_enter_vtable_in_r0|platform_entry|_entry_point|_reset_handler"
PROGRAM = ("runtime_init", "main")
INTERRUPTS = (r".*7on_(step|tick)Ev", r"dcd_rp2040_irq")
# The processor itself pushes these: 8 registers, 17 of floating point with one of padding, and 4
# bytes of alignment; and the SDK's chain of handlers for a shared interrupt.
EXCEPTION_BYTES = {"rp2040": 36 + 8, "rp2350": 108 + 8}


class UnknownStack(ValueError):
    """The code does not tell how much stack it takes."""


@dataclass
class Function:
    """A function's use of the stack."""

    frame_bytes: int = 0
    calls: set[str] = field(default_factory=set)
    is_indirect: bool = False
    complaints: list[str] = field(default_factory=list)
    # Frames too large for an immediate: the address of the constant that is added to sp.
    constants: list[int] = field(default_factory=list)


def _register_bytes(text: str) -> int:
    count = 0
    for part in text.split(","):
        first, _, last = part.strip().partition("-")
        count += int(last[1:]) - int(first[1:]) + 1 if last else 1
    return count * (8 if text.startswith("d") else 4)


def _pushes(name: str, operands: str) -> bool:
    return name in ("push", "vpush") or (name in ("stmdb", "vstmdb") and operands.startswith("sp!"))


def _pushed_bytes(operation: str, operands: str) -> int | None:
    """Bytes by which an instruction lowers the stack pointer; None if nobody can know."""
    name = operation.split(".")[0]
    if match := re.match(r"(?:sp!?, )?\{(.*)\}$", operands):
        return _register_bytes(match.group(1)) if _pushes(name, operands) else 0
    if match := re.search(r"\[sp, #-(\d+)\]!", operands):
        return int(match.group(1))
    if name in ("sub", "subw") and (match := re.match(r"sp, (?:sp, )?#(\d+)", operands)):
        return int(match.group(1))
    if name in ("add", "addw") and re.match(r"sp, (?:sp, )?#\d+", operands):
        return 0
    if name == "msr":
        return None if re.match(r"[MP]SP\b", operands) else 0
    writes_sp = re.match(r"sp\b", operands) and not name.startswith(("cmp", "str", "tst"))
    return None if writes_sp else 0


_HEAD = re.compile(r"([0-9a-f]+) <(.+)>:$")
_LINE = re.compile(r"\s*([0-9a-f]+):\t(\S+)\t?([^@;]*)(?:[@;] \(?([0-9a-f]+) )?")
_TARGET = re.compile(r"(\w+) <([^+>]+)(?:\+0x[0-9a-f]+)?>$")


class _Listing:
    """Reads a listing, line after line."""

    def __init__(self, labels: frozenset[str]) -> None:
        self.functions: dict[str, Function] = {}
        self._labels = labels
        self._owners: dict[str, str] = {}
        self._starts: dict[str, str] = {}  # functions by their address
        self._words: dict[int, int] = {}
        self._loaded: dict[str, int] = {}  # where a register's constant stands
        self._name = ""

    def begin(self, address: str, name: str) -> None:
        """Take the line that a function, or a label inside one, begins with."""
        if name in self._labels:
            self._owners[name] = self._name
            return
        self._name = name
        self._starts[address.lstrip("0")] = name
        self.functions.setdefault(name, Function())
        if veneer := re.fullmatch(r"__(.+)_veneer", name):
            self.functions[name].calls.add(veneer.group(1))

    def take(self, address: str, operation: str, operands: str, constant: str | None) -> None:
        """Take an instruction or a word of the current function."""
        if not self._name:
            return
        if operation == ".word":
            self._words[int(address, 16)] = int(operands, 16)
        if operation.startswith("."):
            return
        function = self.functions[self._name]
        if operation.startswith("ldr") and constant and "[pc" in operands:
            self._loaded[operands.split(",")[0]] = int(constant, 16)
        if operation == "add" and (large := re.fullmatch(r"sp, (r\d+)", operands)):
            function.constants.append(self._loaded.get(large.group(1), 0))
        elif target := _TARGET.search(operands):
            if operation.startswith("b") and target.group(2) != self._name:
                function.calls.add(target.group(2))
                # objdump may call a function by another symbol of the same address.
                self._owners.setdefault(target.group(2), target.group(1))
        else:
            self._lower(function, operation, operands)

    def _lower(self, function: Function, operation: str, operands: str) -> None:
        if operation in ("blx", "bx") and operands != "lr" and not self._name.endswith("_veneer"):
            function.is_indirect = True
        pushed = _pushed_bytes(operation, operands)
        if pushed is None:
            function.complaints.append(f"{self._name}: {operation} {operands}")
        else:
            function.frame_bytes += pushed

    def finish(self) -> None:
        """Name the callees by their functions, and add the frames that constants make."""
        for name, function in self.functions.items():
            owned = {callee: self._owners.get(callee, callee) for callee in function.calls}
            function.calls = {
                callee if callee in self.functions else self._starts.get(owner, owner)
                for callee, owner in owned.items()
            } - {name}
            for address in function.constants:
                if address not in self._words:
                    function.complaints.append(f"{name}: sp changed by an unknown amount")
                # A positive number at the end gives back the bytes taken at the beginning.
                elif self._words[address] >= 1 << 31:
                    function.frame_bytes += (1 << 32) - self._words[address]


def read_listing(listing: str, labels: frozenset[str] = frozenset()) -> dict[str, Function]:
    """Read the functions from the output of ``objdump -d --no-show-raw-insn``.

    ``labels`` are symbols in the middle of a function, as assembler code has them.
    """
    read = _Listing(labels)
    for line in listing.splitlines():
        if head := _HEAD.match(line):
            read.begin(head.group(1), head.group(2))
        elif match := _LINE.match(line):
            read.take(match.group(1), match.group(2), match.group(3).strip(), match.group(4))
    read.finish()
    return read.functions


def resolve(functions: dict[str, Function]) -> None:
    """Add the calls through pointers that the tables know; any other is a complaint.

    Raises
    ------
    UnknownStack
        If a target that a table names is not there.
    """
    for name, function in functions.items():
        plain = name.split(".")[0]
        if not function.is_indirect or re.fullmatch(START, plain):
            continue
        if re.fullmatch(ROM_CALLERS, plain):
            function.frame_bytes += ROM_BYTES
            continue
        targets = next((t for key, t in INDIRECT.items() if re.fullmatch(key, plain)), None)
        if targets is None:
            function.complaints.append(f"call through a pointer in {name}")
            continue
        for pattern in targets:
            found = {other for other in functions if re.fullmatch(pattern, other)}
            if not found:
                raise UnknownStack(f"{name} should call {pattern}, which is not there")
            function.calls |= found - {name}


def depth_bytes(functions: dict[str, Function], root: str) -> tuple[int, list[str]]:
    """Return the deepest stack below a function, and the path there.

    Raises
    ------
    UnknownStack
        For recursion, or for code that does not tell what it takes. Code that is never
        reached may be as it likes: newlib 4.5 leaves the end of a program behind, which has none.
    """
    done: dict[str, tuple[int, list[str]]] = {}

    def visit(name: str, path: tuple[str, ...]) -> tuple[int, list[str]]:
        if name in path:
            raise UnknownStack("recursion: " + " -> ".join([*path[path.index(name) :], name]))
        if name not in done:
            function = functions.get(name, Function())
            if function.complaints:
                raise UnknownStack(function.complaints[0])
            below = [visit(callee, (*path, name)) for callee in sorted(function.calls)]
            deepest, way = max(below, default=(0, []))
            done[name] = (function.frame_bytes + deepest, [name, *way])
        return done[name]

    return visit(root, ())


@dataclass(frozen=True)
class Bound:
    """How deep a firmware's stack gets, and how deep it may get."""

    main_bytes: int
    interrupt_bytes: int
    room_bytes: int
    path: list[str]

    @property
    def total_bytes(self) -> int:
        """The main loop at its deepest, with every interrupt on top of it."""
        return self.main_bytes + self.interrupt_bytes


def bound(listing: str, labels: frozenset[str], chip: str, room_bytes: int) -> Bound:
    """Return the bound of one firmware.

    Raises
    ------
    UnknownStack
        If the code and the tables do not tell it.
    """
    functions = read_listing(listing, labels)
    resolve(functions)

    def only(pattern: str) -> str:
        names = [name for name in functions if re.fullmatch(pattern, name)]
        if len(names) != 1:
            raise UnknownStack(f"{pattern} is {names or 'not there'}")
        return names[0]

    main, path = max(depth_bytes(functions, only(root)) for root in PROGRAM)
    interrupts = sum(
        depth_bytes(functions, only(root))[0] + EXCEPTION_BYTES[chip] for root in INTERRUPTS
    )
    return Bound(main, interrupts, room_bytes, path)


def of_firmware(elf: Path) -> Bound:
    """Return the bound of ``torsio-BOARD.elf``."""

    def output(*command: str) -> str:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    # Number, value, size, type, binding, visibility, section, name.
    symbols = [
        line.split() for line in output("arm-none-eabi-readelf", "-sW", str(elf)).splitlines()
    ]
    symbols = [words for words in symbols if len(words) == 8 and words[1] != "Value"]
    labels = {words[7] for words in symbols if words[3] == "NOTYPE" and words[4] == "LOCAL"}
    values = {words[7]: int(words[1], 16) for words in symbols}
    listing = output("arm-none-eabi-objdump", "-d", "--no-show-raw-insn", str(elf))
    room_bytes = values["__StackTop"] - values["__StackBottom"]
    return bound(listing, frozenset(labels), boards.chip_of(elf), room_bytes)
