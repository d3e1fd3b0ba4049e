"""The motor's true torque, where a current loop makes it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from torsio.calibration.quantity import Array
from torsio.knob import Knob
from torsio.printed.config import BoardConfig

__all__ = ["Drive", "drive_of"]

# How well the time of interrupt and converter is known, by which boards measure earlier.
_LATE_SIGMA_S = 0.35e-6
_NOISE_V = 1e-3  # of the current sensor


@dataclass(frozen=True)
class _Loop:
    """A board's current loop: how often it acts, and whether it is the predictive one."""

    period_s: float
    predicts: bool

    def approach(self, bandwidth_hz: float) -> float:
        """Give how much of a wrong reading it answers, as a share."""
        per_period = bandwidth_hz * self.period_s
        if not self.predicts:
            return -math.expm1(-2.0 * math.pi * min(per_period, 0.1))
        # It believes a third, and takes the answer back a period later: twice the variance.
        return -math.expm1(-2.0 * math.pi * per_period) * math.sqrt(2.0) / 3.0


@dataclass(frozen=True)
class Drive:
    """A motor on a bridge whose current may be read a little late.

    While the bridge drives, the current rises; in the middle of the pulse it is at its mean. A
    later reading is too large, and holds the mean too low by ``rise_a * (1 - |share|)``, whichever
    way the bridge drives. Near no share at all the sensor's noise has it drive now this way, now
    that.

    Attributes
    ----------
    rise_sigma_a
        Standard uncertainty of `rise_a`.
    blur
        Standard deviation of the bridge's share, by noise.
    predicts
        Whether its loop is the predictive one.
    added_kg_m2
        Inertia that is not there: the simple loop stays behind a back EMF that grows.
    rise_a
        Rise of the current from the middle of the pulse until it is read, under the whole supply.
    """

    torque_constant_nm_per_a: float
    resistance_ohm: float
    supply_v: float
    rise_sigma_a: float
    blur: float
    predicts: bool = True
    added_kg_m2: float = 0.0
    rise_a: float = 0.0

    def missing_nm(self, told_nm: Array, speed_rad_s: Array) -> Array:
        """Give the missing part of a torque, with its sign."""
        constant = self.torque_constant_nm_per_a
        voltage_v = self.resistance_ohm / constant * told_nm + constant * speed_rad_s
        share = np.clip(voltage_v / self.supply_v, -1.0, 1.0)
        # Nearly the mean of a sign under noise of a normal distribution.
        way = np.tanh(math.sqrt(2.0 / math.pi) * share / self.blur)
        missing: Array = constant * self.rise_a * way * (1.0 - np.abs(share))
        return missing

    def others(self) -> tuple[Drive, ...]:
        """Give what it may be as well: one that reads a standard uncertainty later."""
        return (replace(self, rise_a=self.rise_sigma_a),)


def drive_of(knob: Knob, board: BoardConfig | None = None) -> Drive | None:
    """Give the drive of a knob; None for one without a current sensor, as an emulated one may be.

    A loop that acts more often than the control does is the predictive one.

    Parameters
    ----------
    board
        Values of its motor; None: as the knob is configured.
    """
    current = knob.motor_current()
    if not current.measured:
        return None
    loop = _Loop(current.period_s, predicts=current.period_s * knob.info.control_rate_hz < 0.9)
    board = board or knob.board_config()
    resistance, inductance = board.motor_resistance_ohm, board.motor_inductance_h
    settled = -math.expm1(-resistance * loop.period_s / inductance)
    v_per_a = loop.approach(board.current_bandwidth_hz) * resistance / settled
    constant = board.motor_torque_constant_nm_per_a
    # The integral of the simple loop grows with the back EMF only while current is missing:
    # resistance / inductance * v_per_a volts a second for each ampere.
    behind_s_per_ohm = 0.0 if loop.predicts else inductance / (resistance * v_per_a)
    return Drive(
        constant,
        resistance,
        board.supply_v,
        board.supply_v / inductance * _LATE_SIGMA_S,
        v_per_a * _NOISE_V / board.current_sense_v_per_a / board.supply_v,
        loop.predicts,
        constant**2 * behind_s_per_ohm,
    )
