"""The device on the processors it is made for: same numbers, within a budget, no luggage."""

from __future__ import annotations

import re
import subprocess

import pytest

import torsio
from firmware.protocol.definition import costs
from tests.mcu import mcu
from tests.mcu.mcu import CHIPS
from tools import firmware_report, stack_bound, uf2
from torsio.trading.found import board_shares

BUDGETS = costs.INSTRUCTIONS
# Each run counts the same, so a tick may be above its budget by hardly more than rounding.
MARGIN, MORE = 1.01, 3.5
MARGIN_OF_ANOTHER_GCC = 1.10
MOST_INSTRUCTIONS = 249  # in a wall, measured
MOST_CALIBRATED = 320  # in a wall with that law, by GCC 12
RAM_BYTES = {"rp2040": 264 * 1024, "rp2350": 520 * 1024}


BUDGET = {board: budget for board, budget in BUDGETS.items() if board in CHIPS}
SCENES = [(board, scene) for board, scenes in BUDGET.items() for scene in scenes]


@pytest.fixture(scope="module")
def measured() -> dict[tuple[str, str], float]:
    return {
        (board, f"{cost.scene} {cost.effects}"): cost.instructions
        for board in BUDGET
        for cost in mcu.costs(board)
    }


@pytest.mark.parametrize(("board", "scene"), SCENES)
def test_tick_stays_within_its_instruction_budget(
    measured: dict[tuple[str, str], float], board: str, scene: str
) -> None:
    budget = BUDGET[board][scene]
    if mcu.gcc_major() != mcu.DOCUMENTED_GCC:
        most = budget * MARGIN_OF_ANOTHER_GCC
    else:
        most = max(budget * MARGIN, budget + MORE)
    assert measured[board, scene] <= most


def test_every_measured_scene_has_a_budget(measured: dict[tuple[str, str], float]) -> None:
    assert set(measured) == set(SCENES)


@pytest.mark.parametrize("board", BUDGET)
def test_cost_grows_in_a_straight_line_with_the_active_effects(
    measured: dict[tuple[str, str], float], board: str
) -> None:
    one = measured[board, "walls 1"]
    per_effect = (measured[board, "walls 16"] - one) / 15
    for effects in (2, 4, 8):
        expected = one + (effects - 1) * per_effect
        assert measured[board, f"walls {effects}"] == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("board", BUDGET)
def test_effects_that_are_written_but_not_in_the_scene_cost_nothing(
    measured: dict[tuple[str, str], float], board: str
) -> None:
    # One of 16 written walls plays. The counter of pico2 is coarse: 50 in 2048 ticks.
    alone = measured[board, "walls 1"]
    assert measured[board, "walls, 16 written 1"] == pytest.approx(alone, abs=0.1)


@pytest.mark.board("pico2")
def test_knees_of_the_shaft_cost_the_product_at_most_ten_instructions(
    measured: dict[tuple[str, str], float],
) -> None:
    assert measured["pico2", "bent shaft 1"] - measured["pico2", "straight shaft 1"] <= 10


@pytest.mark.board("pico2")
def test_wall_on_the_product_takes_no_more_instructions_than_it_did(
    measured: dict[tuple[str, str], float],
) -> None:
    assert measured["pico2", "wall 1"] <= MOST_INSTRUCTIONS
    assert measured["pico2", "walls 1"] <= MOST_INSTRUCTIONS
    if mcu.gcc_major() < 14:
        assert measured["pico2", "walls, calibrated 1"] <= MOST_CALIBRATED


@pytest.mark.pages
def test_time_of_a_tick_is_near_that_of_the_binary() -> None:
    text = (mcu.TREE / "docs/results.md").read_text(encoding="utf-8")
    table = text.split("<!-- begin: damped walls -->")[1].split("<!-- end")[0]
    damped = torsio.Wall(stiffness_nm_per_rad=1.4, damping_nm_s_per_rad=1e-3)
    for column, walls in enumerate((0, 1, 4, 6)):
        for board in board_shares([damped] * walls, torsio.ControlConfig()):
            row = re.search(rf"^\| `{board.board}`[^|]*\|(.*)\|$", table, re.M)
            assert row
            told_us = float(row[1].split("|")[column])
            assert board.time_ns / 1e3 == pytest.approx(told_us, rel=0.15)
            assert board.share == board.time_ns / {"pico": 1e5, "pico2": 5e4}[board.board]


@pytest.fixture(scope="module")
def host_replay() -> str:
    return mcu.on_host("replay")


def test_replay_covers_every_kind_of_effect_and_every_law(host_replay: str) -> None:
    lines = host_replay.splitlines()
    assert len(lines) == 13 + 5
    checksums = [line.rsplit(" ", 1)[1] for line in lines]
    assert len(set(checksums)) == len(checksums)


@pytest.mark.board("pico2")
def test_cortex_m33_puts_out_the_same_bits_as_the_host(host_replay: str) -> None:
    assert mcu.on_m33("replay") == host_replay


