"""Check that includes point one way, from the outer layers to the inner ones.

``python -m tools.check_layers [TREE]`` prints one line per violation and exits with 1 if there is
any. The rules are the table below. ``./dev generate`` prints a shorter one into
docs/explanation/architecture.md; a file in none of its folders is not checked.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

# Headers of the standard library that cost the microcontroller nothing: no heap, no streams, no
# locale, and no <cmath>, whose functions round differently from one C library to the next.
FREE_STD = frozenset(
    {
        *("array", "bit", "compare", "concepts", "cstddef", "cstdint", "limits", "numbers"),
        *("new", "optional", "span", "string_view", "tuple", "type_traits", "utility", "variant"),
    }
)
DEVICE_STD = FREE_STD | {"algorithm", "atomic", "cstring", "initializer_list"}

_INCLUDE = re.compile(r'^\s*#\s*include\s*(<[^>]+>|"[^"]+"|\S+)')
_POSIX = re.compile(r"(arpa|linux|net|netinet|sys)/.*|(errno|fcntl|netdb|poll|termios|unistd)\.h")


@dataclass(frozen=True)
class Rule:
    """The includes that are allowed below one folder."""

    folder: str
    what: str
    """The folder's content, for docs/explanation/architecture.md."""
    layers: tuple[str, ...]
    """Folders, or files, inside the project that they may name."""
    never: tuple[str, ...] = ()
    """Folders, or files, inside these that they may not."""
    std: frozenset[str] | None = None
    """Allowed headers of the standard library; None allows all of them."""
    posix: bool = False
    third_party: str = ""
    """Regular expression of further headers between angle brackets."""
    others: str = ""
    """Whose they are."""


# A guest knows nothing of these.
WITH_GUESTS = ("device/device.hpp", "device/control_loop.hpp")
FIRMWARE = ("core", "protocol", "device", "emulator")
STUDIES = ("actuators", "narrow", "steppers", "wide")

# Of the SDK, as docs/explanation/architecture.md lists them: each includes only those before it.
PARTS = (
    *("link", "arming", "event_feed", "device_state", "requests", "sample_feed", "session"),
    *("scene_player", "telemetry_stream", "swing_warnings", "knob_impl"),
)

