"""Electrical steps: the current sensor's zero, the winding, the torque constant.

They need a device that reports the motor's current and voltage; `calibrate` plays them once it
does.
"""

from __future__ import annotations

import math

import numpy as np

from torsio.calibration.numeric import gauss_newton, linear
from torsio.calibration.quantity import Array, Quantity, Refusal

__all__ = ["current_zero", "torque_constant", "winding"]


def current_zero(current_a: Array) -> tuple[Quantity, Quantity]:
    """Estimate the sensor's zero and its noise while the power is off (step 0).

    Raises
    ------
    Refusal
        "dead_sensor": it says the very same number all the time, or one at the end of its range.
    """
    noise = float(np.std(current_a, ddof=1))
    if noise == 0.0:
        raise Refusal(
            "current sensor", "dead_sensor", "the current sensor says the very same number all "
            "the time: "
            "it has no supply, or its wire is not at current_sense_pin",
        )  # fmt: skip
    count = len(current_a)
    return (
        Quantity(
            "current_zero_a", float(np.mean(current_a)), noise / count**0.5, "with no current"
        ),
        Quantity("current_noise_a", noise, noise / (2.0 * count) ** 0.5, "standard deviation"),
    )


def winding(
    time_s: Array, voltage_v: Array, current_a: Array, *, believed_ohm: float
) -> tuple[Quantity, Quantity, Quantity]:
    """Estimate resistance, inductance and the sensor's gain from steps of voltage (step 1).

    The knob is held, so that nothing turns: ``voltage = R current + L current'``. The
    current that this gives is fitted to the measured one, so that nothing noisy is differentiated.

    Parameters
    ----------
    time_s, voltage_v, current_a
        Shape (n,), evenly in time; a voltage holds until the next sample; the current without its
        zero, as the sensor says it.
    believed_ohm
        Of the winding: what the resistance and the sensor's gain can be told apart by.

    Returns
    -------
    resistance, inductance, gain
        As seen through the sensor; the gain is that of the sensor over the one it should have.

    Raises
    ------
    Refusal
        "no_current", "reversed_sensor", "gain".
    """
    if np.ptp(current_a) < 0.1 * np.ptp(voltage_v) / believed_ohm:
        raise Refusal(
            "winding", "no_current", f"{np.ptp(voltage_v):.1f} V drive {np.ptp(current_a):.2f} "
            "A only: the motor "
            "or its sensor is not connected",
        )  # fmt: skip
    if float(np.sum((voltage_v - np.mean(voltage_v)) * current_a)) < 0.0:
        raise Refusal(
            "winding", "reversed_sensor", "the current sensor counts down where the voltage "
            "drives up: "
            "turn it round, or current_sense_v_per_a",
        )  # fmt: skip
    step = float(time_s[1] - time_s[0])

    def model(value: Array) -> Array:
        ohm, henry, offset_v, first_a = (float(number) for number in value)
        decay = math.exp(-step * ohm / henry)
        current, result = first_a, []
        for volt in (voltage_v + offset_v).tolist():
            result.append(current)
            current = volt / ohm + (current - volt / ohm) * decay
        return np.array(result)

    begin = np.array([believed_ohm, 10.0 * step * believed_ohm, 0.0, float(current_a[0])])
    scale = np.array([1e-4 * begin[0], 1e-3 * begin[1], 1e-3, 1e-3])
    fit = gauss_newton(model, current_a, begin, scale=scale, steps=30)
    resistance, inductance = float(fit.value[0]), float(fit.value[1])
    gain = believed_ohm / resistance
    if not 0.5 < gain < 2.0:
        raise Refusal(
            "winding", "gain", f"the winding seems to have {resistance:.2f} ohm, and "
            "motor_resistance_ohm is "
            f"{believed_ohm:.2f}: one of it, supply_v and current_sense_v_per_a is wrong",
        )  # fmt: skip
    relative = fit.sigma(0) / resistance
    return (
        Quantity("motor_resistance_ohm", resistance, fit.sigma(0), "of the winding"),
        Quantity("motor_inductance_h", inductance, fit.sigma(1), "of the winding"),
        Quantity("current_gain", gain, gain * relative, "of the sensor, over what it should have"),
    )


def torque_constant(
    speed_rad_s: Array, voltage_v: Array, current_a: Array, *, resistance_ohm: float
) -> Quantity:
    """Estimate the torque constant from the back-EMF at steady speeds, both ways (step 3).

    ``voltage - R current = k speed + offset``; one N m/A is one V s/rad.

    Raises
    ------
    Refusal
        "one_way", "reversed_motor".
    """
    if np.min(speed_rad_s) > 0.0 or np.max(speed_rad_s) < 0.0:
        raise Refusal("torque constant", "one_way", "the knob turned one way only: it is held")
    slopes = np.column_stack([speed_rad_s, np.ones(len(speed_rad_s))])
    fit = linear(slopes, voltage_v - resistance_ohm * current_a)
    constant = float(fit.value[0])
    if constant < 0.0:
        raise Refusal(
            "torque constant", "reversed_motor", "the back-EMF has the sign of the speed's "
            "opposite: motor "
            "and encoder disagree; change motor_reversed or encoder_reversed",
        )  # fmt: skip
    return Quantity("motor_torque_constant_nm_per_a", constant, fit.sigma(0), "from the back-EMF")
