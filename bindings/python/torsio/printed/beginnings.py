"""How a plant and a closed loop may begin, if not at rest."""

# Printed from the field lists in emulator/definition/ by `./dev generate`;
# change those instead.

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

from torsio.common import checks

__all__ = [
    "InitialState",
    "SpinUp",
]


@dataclass(frozen=True, repr=False)
class SpinUp(checks.ByName):
    """A first phase of a closed loop with the law held off.

    The motor's torque is prescribed, the brake is off.

    It ends when the knob is fast enough. Where that happens becomes angle 0, and when it happens
    time 0; the rows begin there.

    Attributes
    ----------
    motor_command_nm
        Positive or negative, not 0.
    speed_rad_s
        To be reached in the direction of the torque; > 0.
    longest_s
        Giving up after; > 0.
    """

    _: KW_ONLY
    motor_command_nm: float
    speed_rad_s: float
    longest_s: float = 10.0


@dataclass(frozen=True, repr=False)
class InitialState(checks.ByName):
    """Where a plant begins, if not at rest at angle 0.

    Attributes
    ----------
    time_s
        0 to 1e9.
    revolutions
        Whole turns, exact however many; -1e12 to 1e12.
    angle_rad
        Beyond them; -1e9 to 1e9.
    speed_rad_s
        Of knob and brake together; -1e15 to 1e15.
    twist_rad
        Of the shaft spring: knob minus brake; -1e9 to 1e9.
    motor_torque_nm
        After the motor's lag; -1e15 to 1e15.
    brake_magnetic_nm
        Torque that the brake holds by its current, without its drag; >= 0.
    """

    _: KW_ONLY
    time_s: float = 0.0
    revolutions: int = 0
    angle_rad: float = 0.0
    speed_rad_s: float = 0.0
    twist_rad: float = 0.0
    motor_torque_nm: float = 0.0
    brake_magnetic_nm: float = 0.0
