"""The emulated knob: how to make one, and the world round it."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Literal

from torsio import _torsio, checks
from torsio.config import ActuatorConfig, BoardConfig, ControlConfig, GameConfig, ShaftConfig
from torsio.game_port import GamePort
from torsio.hands import Hand
from torsio.plant import ElectricsState, PlantParams
from torsio.telemetry import Record

__all__ = ["DeviceInput", "Emulator", "EmulatorOptions"]


@dataclass(frozen=True)
class DeviceInput:
    """Something that entered an emulated device.

    Attributes
    ----------
    tick
        Control ticks that had run before it, since the first power-up.
    kind
        "output", "feature": a report; "counts": of the encoder, one control tick for each, as
        32-bit numbers, little endian; and what else of its world a device notices.
    bytes
        What it was.
    """

    tick: int
    kind: str
    bytes: bytes


@dataclass(frozen=True)
class EmulatorOptions:
    """What an emulated knob is like, for `torsio.open`.

    Attributes
    ----------
    seed
        Of everything random: encoder noise, damaged reports. 0 to 2**64 - 1.
    control_rate_hz
        1,000 to 20,000.
    plant, hand
        The simulated actuator, and who holds it; None is the reference actuator, and nobody.
    serial
        At most 16 ASCII characters; empty: derived from the device's name.
    actuator, control, board, game, shaft
        Configuration at power-up, in place of what the device has stored, or of its defaults.
    paced
        False: time is virtual and passes only inside calls that wait, as fast as it can be
        computed; the same calls with the same seed give the same bytes. True: the wall clock's.
    log_truth
        Record what no sensor sees, for `Emulator.truth`.
    log_inputs
        Record what enters the device, for `Emulator.inputs`.

    Raises
    ------
    TypeError, InvalidArgument
        Names the field. Ranges are checked by `torsio.open`, but for the seed's.
    """

    _: KW_ONLY
    seed: int = 0
    control_rate_hz: float = 1000.0
    plant: PlantParams | None = None
    hand: Hand | None = None
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
        """Look at the kind of every value, here where it was written."""
        checks.whole("seed", self.seed, 0, 2**64 - 1)
        checks.number("control_rate_hz", self.control_rate_hz)
        checks.text("serial", self.serial)
        checks.flag("paced", self.paced)
        checks.flag("log_truth", self.log_truth)
        checks.flag("log_inputs", self.log_inputs)
        for name, wanted in (
            ("plant", PlantParams),
            ("hand", Hand),
            ("actuator", ActuatorConfig),
            ("control", ControlConfig),
            ("board", BoardConfig),
            ("game", GameConfig),
            ("shaft", ShaftConfig),
        ):
            value = getattr(self, name)
            checks.kind(name, value, (wanted, type(None)), f"a torsio.{wanted.__name__} or None")


class Emulator:
    """The world round an emulated knob: who holds it, what really happens, what goes wrong."""

    def __init__(self, knob: _torsio.Knob) -> None:
        self._knob = knob

    def set_hand(self, hand: Hand) -> None:
        """Give the knob into another hand at the next control tick, time 0 of its profiles."""
        self._knob.set_hand(hand)

    @property
    def time_s(self) -> float:
        """Device time."""
        return self._knob.emulator_time_s()

    def advance(self, duration_s: float) -> None:
        """Let time pass, like `Knob.sleep`."""
        self._knob.advance(checks.number("duration_s", duration_s))

    def truth(self) -> Record:
        """Take what no sensor sees, one row a control tick since the last call.

        Returns
        -------
        Record
            Of `torsio.telemetry.TRUTH_DTYPE`.

        Raises
        ------
        Error
            Unless opened with ``EmulatorOptions(log_truth=True)``.
        """
        return self._knob.truth()

    def inputs(self) -> list[DeviceInput]:
        """Take what has entered the device since power-up or the last call, in order.

        `torsio.emulator.ReplayedDevice` runs it again; a recording keeps it.

        Raises
        ------
        Error
            Unless opened with ``EmulatorOptions(log_inputs=True)``.
        """
        return [DeviceInput(*row) for row in self._knob.inputs()]

    @property
    def electrics(self) -> ElectricsState:
        """What no sensor sees of the electrics, now.

        Raises
        ------
        Error
            Unless the plant has electrics.
        """
        return ElectricsState(**self._knob.electrics())

    @property
    def game(self) -> GamePort:
        """The game interface, as a game's driver sees it."""
        return GamePort(self._knob)

    def unplug(self) -> None:
        """Pull the plug. As with hardware the knob must be opened again."""
        self._knob.unplug()

    def set_emergency_stop(self, *, pressed: bool) -> None:
        """Press or release the emergency stop."""
        self._knob.set_emergency_stop(checks.flag("pressed", pressed))

    def set_actuator_fault(self, *, present: bool) -> None:
        """Make the power stage report an error, or stop doing so."""
        self._knob.set_actuator_fault(checks.flag("present", present))

    def set_current_sensor(self, state: Literal["works", "dead", "stuck", "saturated"]) -> None:
        """Have the current sensor show something else from now on.

        Raises
        ------
        Error
            Unless the plant has electrics.
        """
        self._knob.set_current_sensor(checks.text("state", state))

    def set_supply(self, supply_v: float) -> None:
        """Have the supply give so many volts from now on, 0 to 1,000.

        Raises
        ------
        Error
            Unless the plant has electrics.
        """
        self._knob.set_supply(checks.number("supply_v", supply_v))

    def freeze_encoder(self, *, frozen: bool) -> None:
        """Let the encoder's counter stand still."""
        self._knob.freeze_encoder(checks.flag("frozen", frozen))

    def jump_encoder(self, counts: int) -> None:
        """Make the encoder's counter wrong from now on."""
        self._knob.jump_encoder(checks.whole("counts", counts, -(2**31), 2**31 - 1))

    def skip_ticks(self, count: int) -> None:
        """Let the control loop come that many ticks late."""
        self._knob.skip_ticks(checks.whole("count", count, 0, 2**32 - 1))

    def set_link_faults(
        self,
        *,
        drop_output: float = 0.0,
        corrupt_output: float = 0.0,
        drop_input: float = 0.0,
        corrupt_input: float = 0.0,
    ) -> None:
        """Damage reports on the way, each with a probability. Output is from host to device."""
        self._knob.set_link_faults(
            drop_output=checks.number("drop_output", drop_output),
            corrupt_output=checks.number("corrupt_output", corrupt_output),
            drop_input=checks.number("drop_input", drop_input),
            corrupt_input=checks.number("corrupt_input", corrupt_input),
        )

    def cut_power_in_next_save(self, after_bytes: int) -> None:
        """Make the device vanish in the middle of its next save."""
        self._knob.cut_power_in_next_save(checks.whole("after_bytes", after_bytes, 0, 2**32 - 1))
