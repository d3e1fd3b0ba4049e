"""The emulated device and its parts, each on its own, for study.

`torsio.open("emulated")` puts them together; here are the plant, the encoder, and the whole device
at the level of report bytes.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from torsio import _torsio
from torsio._torsio.emulator import EmulatedDevice, Encoder, ReplayedDevice
from torsio.common import checks
from torsio.printed.hands import Hand
from torsio.printed.plant import ElectricsState, PlantParams
from torsio.telemetry import PLANT_DTYPE, Record

__all__ = ["PLANT_DTYPE", "Circuit", "EmulatedDevice", "Encoder", "Plant", "ReplayedDevice"]

_LONGEST_NS = 2**62


class Plant(_torsio.emulator.Plant):
    """Motor, knob, shaft spring, brake and hand under a virtual clock.

    Parameters
    ----------
    step_ns
        Sets the cost of the exact steps, not their accuracy; best the control period.
    stepper
        A capsule of another extension module that steps the plant in place of the exact method;
        the package torsio-studies has some to compare with.

    Raises
    ------
    TypeError, ValueError
        If an argument is of the wrong kind or out of its range; the message names it.
    """

    def __init__(
        self,
        params: PlantParams | None = None,
        hand: Hand | None = None,
        *,
        step_ns: int = 1_000_000,
        stepper: object | None = None,
    ) -> None:
        """Put it at rest at angle 0."""
        if params is not None:
            checks.kind("params", params, PlantParams, "PlantParams")
        step_ns = checks.whole("step_ns", step_ns, 1, _LONGEST_NS)
        super().__init__(params, hand, step_ns=step_ns, stepper=stepper)

    def set_command(self, *, motor_command_nm: float = 0.0, brake_command_nm: float = 0.0) -> None:
        """Set the commands that are held from now on."""
        super().set_command(
            motor_command_nm=checks.finite("motor_command_nm", motor_command_nm),
            brake_command_nm=checks.finite("brake_command_nm", brake_command_nm),
        )

    def advance(self, duration_ns: int) -> None:
        """Let time pass."""
        super().advance(checks.whole("duration_ns", duration_ns, 0, _LONGEST_NS))

    def record(
        self,
        motor_command_nm: npt.ArrayLike,
        brake_command_nm: npt.ArrayLike,
        *,
        period_ns: int = 1_000_000,
    ) -> Record:
        """Hold each pair of commands for a period; PLANT_DTYPE rows at the periods' begins."""
        period_ns = checks.whole("period_ns", period_ns, 1, _LONGEST_NS)
        return super().record(motor_command_nm, brake_command_nm, period_ns=period_ns)

    def record_bridges(
        self,
        motor_share: npt.ArrayLike,
        brake_share: npt.ArrayLike,
        enabled: npt.ArrayLike,
        *,
        period_ns: int = 25_000,
    ) -> tuple[Record, npt.NDArray[np.float64]]:
        """As record, of a plant with electrics, from a supply at rest.

        The bridges give their windings these shares of the supply's voltage, -1 to 1, for a period
        each while they are enabled.

        Returns
        -------
        tuple
            PLANT_DTYPE rows at the periods' begins, and the supply's voltage there, shape (n,).
        """
        period_ns = checks.whole("period_ns", period_ns, 1, _LONGEST_NS)
        return super().record_bridges(motor_share, brake_share, enabled, period_ns=period_ns)

    def drive(
        self,
        motor_command_nm: npt.ArrayLike,
        brake_command_nm: npt.ArrayLike,
        *,
        period_ns: int = 1_000_000,
    ) -> npt.NDArray[np.float64]:
        """As record, for timing: angles of knob and brake at the periods' ends, shape (n, 2)."""
        period_ns = checks.whole("period_ns", period_ns, 1, _LONGEST_NS)
        return super().drive(motor_command_nm, brake_command_nm, period_ns=period_ns)


class Circuit(_torsio.emulator.Circuit):
    """Windings, bridges and supply of a plant, for a board that is not the emulated device's.

    The plant then moves by this alone: not by its own ``set_command`` and ``advance``.

    Parameters
    ----------
    plant
        Needs electrics.

    Raises
    ------
    ValueError
        If an argument is out of its range.
    """

    def advance(
        self,
        duration_ns: int,
        *,
        motor_share: float = 0.0,
        brake_share: float = 0.0,
        enabled: bool = False,
    ) -> None:
        """Let time pass for circuit and plant while the bridges do this.

        Parameters
        ----------
        duration_ns
            A PWM period; it must be short beside the time constants of winding and supply.
        motor_share, brake_share
            Shares of the supply's voltage on winding and coil, -1 to 1.
        enabled
            False: both currents run back into the supply until there is none.
        """
        super().advance(
            checks.whole("duration_ns", duration_ns, 1, _LONGEST_NS),
            motor_share=checks.number("motor_share", motor_share, -1.0, 1.0),
            brake_share=checks.number("brake_share", brake_share, -1.0, 1.0),
            enabled=enabled,
        )

    @property
    def electrics(self) -> ElectricsState:
        """True values that no sensor sees, now."""
        return ElectricsState(**super().state)

    def set_supply(self, supply_v: float) -> None:
        """Change the supply's voltage without load, >= 0; its capacitor follows."""
        super().set_supply(checks.number("supply_v", supply_v, 0.0, 1e15))
