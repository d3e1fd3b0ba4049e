"""Hidden knobs of the study of calibration, measured through a board's binary."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

import torsio
from tests.board import pico
from tests.board.felt import ELECTRICS
from tests.board.live import live_knob
from torsio import calibration
from torsio.plant import PlantParams
from torsio_studies.calibration.knobs import HiddenKnob, truth_of


def electric_plant(hidden: HiddenKnob) -> PlantParams:
    """Give a knob the electrics of the board; its brake then lags by its coil.

    When the board reads its current, after the middle of the pulse, is hidden too; and supply,
    current sensor and winding are up to a tenth off from what the board is configured to.
    """
    electrics = ELECTRICS[pico.chosen.name]
    supply, sensor, winding = np.random.default_rng([17, hidden.number]).uniform(0.9, 1.1, 3)
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
    # The coil's current is not measured: its voltage is what the brake gives more or less.
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
        "motor_torque_constant_nm_per_a": constant,
        "current_gain": sensor,
    }


@contextmanager
def _emulated(plant: PlantParams) -> Iterator[torsio.Knob]:
    rate_hz = 1e9 / pico.chosen.tick_ns
    options = torsio.EmulatorOptions(plant=plant, control_rate_hz=rate_hz)
    with torsio.open("emulated", emulator=options) as knob:
        yield knob


@contextmanager
def _binary(plant: PlantParams) -> Iterator[torsio.Knob]:
    with live_knob(plant) as (knob, _):
        yield knob


@contextmanager
def hidden_board(hidden: HiddenKnob, *, emulated: bool = False) -> Iterator[torsio.Knob]:
    """Give the chosen board, which knows nothing of its knob but counts and limits.

    Parameters
    ----------
    emulated
        The emulated device in place of the binary.
    """
    with (_emulated if emulated else _binary)(electric_plant(hidden)) as knob:
        # For so long the winding stands more.
        knob.update(motor_current_continuous_a=2.0)
        knob.update(encoder_reversed=hidden.reversed)
        yield knob


def calibrate_hidden(hidden: HiddenKnob, *, quick: bool, emulated: bool = False) -> dict[str, Any]:
    """Calibrate a knob through the chosen board; a reversed encoder must be refused.

    Returns
    -------
    dict
        ``found`` has value, standard uncertainty and truth of each quantity; ``refused`` why there
        are none, or None.
    """
    row: dict[str, Any] = {"number": hidden.number, "quick": quick, "refused_rightly": True}
    with hidden_board(hidden, emulated=emulated) as knob:
        if hidden.reversed:
            try:
                calibration.calibrate(knob, quick=quick)
                row["refused_rightly"] = False
            except calibration.Refusal as refusal:
                row["refused_rightly"] = refusal.reason == "reversed"
            knob.update(encoder_reversed=False)
            knob.sleep(1.0)  # until it stands again
        row |= {"refused": None, "found": {}}
        try:
            found = calibration.calibrate(knob, quick=quick)
        except calibration.Refusal as refusal:
            row["refused"] = f"{refusal.reason}: {refusal}"
            return row
        told = torsio.BoardConfig().motor_torque_constant_nm_per_a
        truth = seen_truth(
            electric_plant(hidden),
            constant_known=found.board is not None
            and found.board.motor_torque_constant_nm_per_a != told,
        )
        row["knob_seconds"] = found.seconds
        row["found"] = {
            name: (of.value, of.standard_uncertainty, truth[name])
            for name, of in found.quantities.items()
        }
    return row
