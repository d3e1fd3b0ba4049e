"""How to make an emulated knob, and what happens to it."""

# Printed from the field lists in firmware/protocol/definition/
# and emulator/definition/ by `./dev generate`;
# change those instead.

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Literal

from torsio.common import checks
from torsio.printed.config import (
    ActuatorConfig,
    BoardConfig,
    ControlConfig,
    GameConfig,
    ShaftConfig,
)
from torsio.printed.hands import Hand, NoHand
from torsio.printed.plant import PlantParams

__all__ = [
    "EMULATED_SERIAL",
    "DeviceInput",
    "EmulatorOptions",
    "LinkFaults",
]

EMULATED_SERIAL = "EMULATED"
"""Serial number of an emulated or virtual knob that is told no other."""


@dataclass(frozen=True, repr=False)
class EmulatorOptions(checks.ByName):
    """Options of an emulated knob: parts, hand and records.

    Attributes
    ----------
    seed
        Of everything random: encoder noise, damaged reports.
    control_rate_hz
        Ticks in a second; 1000 to 2e4.
    plant
        Its parts.
    hand
        The hand on it.
    serial
        At most 16 ASCII characters; empty: derived from the device's name.
    actuator
        Configuration at power-up; it replaces the stored one and the defaults.
    control
        The same.
    board
        The same; a plant with electrics has use for it.
    game
        The same.
    shaft
        The same.
    paced
        True: real time, as with hardware; False: virtual time, which passes only inside calls that
        wait, as fast as the computer can. The same calls with the same seed give the same bytes.
    log_truth
        Record what no sensor sees, once a tick.
    log_inputs
        Record what enters the device, from power-up on, so that it can run again.
    """

    _: KW_ONLY
    seed: int = 0
    control_rate_hz: float = 1000.0
    plant: PlantParams = PlantParams()
    hand: Hand = NoHand()
    serial: str = ""
    actuator: ActuatorConfig | None = None
    control: ControlConfig | None = None
    board: BoardConfig | None = None
    game: GameConfig | None = None
    shaft: ShaftConfig | None = None
    paced: bool = False
    log_truth: bool = False
    log_inputs: bool = False

    def __post_init__(self) -> None:
        """Ask for the right kinds, and keep sequences so that they compare by value."""
        checks.whole("seed", self.seed, 0, 18446744073709551615)
        checks.number("control_rate_hz", self.control_rate_hz)
        checks.kind("plant", self.plant, PlantParams, "a torsio.PlantParams")
        checks.kind("hand", self.hand, Hand, "a torsio.Hand")
        checks.text("serial", self.serial)
        if self.actuator is not None:
            checks.kind("actuator", self.actuator, ActuatorConfig, "ActuatorConfig or None")
        if self.control is not None:
            checks.kind("control", self.control, ControlConfig, "ControlConfig or None")
        if self.board is not None:
            checks.kind("board", self.board, BoardConfig, "BoardConfig or None")
        if self.game is not None:
            checks.kind("game", self.game, GameConfig, "GameConfig or None")
        if self.shaft is not None:
            checks.kind("shaft", self.shaft, ShaftConfig, "ShaftConfig or None")
        checks.flag("paced", self.paced)
        checks.flag("log_truth", self.log_truth)
        checks.flag("log_inputs", self.log_inputs)


@dataclass(frozen=True, repr=False)
class LinkFaults(checks.ByName):
    """Damage to reports on the cable of an emulated knob, as probabilities for each report.

    Attributes
    ----------
    drop_output
        Host to device; 0 to 1.
    corrupt_output
        A bit of it is another; 0 to 1.
    drop_input
        Device to host; 0 to 1.
    corrupt_input
        A bit of it is another; 0 to 1.
    """

    _: KW_ONLY
    drop_output: float = 0.0
    corrupt_output: float = 0.0
    drop_input: float = 0.0
    corrupt_input: float = 0.0


@dataclass(frozen=True)
class DeviceInput:
    """Something that entered an emulated device, so that it can run again.

    Attributes
    ----------
    tick
        Control ticks that had run before it, since the first power-up.
    kind
        Its kind.
    bytes
        Its content: a report, or as its kind has it; of counts one control tick for each, in 32
        bits, little endian.
    """

    tick: int
    kind: Literal[
        "stored",
        "power",
        "connected",
        "output",
        "feature",
        "game_output",
        "game_feature",
        "buttons",
        "emergency_stop",
        "actuator_fault",
        "power_faults",
        "missed_ticks",
        "power_cut",
        "counts",
        "index",
    ]
    bytes: bytes
