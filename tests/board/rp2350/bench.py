"""A USB host and a test bench round the emulated RP2350: the commands of host.mjs, in Python."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from unicorn import arm_const

from tests.board.rp2350.chip import Chip, World
from tests.board.rp2350.rom import PowerCut
from tests.board.rp2350.usb import RESET, RESUME, SUSPENDED

FRAME_NS = 1e6
RETRY_NS = 20e3  # a host repeats a token that was not acknowledged
STATUS_GAP_NS = 60e3


class Bench:
    """Does what it is told, by the name of a method."""

    def __init__(self, library: Path) -> None:
        self._library = library
        self.chip: Chip

    def do(self, name: str, **details: Any) -> Any:
        try:
            return getattr(self, f"do_{name}")(**details)
        except PowerCut:
            self.chip.rom.cut_after_bytes = None
            return "power cut"

    def close(self) -> None:
        """Nothing to end."""

    # Power and time -----------------------------------------------------------------------------

    def do_boot(self, rom: str, image: dict[str, str], serial: str) -> bool:
        pages = {int(address): bytes.fromhex(page) for address, page in image.items()}
        self.chip = Chip(self._library, pages, bytes.fromhex(serial))
        return True

    def do_power_cycle(self, brown_out: bool = False) -> bool:
        self.chip.power_up(brown_out=brown_out)
        return True

    def do_start_copied(self) -> bool:
        self.chip.power_up(copied=True)
        return True

    def do_run(self, ns: float) -> float:
        self.chip.run_for(ns)
        return self.chip.ns

    def do_status(self) -> dict[str, Any]:
        chip = self.chip
        return {
            "ns": chip.ns,
            "watchdog_resets": chip.watchdog_resets,
            "watchdog_least_left_ns": chip.watchdog_least_left_ns,
            "bootloader": chip.rom.bootloader,
            "tick_ns": chip.tick_ns,
            "interrupt_ns": chip.interrupt_ns,
            "tick_instructions": chip.tick_instructions,
            "pwm_starts": chip.pwm_starts,
            "lost": chip.rom.lost,
            "address": chip.usb.address,
            "stack": chip.core.uc.reg_read(arm_const.UC_ARM_REG_SP),
            "pc": chip.core.uc.reg_read(arm_const.UC_ARM_REG_PC),
        }

    # The bus ------------------------------------------------------------------------------------

    def do_wait_attached(self, within_ns: float) -> bool:
        return self.chip.run_for(within_ns, lambda: self.chip.usb.attached)

    def do_bus_reset(self) -> bool:
        self.chip.usb.signal(RESET)
        self.chip.run_for(10 * FRAME_NS)
        return True

    def do_suspend(self) -> bool:
        self.chip.usb.signal(SUSPENDED)
        return True

    def do_resume(self) -> bool:
        self.chip.usb.signal(RESUME)
        return True

    def do_out(self, endpoint: int, data: str, within_ns: float) -> str:
        answer = self._transact(endpoint, bytes.fromhex(data), within_ns)
        assert isinstance(answer, str)
        return answer

    def do_in(self, endpoint: int, within_ns: float) -> str | dict[str, str]:
        answer = self._transact(endpoint, None, within_ns)
        return answer if isinstance(answer, str) else {"data": answer.hex()}

    def do_control(self, setup: str, data: str = "") -> dict[str, Any]:
        """Carry out a control transfer: stall, timeout, or the data."""
        request = bytes.fromhex(setup)
        length = int.from_bytes(request[6:8], "little")
        within = 50 * FRAME_NS
        self.chip.usb.setup(request)
        self.chip.run_for(RETRY_NS)
        result = b""
        try:
            if request[0] & 0x80:
                while len(result) < length:
                    answer = self._transact(0, None, within)
                    if isinstance(answer, str):
                        return {"stall": True} if answer == "stall" else {"timeout": True}
                    result += answer
                    if len(answer) < 64:
                        break
                status = self._transact(0, b"", within)
            else:
                content = bytes.fromhex(data)
                for at in range(0, len(content), 64):
                    status = self._transact(0, content[at : at + 64], within)
                    if status != "ack":
                        return {"stall": True} if status == "stall" else {"timeout": True}
                status = self._transact(0, None, within)
                status = "ack" if status == b"" else status
            if status == "stall":
                return {"stall": True}
            return {"data": result.hex()} if status == "ack" else {"timeout": True}
        finally:
            self.chip.run_for(STATUS_GAP_NS)

    def _transact(self, endpoint: int, data: bytes | None, within_ns: float) -> str | bytes:
        """Repeat a token until it is answered."""
        end = self.chip.ns + within_ns
        while True:
            answer = self.chip.usb.token(endpoint, data)
            if answer != "nak" or self.chip.ns >= end:
                return answer
            self.chip.run_for(RETRY_NS)

    # The world ----------------------------------------------------------------------------------

    def do_pin(self, pin: int, high: bool) -> bool:
        self.chip.set_pin(pin, high=high)
        return True

    def do_high_share(self, pins: list[int]) -> list[float | None]:
        return [self.chip.high_share(pin) for pin in pins]

    def do_pin_functions(self, pins: list[int]) -> list[int]:
        return [self.chip.function(pin) for pin in pins]

    def do_turn(self, edges: int, period_ns: float, pin_a: int = 2, step: int = 1) -> bool:
        step = step if edges > 0 else -step
        for _ in range(abs(edges)):
            self.chip.turn(step, pin_a)
            self.chip.run_for(period_ns)
        return True

    def do_count_instructions(self) -> bool:
        self.chip.count_instructions()
        return True

    def do_watch_feeding(self) -> bool:
        self.chip.watchdog_least_left_ns = math.inf
        return True

    def do_couple(self, world: World) -> bool:
        self.chip.couple(world)
        return True

    def do_cut_wires(self, pins: list[int]) -> bool:
        for pin in pins:
            self.chip.set_pin(pin, high=True)
        self.chip.cut = set(pins)
        return True

    def do_encoder_counter(self) -> int:
        return self.chip.pio.count

    def do_motor(
        self, zero: int = 2048, sensor_amperes: float | None = None, **changes: float
    ) -> bool:
        self.chip.motor.update(changes)
        self.chip.zero = zero
        self.chip.sensor_amperes = sensor_amperes
        return True

    def do_amperes(self) -> float:
        return self.chip.amperes

    # Flash and memory ---------------------------------------------------------------------------

    def do_cut_flash(self, after_bytes: int) -> bool:
        self.chip.rom.cut_after_bytes = after_bytes
        return True

    def do_erase_time(self, ns: float) -> bool:
        self.chip.rom.erase_ns = ns
        return True

    def do_spoil_flash(self, byte: int) -> bool:
        self.chip.rom.spoilt_byte = byte
        return True

    def do_write_flash(self, address: int, data: str) -> bool:
        content = bytes.fromhex(data)
        self.chip.rom.flash[address : address + len(content)] = content
        return True

    def do_flash(self, address: int, size: int) -> str:
        return self.chip.rom.flash[address : address + size].hex()

    def do_memory(self, address: int, size: int) -> str:
        return bytes(self.chip.core.uc.mem_read(address, size)).hex()

    def do_trace(self, places: list[dict[str, Any]]) -> bool:
        for place in places:
            self.chip.core.trace(**place)
        return True

    def do_passed(self) -> list[Any]:
        passed, self.chip.core.passed = self.chip.core.passed, []
        return passed

    def do_poke(self, address: int, word: int) -> bool:
        self.chip.core.uc.mem_write(address, word.to_bytes(4, "little"))
        return True

    # Ways to go wrong ---------------------------------------------------------------------------

    def do_hang(self, masked: bool = False, inside_us: float | None = None) -> bool:
        self.chip.hang(masked=masked, inside_us=inside_us)
        return True

    def do_stop_ticks(self) -> bool:
        self.chip.stop_ticks()
        return True

    def do_hard_fault(self) -> bool:
        self.chip.hard_fault()
        return True
