"""A rehearsal's bench round a board's released firmware in its emulated chip."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import torsio
from tests.board import pico
from tests.board.live import BinaryTransport
from tests.board.pico import EmulatedPico, enumerated
from tests.board.rp2350 import bench as rp2350
from tests.board.rp2350.chip import PWM
from tests.board.rp2350.rom import HZ
from tests.board.world import World
from torsio.printed.plant import ElectricsState, PlantParams
from torsio_hardware.faults import Fault
from torsio_hardware.first_power import Bench
from torsio_hardware.knob import Knob

_BOTH_WAYS = 2  # a bit of a PWM unit: it counts up and down
_CONVERTER = {"dead": -100.0, "stuck": 0.0, "saturated": 100.0}  # amperes that it shows


class ChipWorld(World):
    """A world round a board in its emulated chip, with a maker's actions and mistakes."""

    def __init__(self, board: EmulatedPico, knob: Knob, fault: Fault, plant: PlantParams) -> None:
        super().__init__(plant)
        self._board, self._pins = board, knob.pins
        # The sensor sits between bridge and motor: it sees the current as the bridge does.
        self._motor_sign = -1 if self._electrics.motor_reversed else 1
        self._encoder_sign = -1 if fault.reversed_encoder else 1
        self._frozen = False
        # The emulated RP2040 keeps its registers in a process of its own.
        self.scope = self._scope if isinstance(board.bench, rp2350.Bench) else None

    def pass_period(
        self, motor_share: float, brake_share: float, enabled: bool
    ) -> tuple[float, list[float]]:
        sign = self._motor_sign
        amperes, edges = super().pass_period(sign * motor_share, brake_share, enabled)
        return sign * amperes, [] if self._frozen else [self._encoder_sign * at for at in edges]

    @property
    def electrics(self) -> ElectricsState:
        """True electric values, now."""
        return ElectricsState(**self.circuit.state)

    def _scope(self) -> tuple[float, float, float]:
        """Look at the motor's inputs: kHz, and the share of the time that each is high."""
        assert isinstance(self._board.bench, rp2350.Bench)
        first = self._pins["motor_pin"]
        begin = 0x14 * (first // 2 % 8)
        unit = {at: self._board.bench.chip.registers[PWM][begin + at] for at in (0x00, 0x10)}
        cycles = (unit[0x10] + 1) * (2 if unit[0x00] & _BOTH_WAYS else 1)
        return HZ / cycles / 1e3, *self._board.do("high_share", pins=[first, first + 1])

    def set_hand(self, hand: torsio.Hand) -> None:
        # Its times are the world's; a rehearsal's times begin now.
        if isinstance(hand, torsio.PrescribedMotion):
            given: Any = hand.angle_rad
            path = [(self.time_s + time, angle) for time, angle in given]
            hand = torsio.PrescribedMotion(angle_rad=path)
        super().set_hand(hand)

    def set_emergency_stop(self, *, pressed: bool) -> None:
        self._board.do("pin", pin=self._pins["emergency_stop_pin"], high=pressed)

    def set_actuator_fault(self, *, present: bool) -> None:
        self._board.do("pin", pin=self._pins["driver_fault_pin"], high=not present)

    def freeze_encoder(self, *, frozen: bool) -> None:
        self._frozen = frozen

    def set_link_faults(self, faults: torsio.LinkFaults) -> None:
        """Change nothing: while time passes in `advance`, no host speaks anyway."""

    def advance(self, duration_s: float) -> None:
        self._board.run(1e3 * duration_s)

    def set_current_sensor(self, state: str) -> None:
        self._board.do("motor", sensor_amperes=_CONVERTER[state])


@contextmanager
def binary(knob: Knob, fault: Fault, seed: int | None = None) -> Iterator[Bench]:
    """Give the file that a maker copies to the board, configured, saved, and started anew."""
    pico.choose(knob.board)
    plant = fault.change(knob.plant(seed))
    with enumerated() as board:
        with torsio.open(BinaryTransport(board)) as device:
            for config in knob.configs().values():
                device.configure(config)
            device.save()
        board.power_cycle()
        # What is wrong is so before the board starts: it learns its sensor's zero at once.
        world = ChipWorld(board, knob, fault, plant)
        assert plant.electrics is not None
        board.do("motor", supply=plant.electrics.supply_v)
        fault.happen(world)
        board.enumerate()
        board.couple(world.pass_period)
        with torsio.open(BinaryTransport(board)) as device:
            yield Bench(knob, device, world, fault, plant)
