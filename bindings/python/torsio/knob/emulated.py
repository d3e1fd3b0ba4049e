"""The world round an emulated knob."""

from __future__ import annotations

from typing import Literal

from torsio import _torsio
from torsio.common import checks
from torsio.knob.game_port import GamePort
from torsio.printed.emulator_options import DeviceInput, LinkFaults
from torsio.printed.hands import Hand
from torsio.printed.plant import ElectricsState
from torsio.telemetry import Record

__all__ = ["Emulator"]


class Emulator:
    """The world round an emulated knob: its hand, its true state, its faults."""

    def __init__(self, knob: _torsio.Knob) -> None:
        if not hasattr(knob, "set_hand"):
            raise TypeError("an open emulated knob has its Emulator as knob.emulator")
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
            Rows of `torsio.telemetry.TRUTH_DTYPE`.

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
        return [DeviceInput(**told) for told in self._knob.inputs()]

    @property
    def electrics(self) -> ElectricsState:
        """True electric values, now.

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

    def unplug(self, *, after_s: float = 0.0) -> None:
        """Pull the plug, at once or when so much of the knob's time has passed.

        To the millisecond. As with hardware the knob must be opened again.
        """
        self._knob.unplug(checks.number("after_s", after_s))

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

    def set_link_faults(self, faults: LinkFaults) -> None:
        """Damage reports on the way from now on."""
        checks.kind("faults", faults, LinkFaults, "a torsio.LinkFaults")
        self._knob.set_link_faults(faults)

    def cut_power_in_next_save(self, after_bytes: int) -> None:
        """Make the device vanish in the middle of its next save."""
        self._knob.cut_power_in_next_save(checks.whole("after_bytes", after_bytes, 0, 2**32 - 1))
