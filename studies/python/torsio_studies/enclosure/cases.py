"""Plants in a hand, with commands, that the study plays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from torsio.emulator import Plant
from torsio.printed.hands import Hand, TorqueHand
from torsio.printed.plant import (
    Belt,
    BrakeHysteresis,
    Cogging,
    Electrics,
    PlantParams,
    ShaftHardening,
)

__all__ = ["PERIOD_S", "Case", "electric_case", "emulate", "random_case"]

Array = npt.NDArray[np.float64]

PERIOD_S: Final = 1e-3
_TICKS: Final = 60
_SPREAD: Final = 30.0
"""Each parameter of a random plant is up to so many times the reference's, or one part of it."""
_NAMES: Final = (
    *("knob_inertia_kg_m2", "knob_viscous_nm_s_per_rad", "knob_coulomb_nm", "brake_inertia_kg_m2"),
    *("brake_viscous_nm_s_per_rad", "brake_drag_nm", "shaft_stiffness_nm_per_rad"),
    *("shaft_damping_nm_s_per_rad", "brake_time_constant_s", "motor_time_constant_s"),
)


@dataclass(frozen=True)
class Case:
    """Commands to a plant in a hand; with electrics shares of the supply."""

    name: str
    plant: PlantParams
    hand: Hand
    motor_nm: tuple[float, ...]
    brake_nm: tuple[float, ...]
    with_scipy: bool = False
    period_ns: int = round(1e9 * PERIOD_S)


def random_case(number: int, ticks: int = _TICKS) -> Case:
    """Make a plant with every part, a hand that pulls to and fro, and commands that jump."""
    random = np.random.default_rng([37, number])

    def near(value: float, spread_by: float = _SPREAD) -> float:
        return float(value * spread_by ** random.uniform(-1.0, 1.0))

    reference = PlantParams()
    values: dict[str, Any] = {name: near(getattr(reference, name)) for name in _NAMES}
    plant = PlantParams(
        **values,
        shaft_hardening=ShaftHardening(knee_rad=near(5e-3), stiffness_factor=near(1.0, 4.0)),
        brake_hysteresis=BrakeHysteresis(half_width_nm=near(5e-3)),
        belt=Belt(
            stiffness_nm_per_rad=near(60.0),
            damping_nm_s_per_rad=near(1e-3),
            pulley_inertia_kg_m2=float(random.uniform(0.1, 0.9)) * values["brake_inertia_kg_m2"],
        ),
        cogging=Cogging(
            periods_per_rev=int(random.integers(1, 200)),
            torque_nm=random.normal(0.0, 3e-3, int(random.integers(2, 17))).tolist(),
        ),
    )
    # In whole microseconds: the emulator counts whole nanoseconds.
    times = np.sort(random.uniform(0.0, ticks * PERIOD_S, 5)).round(6)
    hand = TorqueHand(torque_nm=np.column_stack([times, random.uniform(-0.1, 0.1, 5)]))
    held = np.arange(ticks) // 7
    motor = random.uniform(-0.08, 0.08, ticks)[held]
    brake = random.uniform(0.0, 0.1, ticks)[held]
    return Case(f"plant {number}", plant, hand, tuple(motor.tolist()), tuple(brake.tolist()))


def electric_case(number: int, ticks: int = _TICKS) -> Case:
    """Make a random plant with what its electrics do exactly.

    The supply gives any current, the copper stays cold, and the coil's current has one sign and no
    play.
    """
    case, random = random_case(number, ticks), np.random.default_rng([38, number])
    reference = Electrics()
    values: dict[str, Any] = {
        name: float(getattr(reference, name) * 10.0 ** random.uniform(-1.0, 1.0))
        for name in (
            *("winding_resistance_ohm", "winding_inductance_h", "torque_constant_nm_per_a"),
            *("coil_resistance_ohm", "coil_inductance_h", "coil_torque_constant_nm_per_a"),
        )
    }
    electrics = Electrics(
        **values, supply_v=float(random.uniform(5.0, 50.0)), supply_resistance_ohm=0.0,
        winding_heat_j_per_k=1e9, coil_heat_j_per_k=1e9,
    )  # fmt: skip
    return replace(
        case,
        name=f"electrics {number}",
        plant=replace(case.plant, brake_hysteresis=None, electrics=electrics),
        motor_nm=tuple((np.array(case.motor_nm) / 0.08).tolist()),
        brake_nm=tuple((np.array(case.brake_nm) / 0.1).tolist()),
    )


def emulate(case: Case) -> Array:
    """Give what `Enclosure.values` encloses, at the periods' ends."""
    motor, brake = np.array(case.motor_nm), np.array(case.brake_nm)
    plant, period_ns = Plant(case.plant, case.hand), case.period_ns
    if (parts := case.plant.electrics) is None:
        return plant.drive(motor, brake, period_ns=period_ns)
    # A row is at a period's begin.
    motor, brake, on = np.append(motor, 0.0), np.append(brake, 0.0), np.ones(len(motor) + 1)
    rows, _ = plant.record_bridges(motor, brake, on, period_ns=period_ns)
    current = rows["motor_torque_nm"] / parts.torque_constant_nm_per_a
    return np.column_stack([rows["angle_rad"], rows["brake_angle_rad"], current])[1:]
