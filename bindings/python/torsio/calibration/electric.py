"""The motor's circuit: sensor's zero, winding, torque constant.

The difference of two readings of a knob's `MotorCurrent` tells voltage and charge between them.
With the current ``i`` at both ends and the angle turned,

    voltage time = R charge + L change of i + k angle + drop time

holds exactly for every course of the current. Nothing noisy is differentiated, and the host may
read at any time. ``drop`` has the voltage's sign: brushes, a bridge's dead time, and a current that
is read a little beside the middle of the pulse.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from torsio.calibration.numeric import Solution, linear
from torsio.calibration.quantity import Array, Fit, Quantity, Refusal
from torsio.printed.config import BoardConfig
from torsio.printed.told import MotorCurrent

__all__ = [
    "SUPPLY_CONFIGURED",
    "SUPPLY_METERED",
    "Circuit",
    "Intervals",
    "Motor",
    "check_current",
    "current_zero",
    "intervals",
    "motor",
    "winding",
]

# Effects outside the equation, as a share: a sagging supply, a warm winding, the moment of the
# voltage, an angle that is a tick old. Found on the emulated knobs 200 to 259.
_LEFT_OUT = {
    "motor_resistance_ohm": 5.3e-3,
    "motor_inductance_h": 9e-3,
    "motor_torque_constant_nm_per_a": 8e-4,
}
# Supply, sensor and winding may each be a tenth off, evenly: the standard deviation of one.
_TENTH = 0.1 / math.sqrt(3.0)
SUPPLY_CONFIGURED, SUPPLY_METERED = 0.95 * 0.1 / 1.96, 1e-2
"""How uncertain the supply is, as a share: as it is configured, as a meter says it.

Of what is even within a tenth 95 % lie within 0.95 of the tenth."""

# Range of the boards' converter. A sensor's zero keeps this distance from both ends.
_CONVERTER_V, _END_V = 3.3, 0.1
# A gain beyond all of them together is a fault.
_LEAST_GAIN, _MOST_GAIN = 0.6, 1.6


def current_zero(current_a: Array, *, step_a: float, v_per_a: float) -> tuple[Quantity, Quantity]:
    """Estimate the sensor's zero and its noise while the power is off.

    Parameters
    ----------
    current_a
        Shape (n,), from the bottom of the converter's range.
    step_a
        Step of the converter, which rounds down: by half a step in the mean.
    v_per_a
        Gain of the sensor.

    Raises
    ------
    Refusal
        "dead_sensor", "saturated_sensor": the very same number all the time, at an end of the
        converter's range.
    """
    mean_a, noise_a = float(np.mean(current_a)), float(np.std(current_a, ddof=1))
    zero_v = v_per_a * (mean_a + 0.5 * step_a)
    dead = zero_v < _END_V
    saturated = zero_v > _CONVERTER_V - _END_V
    if float(np.ptp(current_a)) < 0.5 * step_a and (dead or saturated):
        raise Refusal(
            "current sensor", "dead_sensor" if dead else "saturated_sensor", "the current sensor "
            f"says {zero_v:.2f} V all the time: "
            + ("it has no supply, or its wire is not at current_sense_pin" if dead else
               "it is at the end of its range, or no sensor is at current_sense_pin"),
            zero_v=zero_v,
        )  # fmt: skip
    count = len(current_a)
    noise = math.sqrt(max(noise_a**2 - step_a**2 / 12.0, 0.0))
    # Noise tells where between two steps the zero is; with less, the mean clings to one of them.
    within_step_a = 0.0 if noise > 0.5 * step_a else step_a / 12**0.5
    return (
        Quantity(
            "current_zero_v", zero_v, v_per_a * math.hypot(noise_a / count**0.5, within_step_a),
            "of the current sensor, with no current",
        ),
        Quantity(
            "current_noise_a", noise,
            math.hypot(noise_a / (2.0 * count) ** 0.5, 0.03 * step_a),
            "standard deviation of a measurement",
        ),
    )  # fmt: skip


def _way(share: Array) -> Array:
    """Sign of a bridge's share, less while it drives more."""
    return np.asarray(np.sign(share) * (1.0 - np.abs(share)))