@pytest.mark.board("pico")
def test_cortex_m0plus_multiplies_as_the_host_does() -> None:
    assert mcu.on_m0plus("multiply") == mcu.on_host("multiply")


@pytest.mark.board("pico")
def test_cortex_m0plus_puts_out_the_same_bits_as_the_host(host_replay: str) -> None:
    assert mcu.on_m0plus("replay") == host_replay


# Symbols that the firmware must not contain. pico-sdk wraps the double functions into one that
# panics, under other names.
FORBIDDEN = {
    "heap": r"_?malloc(_r)?|calloc|realloc|_sbrk|_Znwj|_Znaj",
    "exceptions": r"__cxa_throw|__cxa_begin_catch|_Unwind_RaiseException",
    "rtti": r"_ZTI.*|__dynamic_cast",
    "printf": r".*printf.*|_dtoa_r|puts|putchar",
    "double": r"__aeabi_d(add|sub|mul|div|2f|2iz)|__aeabi_f2d|__aeabi_i2d",
}


@pytest.mark.parametrize("board", CHIPS)
@pytest.mark.parametrize("luggage", FORBIDDEN)
def test_firmware_contains_no(board: str, luggage: str) -> None:
    symbols = firmware_report.sizes(mcu.FIRMWARE / f"torsio-{board}.elf").symbols
    assert len(symbols) > 100
    assert [name for name in symbols if re.fullmatch(FORBIDDEN[luggage], name)] == []


@pytest.mark.parametrize("board", CHIPS)
def test_firmware_calls_no_double_arithmetic(board: str) -> None:
    # pico-sdk leaves wrappers behind that panic; only they may call each other.
    elf = mcu.FIRMWARE / f"torsio-{board}.elf"
    command = ["arm-none-eabi-objdump", "-d", "--no-show-raw-insn", str(elf)]
    listing = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    double = re.compile(r"(__wrap_|__)?__aeabi_(c?d\w+|f2d|u?i2d|u?l2d)(_veneer)?$")
    caller = ""
    offenders = []
    for line in listing.splitlines():
        if match := re.match(r"[0-9a-f]+ <(.+)>:$", line):
            caller = match.group(1)
        elif (call := re.search(r"\bbl?x?\s.*<([^+>]+)>", line)) and double.match(call.group(1)):
            offenders.append((caller, call.group(1)))
    assert [pair for pair in offenders if not double.match(pair[0])] == []


@pytest.mark.parametrize("board", CHIPS)
def test_firmware_leaves_a_quarter_of_the_ram_free(board: str) -> None:
    taken_bytes = firmware_report.sizes(mcu.FIRMWARE / f"torsio-{board}.elf").ram
    assert taken_bytes < RAM_BYTES[CHIPS[board]] * 3 / 4


@pytest.mark.parametrize("board", CHIPS)
def test_stack_has_room_for_the_deepest_path_and_every_interrupt_on_top(board: str) -> None:
    deepest = stack_bound.of_firmware(mcu.FIRMWARE / f"torsio-{board}.elf")
    assert deepest.total_bytes <= deepest.room_bytes
    assert deepest.room_bytes == 4096  # PICO_STACK_SIZE


@pytest.mark.parametrize(("board", "chip"), CHIPS.items())
def test_uf2_holds_exactly_what_the_elf_loads_and_its_checksum(board: str, chip: str) -> None:
    elf = (mcu.FIRMWARE / f"torsio-{board}.elf").read_bytes()
    image = (mcu.FIRMWARE / f"torsio-{board}.uf2").read_bytes()
    assert uf2.check(image, chip) == uf2.seal(uf2.read_elf(elf))


@pytest.mark.board("pico2")
def test_boot_rom_of_the_rp2350_finds_what_it_starts() -> None:
    """Within 4 kB stands an IMAGE_DEF, and its block loop closes (RP2350 datasheet, 5.9)."""
    pages = uf2.check((mcu.FIRMWARE / "torsio-pico2.uf2").read_bytes(), "rp2350")
    flash = {address + at: byte for address, page in pages.items() for at, byte in enumerate(page)}

    def word(address: int) -> int:
        return int.from_bytes(bytes(flash[address + at] for at in range(4)), "little")

    block_begin, block_end = 0xFFFFDED3, 0xAB123579
    start = min(flash)
    first = next(at for at in range(start, start + 4096, 4) if word(at) == block_begin)
    # One word of image type: an executable, secure, for Arm, for this chip.
    assert word(first + 4) == 0x42 | 1 << 8 | (0x1 | 2 << 4 | 1 << 12) << 16
    block = first
    visited: list[int] = []
    while not visited or block != first:
        assert block not in visited
        visited.append(block)
        assert word(block) == block_begin
        last = block + 4
        while word(last) & 0xFF != 0xFF:  # the item that closes the list
            last += 4 * (word(last) >> 8 & 0xFF)
        assert word(last + 8) == block_end
        block = (block + word(last + 4)) % 2**32
