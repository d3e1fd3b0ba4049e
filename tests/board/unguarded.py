"""The boards' firmware with guards that tests can switch off, to see what they are there for.

A copy of the sources in ``build/unguarded`` in which each guard is a choice at run time, as mutants
are (``tests/mutation/lists.py``): bit n of a word in RAM, which the tests find by its name in the
ELF file, takes away guard n. It is not cleared at start-up, so that what happens there can be
without a guard too.
"""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tests.board import pico
from tests.board.pico import EmulatedPico, enumerated
from tests.mutation.lists import Place, Replacement, mutate_source, put

TREE = pico.TREE
BUILD = TREE / "build" / "unguarded"
COPY = BUILD / "tree"
FOLDERS = ("firmware", "cmake")
WORD = "torsio_guards_off"

_SWITCH = f"""\
#pragma once
#include <type_traits>
extern "C" volatile unsigned {WORD};
inline bool guard_is_off(int number) {{ return ({WORD} >> number & 1U) != 0; }}
constexpr bool torsio_mutant_is(int number) {{
  if (std::is_constant_evaluated()) return false;
  return guard_is_off(number);
}}
"""
_DEFINITION = f"""\
extern "C" {{
[[gnu::used, gnu::section(".uninitialized_data.guards")]] volatile unsigned {WORD};
}}
"""
MAIN = "firmware/boards/rp2/main.cpp"
POWER = "firmware/device/power_logic.cpp"


@dataclass(frozen=True)
class Guard:
    """A line that stands against a danger, and what is left of it without."""

    file: str
    line: str
    without: str


GUARDS = {
    "emergency stop": Guard(
        MAIN, "inputs.emergency_stop = gpio_get(emergency_stop_pin);",
        "inputs.emergency_stop = false;",
    ),
    "bridge's word": Guard(POWER, "over_current() || (bridge_reports && settled)",
                           "over_current()"),
    "over-current": Guard(POWER, "over_current() || (bridge_reports && settled)",
                          "bridge_reports && settled"),
    "bridge's waking": Guard(POWER, "!enabled_ || steps_enabled_ == settle_steps_", "true"),
    "winding": Guard(POWER, "believed_ ? 0 : fault::winding", "0"),
    "supply": Guard(POWER, "supply_fits_ ? 0 : fault::supply", "0"),
    "sensor's zero": Guard(POWER, "zero_fits ? 0 : fault::current_sensor", "0"),
    "motor's heat": Guard(
        POWER, "current_max_a_ = core::allow_current(motor_heat_, motor_heat_params_);", ";",
    ),
    "coil's heat": Guard(
        POWER, "coil_max_a_ = core::allow_current(coil_heat_, coil_heat_params_);", ";",
    ),
    "temperature": Guard(POWER, "motor_heat_.too_hot || coil_heat_.too_hot", "false"),
    "jumps": Guard(
        "firmware/device/control_loop.cpp",
        "static_cast<std::uint32_t>(out.motion.delta_counts) + limit_counts > 2 * limit_counts",
        "false",
    ),
    "loose plug": Guard(
        MAIN,
        "core::finds_loose_plug(lost_steps, kForgetLostTicks, encoder->take_lost_step())",
        "false",
    ),
    "dead channel": Guard(
        MAIN,
        "core::finds_dead_channel(encoder_watch, kLongestFlipTicks, inputs.encoder_count) && "
        "!the_device->shakes()",
        "false",
    ),
    "overrun": Guard("firmware/device/control_loop.cpp",
                     "return @{lateness_ >= kLatenessLimit}@;", "false"),
    "timid": Guard(
        "firmware/device/config_store.cpp", "trust_in(@{moves_parts}@, config.board", "false",
    ),
    "layout": Guard("firmware/device/config_store.cpp",
                    "get_u32(bytes, kLayoutAt) != protocol::fingerprint()", "false"),
    "watchdog": Guard("firmware/boards/rp2/life_watch.hpp", "watchdog_enable(time_ms_, false);",
                      ";"),
    "ticks counted": Guard("firmware/boards/rp2/life_watch.hpp",
                           "if (@{ticks_done != last_seen_}@) watchdog_update();", "true"),
    "power cut": Guard(MAIN, "@{cut_power();}@ leave_reset_cause(why);", ";"),
    "stack's mark": Guard(MAIN, "if (@{!stack_is_whole()}@) panic", "false"),
}  # fmt: skip
NUMBERS = {name: number for number, name in enumerate(GUARDS)}


def _places() -> dict[str, list[tuple[Place, list[int]]]]:
    found: dict[tuple[str, str], tuple[Place, list[int]]] = {}
    for name, guard in GUARDS.items():
        spot = (guard.file, guard.line)
        if spot not in found:
            found[spot] = (Place(guard.file, guard.line, f"guard '{name}'"), [])
        place, numbers = found[spot]
        place.replacements.append(Replacement(guard.without, place.where))
        numbers.append(NUMBERS[name])
    of_file: dict[str, list[tuple[Place, list[int]]]] = {}
    for (file, _), place_and_numbers in found.items():
        of_file.setdefault(file, []).append(place_and_numbers)
    return of_file


def mutated() -> dict[str, str]:
    """Give each source that has a guard, with the choices in it.

    Raises
    ------
    tests.mutation.lists.BadList
        A guard is not where it is said to be.
    """
    found = {}
    for file, places in _places().items():
        text = mutate_source((TREE / file).read_text(encoding="utf-8"), places)
        own = _DEFINITION if file == MAIN else ""
        found[file] = f'#include "guard_switch.hpp"\n{own}{text}'
    return found


def make_copy() -> None:
    """Bring the copy of the sources up to date."""
    texts = mutated()
    wanted = {COPY / "CMakeLists.txt", COPY / "firmware" / "guard_switch.hpp"}
    put(COPY / "CMakeLists.txt", (TREE / "CMakeLists.txt").read_bytes())
    put(COPY / "firmware" / "guard_switch.hpp", _SWITCH.encode())
    for folder in FOLDERS:
        for source in sorted((TREE / folder).rglob("*")):
            if source.is_file() and "__pycache__" not in source.parts:
                name = str(source.relative_to(TREE))
                put(COPY / name, texts[name].encode() if name in texts else source.read_bytes())
                wanted.add(COPY / name)
    for path in list(COPY.rglob("*")):
        if path.is_file() and path not in wanted:
            path.unlink()


def _elf() -> Path:
    return BUILD / pico.chosen.name / f"torsio-{pico.chosen.name}.elf"


@cache
def _address(elf: Path) -> int:
    listing = subprocess.run(["arm-none-eabi-nm", elf], capture_output=True, text=True, check=True)
    (line,) = (line for line in listing.stdout.splitlines() if line.endswith(f" {WORD}"))
    return int(line.split()[0], 16)


def image() -> Path:
    """Give the file of the chosen board."""
    return _elf().with_suffix(".uf2")


def take_away(board: EmulatedPico, *guards: str) -> None:
    """Be without these guards from now on, and with all others."""
    word = sum(1 << NUMBERS[name] for name in guards)
    board.do("poke", address=_address(_elf()), word=word)


def start_without(board: EmulatedPico, *guards: str) -> None:
    """Power up without these guards, and meet the host."""
    board.power_cycle()
    take_away(board, *guards)
    board.enumerate()
    pico.confirm(board)


@contextmanager
def unguarded() -> Iterator[EmulatedPico]:
    """Give a board that has booted, knows its host and has all its guards so far."""
    with enumerated(image()) as board:
        yield board


if __name__ == "__main__":
    make_copy()