@dataclass(frozen=True)
class Intervals:
    """The intervals between readings, each of shape (n,).

    Attributes
    ----------
    duration_s, voltage_v_s, charge_c, change_a, angle_rad
        For each interval; the voltage as the configured supply makes it, the charge and the change
        of the current as the sensor says it.
    share
        Mean of the bridge's.
    change_late
        Change of the bridge's way between the readings at both ends. Late readings are too large
        by this.
    """

    duration_s: Array
    voltage_v_s: Array
    charge_c: Array
    change_a: Array
    angle_rad: Array
    share: Array
    change_late: Array

    def drop_s(self, settle_s: float) -> Array:
        """Give the time that the drop counts, with its sign, for a winding that settles so."""
        return self.duration_s * _way(self.share) + settle_s * self.change_late

    def chosen(self, these: npt.NDArray[np.bool_]) -> Intervals:
        """Give some of them."""
        return Intervals(*(getattr(self, of.name)[these] for of in fields(self)))

    @staticmethod
    def together(parts: Sequence[Intervals]) -> Intervals:
        """Give the intervals of all parts."""
        names = [of.name for of in fields(Intervals)]
        return Intervals(
            *(np.concatenate([getattr(part, name) for part in parts]) for name in names)
        )


def intervals(readings: Sequence[MotorCurrent], supply_v: float) -> Intervals:
    """Give the differences between each reading and the next, with no two of the same period."""
    some = [readings[0]]
    some += [b for a, b in itertools.pairwise(readings) if b.periods != a.periods]
    first = some[0]
    period_s, late = first.period_s, first.delay_s / first.period_s
    number = np.diff([of.periods for of in some]).astype(np.float64)
    # Between two measurements the older answers act; the last one for a part of the time.
    acted = np.diff([of.share_sum - of.share - late * of.share_before for of in some])
    change_a = np.diff([of.current_a for of in some])
    sum_a = np.diff([of.current_sum_a for of in some])
    sum_a = sum_a - first.zero_a * number - 0.5 * change_a
    return Intervals(
        number * period_s,
        supply_v * period_s * acted,
        period_s * sum_a,
        change_a,
        np.diff([of.angle_rad for of in some]),
        acted / number,
        np.diff(_way(np.array([of.share_before for of in some]))),
    )


def check_current(over: Intervals, believed_ohm: float, *, step: str) -> None:
    """Look whether the current is one that the voltage can have made.

    Raises
    ------
    Refusal
        "no_current", "reversed_sensor".
    """
    seconds = float(np.sum(over.duration_s))
    pushed_v = float(np.sum(np.sign(over.share) * over.voltage_v_s)) / seconds
    flowed_a = float(np.sum(np.sign(over.share) * over.charge_c)) / seconds
    if abs(flowed_a) * believed_ohm < 0.1 * pushed_v:
        raise Refusal(
            step, "no_current", f"{pushed_v:.2g} V drive {1e3 * abs(flowed_a):.0f} mA only: "
            "the motor or its current sensor is not connected, or it has no supply",
            current_a=flowed_a,
        )  # fmt: skip
    if flowed_a < 0.0:
        raise Refusal(
            step, "reversed_sensor", "the current sensor counts down where the voltage drives "
            "up: swap its two wires", current_a=flowed_a,
        )  # fmt: skip


def _columns(of: Intervals, settle_s: float) -> Array:
    return np.column_stack([of.charge_c, of.change_a, of.drop_s(settle_s), of.angle_rad])


def _fit(of: Intervals, settle_s: float, constant_nm_per_a: float | None = None) -> Solution:
    """Fit R, L, drop and, unless it is given, k; the time constant by which the drop counts too."""
    for _ in range(3):
        columns = _columns(of, settle_s)
        if constant_nm_per_a is None:
            fit = linear(columns, of.voltage_v_s, lags=2)
        else:
            fit = linear(columns[:, :3], of.voltage_v_s - constant_nm_per_a * of.angle_rad, lags=2)
        if fit.value[0] <= 0.0 or fit.value[1] <= 0.0:
            break
        settle_s = float(fit.value[1] / fit.value[0])
    return fit


def _quantity(name: str, value: float, sigma: float, meaning: str) -> Quantity:
    return Quantity(name, value, math.hypot(sigma, _LEFT_OUT[name] * value), meaning)


def winding(
    held: Intervals, *, believed_ohm: float, believed_h: float, constant_nm_per_a: float
) -> Solution:
    """Estimate resistance in ohm, inductance in H and drop in V while the knob is held.

    Parameters
    ----------
    constant_nm_per_a
        Torque constant of the motor, for the little that it turns.

    Raises
    ------
    Refusal
        "no_current", "reversed_sensor", "winding_values".
    """
    check_current(held, believed_ohm, step="winding")
    fit = _fit(held, believed_h / believed_ohm, constant_nm_per_a)
    gain = believed_ohm / float(fit.value[0])
    if not _LEAST_GAIN < gain < _MOST_GAIN or fit.value[1] <= 0.0:
        raise Refusal(
            "winding", "winding_values", f"the winding seems to have {fit.value[0]:.2f} ohm and "
            f"{1e3 * fit.value[1]:.2f} mH, but motor_resistance_ohm is {believed_ohm:.2f}: correct "
            "it, supply_v or current_sense_v_per_a, or look at the motor's wires",
            gain=gain,
        )  # fmt: skip
    return fit


