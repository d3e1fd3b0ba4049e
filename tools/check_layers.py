"""Check that includes point one way, from the outer layers to the inner ones.

``python -m tools.check_layers [TREE]`` prints one line per violation and exits with 1 if there is
any. The rules are the table below; a file in none of its folders is not checked.
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
    """What the files below one folder may include."""

    folder: str
    layers: tuple[str, ...]
    """Folders, or files, inside the project that they may name."""
    never: str = ""
    """A folder inside one of these that they may not."""
    std: frozenset[str] | None = None
    """Allowed headers of the standard library; None allows all of them."""
    posix: bool = False
    third_party: str = ""
    """Regular expression of further headers between angle brackets."""


FIRMWARE = ("core", "protocol", "device", "emulator")
STUDIES = ("actuators", "narrow", "steppers", "wide")

# The first rule whose folder (or file) matches decides, so that exceptions come before the rule.
RULES = (
    Rule("firmware/core", ("core",), std=FREE_STD),
    Rule("firmware/protocol", ("protocol",), std=FREE_STD),
    # Two guests of the device, of which only one is there at a time.
    Rule(
        "firmware/device/dial", ("core", "protocol", "device"), never="device/game", std=DEVICE_STD
    ),
    Rule(
        "firmware/device/game", ("core", "protocol", "device"), never="device/dial", std=DEVICE_STD
    ),
    Rule("firmware/device", ("core", "protocol", "device"), std=DEVICE_STD),
    # The device on TinyUSB's device stack, whatever it runs on.
    Rule(
        "firmware/usb",
        ("core", "protocol", "device", "usb"),
        std=DEVICE_STD,
        third_party=r"tusb\.h|device/(dcd|usbd_pvt)\.h",
    ),
    # What a board says of itself and its pins is for the host too.
    Rule("firmware/boards/board.hpp", ("device",), std=DEVICE_STD),
    Rule("firmware/boards/rp2/pins.hpp", ("protocol", "device"), std=DEVICE_STD),
    # Everything else there: the SDK, and what it generates.
    Rule(
        "firmware/boards",
        ("core", "protocol", "device", "usb", "boards"),
        third_party=r"(hardware|pico)/.*\.h",
    ),
    # The only file of the virtual USB knob that knows TinyUSB: its device controller.
    Rule(
        "emulator/usbip/bus.cpp",
        (*FIRMWARE, "usb"),
        third_party=r"tusb\.h|device/dcd\.h",
    ),
    Rule("emulator/usbip", (*FIRMWARE, "usb"), posix=True),
    # The physics know nothing of what they move.
    Rule("emulator/plant", ("emulator/plant", "torsio/plant.hpp", "torsio/plant_fields.hpp")),
    Rule("emulator/include", ("torsio",)),
    # It has the wiring of the board that it stands in for.
    Rule("emulator/emulated_device.cpp", (*FIRMWARE, "boards", "torsio/plant.hpp")),
    Rule(
        "emulator",
        (*FIRMWARE, "torsio/plant.hpp", "torsio/field.hpp"),
        never="emulator/usbip",
        posix=True,
    ),
    Rule("sdk/include", ("torsio",)),
    Rule(
        "sdk/src/hid_transport.cpp",
        ("protocol", "torsio"),
        posix=True,
        third_party=r"hidapi\.h",
    ),
    # Host units and wire units; bindings and studies have it too.
    Rule("sdk/conversion/stability.cpp", (*FIRMWARE[:3], "conversion")),
    Rule("sdk/conversion/energies.cpp", ("protocol", "core/ledger.hpp", "conversion", "torsio")),
    Rule("sdk/conversion/heat.hpp", ("protocol", "core/heat_model.hpp")),
    Rule("sdk/conversion", ("protocol", "device/wiring.hpp", "conversion", "torsio")),
    # What a forked child must know.
    Rule("sdk/src/process.cpp", ("sdk", "torsio"), third_party=r"pthread\.h"),
    # They say why a board refuses a wiring.
    Rule("sdk/src/known_boards.cpp", ("protocol", "device", "boards")),
    Rule("sdk/src/known_boards.hpp", ("protocol", "device")),
    Rule(
        "sdk/src/emulated",
        (
            *(*FIRMWARE, "conversion", "emulated", "torsio"),
            *("emulated_transport.hpp", "fair_mutex.hpp", "process.hpp", "session.hpp"),
        ),
    ),
    # The same on another system.
    Rule("sdk/src/device_lock_windows.cpp", ("torsio",), third_party=r"windows\.h"),
    Rule("sdk/src", ("protocol", "conversion", "torsio"), posix=True),
    # C's users see C alone, and what is behind it only what C++'s users see.
    Rule("sdk/c/include", ("torsio_base.h", "torsio_types.h"), third_party=r"std(bool|def|int)\.h"),
    Rule("sdk/c/src", ("torsio", "torsio.h", "torsio_types.h")),
    Rule("examples/c", ("torsio.h",), third_party=r"(torsio|stdio|stdbool)\.h"),
    Rule("examples/octave", ("torsio.h",), third_party=r"(torsio|mex|stdlib|string)\.h"),
    Rule(
        "bindings/src",
        (*FIRMWARE, "conversion", "torsio"),
        posix=True,
        third_party=r"pybind11/.*|Python\.h",
    ),
    Rule(
        "studies/src/bindings",
        (*FIRMWARE, *STUDIES, "bindings/module.hpp", "bindings/src/stepper_capsule.hpp"),
        third_party=r"pybind11/.*",
    ),
    Rule("studies/src", (*FIRMWARE, *STUDIES)),
    # The emulated device for a browser, and nothing of the SDK.
    Rule("studio/wasm", ("emulator",)),
    Rule("examples/cpp", ("torsio",)),
    # A game knows nothing of Torsio, and the lock in it nothing of SDL.
    Rule("examples/game/lock.cpp", ("game",)),
    Rule("examples/game/lock.hpp", ("game",)),
    Rule("examples/game", ("game",), third_party=r"SDL\.h"),
)


def rule_for(file: str) -> Rule | None:
    """Return the rule of a file, given by its path from the top of the tree."""
    for rule in RULES:
        if file == rule.folder or file.startswith(rule.folder + "/"):
            return rule
    return None


def _refusal(rule: Rule, including: Path, include: str) -> str | None:
    name = include[1:-1]
    if include.startswith('"'):
        if "/" not in name and (including.parent / name).exists():
            return None
        # Made from a file beside the including one.
        if "/" not in name and (including.parent / name.removesuffix(".h")).exists():
            return None
        if rule.never and name.startswith(f"{rule.never}/"):
            return f"may not include {include}"
        if any(name == layer or name.startswith(f"{layer}/") for layer in rule.layers):
            return None
        return f"may not include {include}"
    if not include.startswith("<"):
        return f"includes {include}, which cannot be checked"
    if "/" not in name and "." not in name:
        if rule.std is None or name in rule.std:
            return None
        return f"may not include {include}: not in the layer's list of standard headers"
    if rule.posix and _POSIX.fullmatch(name):
        return None
    if rule.third_party and re.fullmatch(rule.third_party, name):
        return None
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
