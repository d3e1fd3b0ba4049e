"""Hidden knobs with a board's electrics, hidden too, and what a calibration through them sees."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

import torsio
from torsio import calibration
from torsio.printed.plant import Electrics, PlantParams
from torsio_studies.calibration.knobs import QUANTITIES, HiddenKnob, hidden_knob, truth_of

__all__ = [
    "ALL",
    "CIRCUIT",
    "drawn_electrics",
    "electric_plant",
    "example",
    "measure_driven",
    "seen_truth",
]

CIRCUIT: Final = (
    "current_zero_v", "current_noise_a", "motor_resistance_ohm", "motor_inductance_h",
    "motor_torque_constant_nm_per_a", "current_gain",
)  # fmt: skip
ALL: Final = (*QUANTITIES, *CIRCUIT)
_RATE_HZ: Final = 20_000.0  # a Pico 2's
_EXAMPLE: Final = 1034  # has cogging, a loop of its brake, a belt, and a shaft that hardens
_OFF: Final = 0.1  # largest error of the told values of supply, sensor and winding


def drawn_electrics(number: int) -> Electrics:
    """Give a board's electrics with the motor's sign and inductance at random."""
    random = np.random.default_rng([18, number])
    electrics = Electrics()
    return replace(
        electrics,
        motor_reversed=bool(random.random() < 0.5),
        winding_inductance_h=float(random.uniform(1.0 - _OFF, 1.0 + _OFF))
        * electrics.winding_inductance_h,
    )


def electric_plant(hidden: HiddenKnob, electrics: Electrics) -> PlantParams:
    """Give a knob the electrics of a board; its brake then lags by its coil.

    When the board reads its current, near the middle of the pulse, is hidden too; and supply,
    current sensor and winding are up to a tenth off from what the board is configured to.
    """
    supply, sensor, winding = np.random.default_rng([17, hidden.number]).uniform(
        1.0 - _OFF, 1.0 + _OFF, 3
    )
    late_s = np.random.default_rng([16, hidden.number]).normal(1.0e-6, 0.35e-6)
    return replace(
        hidden.plant,
        electrics=replace(
            electrics,
            coil_inductance_h=hidden.plant.brake_time_constant_s * electrics.coil_resistance_ohm,
            sample_offset_s=max(float(late_s), 0.0),
            supply_v=float(supply) * electrics.supply_v,
            sensor_v_per_a=float(sensor) * electrics.sensor_v_per_a,
            winding_resistance_ohm=float(winding) * electrics.winding_resistance_ohm,
        ),
    )


def seen_truth(plant: PlantParams, *, constant_known: bool) -> dict[str, float]:
    """Give what a perfect calibration would find through the board's sensor and its supply.

    Torques are as the board sees them: of the torque constant that it was configured to, or of the
    one that it found with the supply that it was told, and proposes, times the current that its
    sensor says.
    """
    electrics = plant.electrics
    assert electrics is not None
    told = torsio.BoardConfig()
    supply = told.supply_v / electrics.supply_v
    sensor = electrics.sensor_v_per_a / told.current_sense_v_per_a
    constant = electrics.torque_constant_nm_per_a * supply
    known = constant if constant_known else told.motor_torque_constant_nm_per_a
    torque = known * sensor / electrics.torque_constant_nm_per_a
    # The coil's current is not measured, so an error of its voltage is an error of the brake's
    # torque.
    truth = truth_of(plant) | {"brake_gain": 1.0 / supply}
    # A play of the brake's command is one of the command.
    truth["hysteresis_nm"] *= supply / torque
    of_torque = ("_nm", "_nm_per_rad", "_nm_s_per_rad", "_kg_m2", "brake_gain")
    return {
        name: torque * value if name.endswith(of_torque) else value for name, value in truth.items()
    } | {
        "current_zero_v": electrics.sensor_zero_v,
        "current_noise_a": electrics.sensor_noise_v / told.current_sense_v_per_a,
        "motor_resistance_ohm": electrics.winding_resistance_ohm * supply / sensor,
        "motor_inductance_h": electrics.winding_inductance_h * supply / sensor,
        # Not scaled by the supply: the stated uncertainty covers that.
        "motor_torque_constant_nm_per_a": electrics.torque_constant_nm_per_a,
        "current_gain": sensor,
    }


def _opened(hidden: HiddenKnob, plant: PlantParams) -> torsio.Knob:
    options = torsio.EmulatorOptions(seed=hidden.number, plant=plant, control_rate_hz=_RATE_HZ)
    knob = torsio.open("emulated", emulator=options)
    # For so long the winding stands more.
    knob.update(motor_current_continuous_a=2.0)
    return knob


def example() -> calibration.Calibration:
    """Calibrate a knob that has all that a knob may have, through its electrics."""
    hidden = hidden_knob(_EXAMPLE)
    electrics = replace(drawn_electrics(hidden.number), motor_reversed=False)
    with _opened(hidden, electric_plant(hidden, electrics)) as knob:
        return calibration.calibrate(knob)


def measure_driven(hidden: HiddenKnob) -> dict[str, float]:
    """Calibrate a knob through its electrics; if encoder and motor disagree it must be refused.

    The supply is not metered.
    """
    electrics = drawn_electrics(hidden.number)
    plant, mirrored = electric_plant(hidden, electrics), electrics.motor_reversed
    row = dict.fromkeys((f"{name}_{part}" for name in ALL for part in ("value", "sigma")), math.nan)
    row |= dict.fromkeys((f"{name}_truth" for name in ALL), math.nan)
    row |= {"refused_rightly": 1.0, "complete": 0.0, "knob_seconds": math.nan}
    with _opened(hidden, plant) as knob:
        knob.update(encoder_reversed=hidden.reversed)
        if hidden.reversed != mirrored:
            try:
                calibration.calibrate(knob)
                row["refused_rightly"] = 0.0
            except calibration.Refusal as refusal:
                row["refused_rightly"] = float(refusal.reason == "reversed")
            knob.update(encoder_reversed=mirrored)
            knob.sleep(1.0)  # until it stands again
        told = knob.board_config().motor_torque_constant_nm_per_a
        try:
            found = calibration.calibrate(knob)
        except calibration.Refusal:
            return row
    assert found.board is not None
    truth = seen_truth(plant, constant_known=found.board.motor_torque_constant_nm_per_a != told)
    row |= {"complete": 1.0, "knob_seconds": found.seconds}
    row |= {f"{name}_truth": truth[name] for name in ALL}
    for name, of in found.quantities.items():
        row[f"{name}_value"], row[f"{name}_sigma"] = of.value, of.standard_uncertainty
    return row