@dataclass(frozen=True)
class Motor:
    """The motor's circuit, as its board sees it.

    That is with the `supply_v` of its configuration, and through its current sensor.

    Attributes
    ----------
    constant
        Uncertain by what the supply is, too.
    constant_sigma
        The same without that, as a share: how well this constant gives the torques.
    gain
        Gain of the sensor over its right gain, if supply and resistance are what the configuration
        says: the three cannot be told apart.
    """

    resistance: Quantity
    inductance: Quantity
    constant: Quantity
    constant_sigma: float
    gain: Quantity
    fits: tuple[Fit, ...]


@dataclass(frozen=True)
class Circuit:
    """The motor's circuit as found.

    Attributes
    ----------
    board
        The configuration that is proposed.
    torque_scale
        The motor's torque over the torque that the board believes.
    torque_share
        How uncertain every torque is, as a share of it, in the measure of the proposed torque
        constant.
    """

    quantities: tuple[Quantity, ...]
    motor: Motor
    board: BoardConfig
    torque_scale: float
    torque_share: float

    def sigmas(self) -> dict[str, int]:
        """Give what the device keeps of the uncertainties: thousandths, rounded up."""
        found = self.motor
        return {
            f"sigma_{name}_permille": min(math.ceil(1e3 * of.standard_uncertainty / of.value), 255)
            for name, of in (
                ("motor_resistance", found.resistance),
                ("motor_inductance", found.inductance),
                ("motor_torque_constant", found.constant),
            )
        }


def motor(
    held: Intervals,
    turned: Intervals,
    *,
    believed_ohm: float,
    believed_h: float,
    supply_sigma: float,
) -> Motor:
    """Estimate all from intervals in which the knob was held, and such in which it turned.

    Parameters
    ----------
    supply_sigma
        Uncertainty of the supply that made the voltages, as a share.

    Raises
    ------
    Refusal
        "one_way", "reversed_emf".
    """
    speed = turned.angle_rad / turned.duration_s
    if np.min(speed) > 0.0 or np.max(speed) < 0.0:
        raise Refusal(
            "torque constant",
            "one_way",
            "the knob turned one way only: it is held, or the encoder failed",
        )
    both = Intervals.together([held, turned])
    fit = _fit(both, believed_h / believed_ohm)
    ohm, henry, drop_v, constant = (float(value) for value in fit.value)
    if constant <= 0.0:
        raise Refusal(
            "torque constant", "reversed_emf", "the motor's own voltage has the wrong sign for "
            "its speed: motor and encoder disagree; change motor_reversed or encoder_reversed",
            constant_nm_per_a=constant,
        )  # fmt: skip
    gain = believed_ohm / ohm
    settle_s = henry / ohm
    other_v_s = _columns(turned, settle_s)[:, :3] @ fit.value[:3]
    emf_v = (turned.voltage_v_s - other_v_s) / turned.duration_s
    held_v = held.voltage_v_s / held.duration_s
    told_v = _columns(held, settle_s) @ fit.value / held.duration_s
    seen = _quantity(
        "motor_torque_constant_nm_per_a", constant, fit.sigma(3),
        "from the back EMF, as true as supply_v",
    )  # fmt: skip
    sigma = math.hypot(seen.standard_uncertainty, supply_sigma * constant)
    return Motor(
        _quantity("motor_resistance_ohm", ohm, fit.sigma(0), "of the winding, seen by its board"),
        _quantity("motor_inductance_h", henry, fit.sigma(1), "of the winding, seen by its board"),
        replace(seen, standard_uncertainty=sigma),
        seen.standard_uncertainty / constant,
        Quantity(
            "current_gain", gain, math.hypot(_TENTH, supply_sigma),
            "of the current sensor over the configured one; a guess: docs/reference/calibration.md",
        ),
        (
            Fit(
                f"Knob held: {ohm:.3g} ohm, {1e3 * henry:.3g} mH, {1e3 * drop_v:.0f} mV",
                "current, A", "voltage, V", held.charge_c / held.duration_s, held_v, told_v,
            ),
            Fit(
                "Turns: torque constant", "speed, rad/s", "back EMF, V",
                speed, emf_v, constant * speed,
            ),
        ),
    )  # fmt: skip