# The first rule whose folder (or file) matches decides, so that exceptions come before the rule.
RULES = (
    Rule(
        "firmware/core",
        "the control mathematics: motion, soft sensor, brake model, scene, partition, slew",
        ("core",),
        std=FREE_STD,
    ),
    Rule(
        "firmware/protocol",
        "every report as structures and constexpr layouts, printed from `definition/`; the codec",
        ("protocol",),
        std=FREE_STD,
    ),
    Rule(
        "firmware/device/dial",
        "the dial: the knob as a wheel of the desktop, its units, reports and detents",
        ("core", "protocol", "device"),
        never=("device/game", *WITH_GUESTS),
        std=DEVICE_STD,
    ),
    Rule(
        "firmware/device/game",
        "games: the reports of a HID PID device, its pool of effects, their forces. A knob is a "
        "dial or a game controller, never both",
        ("core", "protocol", "device"),
        never=("device/dial", *WITH_GUESTS),
        std=DEVICE_STD,
    ),
    Rule(
        "firmware/device/device.hpp",
        "the device with a guest of either kind",
        ("core", "protocol", "device"),
        std=DEVICE_STD,
    ),
    Rule(
        "firmware/device/usb_interfaces.hpp",
        "descriptors of all interfaces",
        ("core", "protocol", "device"),
        std=DEVICE_STD,
    ),
    Rule(
        "firmware/device",
        "the device: reports, states and faults, scene commit, configuration store, telemetry, "
        "logic of the power stage",
        ("core", "protocol", "device"),
        never=("device/game", "device/dial"),
        std=DEVICE_STD,
    ),
    Rule(
        "firmware/usb",
        "the device on TinyUSB's device stack, for boards and the virtual knob",
        ("core", "protocol", "device", "usb"),
        std=DEVICE_STD,
        third_party=r"tusb\.h|device/(dcd|usbd_pvt)\.h",
        others="TinyUSB",
    ),
    Rule(
        "firmware/boards/board.hpp",
        "what a board says of itself; the host uses it too",
        ("device",),
        std=DEVICE_STD,
    ),
    Rule(
        "firmware/boards/rp2/pins.hpp",
        "what the chip's pins can do; the host uses it too",
        ("protocol", "device"),
        std=DEVICE_STD,
    ),
    Rule(
        "firmware/boards",
        "a folder for each board: `board.cmake`, and a header with number, control period and "
        "pins. `rp2/` has pins, timers and power stages of the RP2040 and RP2350",
        ("core", "protocol", "device", "usb", "boards"),
        third_party=r"(hardware|pico)/.*\.h",
        others="Raspberry Pi's SDK",
    ),
    Rule(
        "emulator/usbip/bus.cpp",
        "the virtual knob's device controller, its only file that knows TinyUSB",
        (*FIRMWARE, "usb"),
        third_party=r"tusb\.h|device/dcd\.h",
        others="TinyUSB",
    ),
    Rule(
        "emulator/usbip",
        "the emulated device as a USB device, served over USB/IP; see [USB](../reference/usb.md)",
        (*FIRMWARE, "usb"),
        posix=True,
    ),
    Rule(
        "emulator/plant",
        "the physics: model, hands, and the exact method in `exact/`; they know nothing of the "
        "device",
        ("emulator/plant", "torsio/plant.hpp", "torsio/plant_fields.hpp"),
    ),
    Rule(
        "emulator/include",
        "headers of the plant for users, printed from `definition/`; `field.hpp` is written by "
        "hand, and the library uses it too",
        ("torsio",),
    ),
    Rule(
        "emulator/emulated_device.cpp",
        "the emulated device, with the wiring of the board that it stands in for",
        (*FIRMWARE, "boards", "torsio/plant.hpp"),
    ),
    Rule(
        "emulator",
        "the same device against simulated physics under a virtual clock. `closed_loop.*` and "
        "`batch.*` have controller and plant without protocol, one loop or thousands",
        (*FIRMWARE, "torsio/plant.hpp", "torsio/plant_fields.hpp", "torsio/field.hpp"),
        never=("emulator/usbip",),
        posix=True,
    ),
    Rule("sdk/include", "what users of the C++ library see", ("torsio",)),
    Rule(
        "sdk/src/hid_transport.cpp",
        "the only file that knows hidapi",
        ("protocol", "torsio"),
        posix=True,
        third_party=r"hidapi\.h",
        others="hidapi",
    ),
    Rule(
        "sdk/conversion/scene.cpp",
        "scenes; the device's own check, in words",
        (*FIRMWARE[:3], "conversion", "torsio"),
    ),
    Rule(
        "sdk/conversion/stability.cpp",
        "how stiff a wall can be, computed as on the device",
        (*FIRMWARE[:3], "conversion"),
    ),
    Rule(
        "sdk/conversion/swings.cpp",
        "whether the knob may swing or hum, computed as on the device",
        (*FIRMWARE[:3], "conversion"),
    ),
    Rule(
        "sdk/conversion/energies.cpp",
        "the ledger in the user's units",
        ("protocol", "core/ledger.hpp", "conversion", "torsio"),
    ),
    Rule(
        "sdk/conversion/heat.hpp",
        "the continuous current of a motor, computed as on the device",
        ("protocol", "core/heat_model.hpp"),
    ),
    Rule(
        "sdk/conversion",
        "the user's units to the wire's and back, for library and bindings; rules across fields",
        ("protocol", "device/config_rules.hpp", "device/wiring.hpp", "conversion", "torsio"),
    ),
    Rule(
        "sdk/src/limits.cpp",
        "the most that a device gives, computed as on the device",
        ("protocol", "device/actuator_limits.hpp", "conversion", "torsio"),
    ),
    Rule(
        "sdk/src/process.cpp",
        "tells a forked child that the knob is not its own",
        ("sdk", "torsio"),
        third_party=r"pthread\.h",
        others="`pthread.h`",
    ),
    Rule(
        "sdk/src/known_boards.cpp",
        "the boards, and why a board refuses a wiring",
        ("protocol", "device", "boards"),
    ),
    Rule("sdk/src/known_boards.hpp", "likewise", ("protocol", "device")),
    Rule(
        "sdk/src/emulated",
        "the emulated knob, which may be left out",
        (
            *(*FIRMWARE, "conversion", "emulated", "torsio"),
            *("emulated_transport.hpp", "fair_mutex.hpp", "link.hpp", "process.hpp"),
        ),
    ),
    Rule(
        "sdk/src/device_lock_windows.cpp",
        "the lock of a device on Windows",
        ("torsio",),
        third_party=r"windows\.h",
        others="Windows",
    ),
    Rule(
        "sdk/src",
        "the C++ host library over a public transport interface",
        ("protocol", "conversion", "torsio"),
        posix=True,
    ),
    Rule(
        "sdk/c/include",
        "headers for users of C, in C alone",
        ("torsio_base.h", "torsio_types.h"),
        third_party=r"std(bool|def|int)\.h",
        others="C's own headers",
    ),
    Rule(
        "sdk/c/src",
        "the library in C, on top of the C++ headers",
        ("torsio", "torsio.h", "torsio_types.h"),
    ),
    Rule(
        "examples/c",
        "a program for users of C",
        ("torsio.h",),
        third_party=r"(torsio|stdio|stdbool)\.h",
        others="C's own headers",
    ),
    Rule(
        "examples/octave",
        "functions for Octave",
        ("torsio.h",),
        third_party=r"(torsio|mex|stdlib|string)\.h",
        others="Octave",
    ),
    Rule(
        "bindings/src",
        "the Python extension: the library, and parts of firmware and emulator",
        (*FIRMWARE, "conversion", "torsio"),
        posix=True,
        third_party=r"pybind11/.*|Python\.h",
        others="pybind11",
    ),
    Rule(
        "studies/src/bindings",
        "the studies' own Python extension",
        (*FIRMWARE, *STUDIES, "bindings/module.hpp", "bindings/src/stepper_capsule.hpp"),
        third_party=r"pybind11/.*",
        others="pybind11",
    ),
    Rule(
        "studies/src",
        "rival actuators, other steppers, the controller in 64 bits and the plant in 32",
        (*FIRMWARE, *STUDIES),
    ),
    Rule(
        "studio/wasm",
        "the emulated device for a browser: a dozen functions, compiled to WebAssembly",
        ("emulator", "conversion/swings.hpp"),
    ),
    Rule("examples/project", "a program outside of this tree, to be copied", ("torsio",)),
    Rule("examples/cpp", "smallest useful programs, each run by the tests", ("torsio",)),
    Rule(
        "examples/game",
        "a game that knows nothing of Torsio",
        (),
        third_party=r"SDL\.h",
        others="SDL",
    ),
)


def _rank(rule: Rule) -> tuple[int, int, int]:
    """Put a folder before what is in it, and else keep the order of the rules."""
    above = min(
        (of for of in RULES if f"{rule.folder}/".startswith(f"{of.folder}/")),
        key=lambda of: len(of.folder),
    )
    return RULES.index(above), rule.folder.count("/"), RULES.index(rule)


def may_include(rule: Rule) -> str:
    """Say in words what the files below a folder may include."""
    own = rule.folder.partition("/")[2] or rule.folder
    named = [f"`{layer}`" for layer in rule.layers if layer not in (own, rule.folder)]
    named += [f"not `{layer}`" for layer in rule.never]
    named += [rule.others] if rule.others else []
    named += ["POSIX"] if rule.posix else []
    if rule.std is not None:
        named.append(
            f"{'a few' if rule.std is FREE_STD else 'some'} headers of the standard library"
        )
    return ", ".join(named)


def table() -> str:
    """Write the rules as the table of docs/explanation/architecture.md."""
    rows = []
    for rule in sorted(RULES, key=_rank):
        slash = "" if "." in rule.folder else "/"
        rows.append(f"| `{rule.folder}{slash}` | {rule.what} | {may_include(rule)} |\n")
    return "| folder or file | what it is | may include |\n|---|---|---|\n" + "".join(rows)


def rule_for(file: str) -> Rule | None:
    """Return the rule of a file, given by its path from the top of the tree."""
    for rule in RULES:
        if file == rule.folder or file.startswith(rule.folder + "/"):
            return rule
    return None


def _is_later_part(including: Path, name: str) -> bool:
    part, other = including.stem, Path(name).stem
    return {part, other} <= {*PARTS} and PARTS.index(part) < PARTS.index(other)


def _may_quote(rule: Rule, including: Path, name: str) -> bool:
    """Tell whether a file may include one of the tree's own by this name."""
    if _is_later_part(including, name):
        return False
    # Made from a file beside the including one.
    beside = (including.parent / name, including.parent / name.removesuffix(".h"))
    if "/" not in name and any(path.exists() for path in beside):
        return True
    if any(_is_in(name, layer) for layer in rule.never):
        return False
    return any(_is_in(name, layer) for layer in rule.layers)


def _is_in(name: str, layer: str) -> bool:
    return name == layer or name.startswith(f"{layer}/")


def _may_have(rule: Rule, name: str) -> bool:
    """Tell whether a file may include a header of the system, or of others, by this name."""
    if "/" not in name and "." not in name:
        return rule.std is None or name in rule.std
    if rule.posix and _POSIX.fullmatch(name):
        return True
    return bool(rule.third_party and re.fullmatch(rule.third_party, name))


def _refusal(rule: Rule, including: Path, include: str) -> str | None:
    name = include[1:-1]
    is_quoted = include.startswith('"')
    if not is_quoted and not include.startswith("<"):
        return f"includes {include}, which cannot be checked"
    if _may_quote(rule, including, name) if is_quoted else _may_have(rule, name):
        return None
    if not is_quoted and "/" not in name and "." not in name:
        return f"may not include {include}: not in the layer's list of standard headers"
    return f"may not include {include}"


def _violations(tree: Path) -> Iterator[str]:
    for top in sorted({rule.folder.split("/")[0] for rule in RULES}):
        for path in sorted((tree / top).rglob("*")):
            if path.suffix not in {".hpp", ".cpp", ".h", ".c"}:
                continue
            file = path.relative_to(tree).as_posix()
            rule = rule_for(file)
            if rule is None:
                yield f"{file}:1: no layer owns this folder"
                continue
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                match = _INCLUDE.match(line)
                if match and (refusal := _refusal(rule, path, match.group(1))):
                    yield f"{file}:{number}: {refusal}"


def check(tree: Path) -> list[str]:
    """Return a line for every C++ include in a tree that the rules do not allow."""
    return list(_violations(tree))


def main(arguments: list[str]) -> int:
    """Print the violations in the tree given, by default the one this file is in."""
    tree = Path(arguments[0]) if arguments else Path(__file__).parent.parent
    violations = check(tree)
    print("\n".join(violations) or "layers: includes point one way")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
