"""Hidden knobs of the study of calibration, measured through a board's binary."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final

import torsio
from tests.board import pico
from tests.board.felt import ELECTRICS
from tests.board.live import live_knob
from torsio import calibration
from torsio.printed.plant import PlantParams
from torsio_studies.calibration.driven import electric_plant, seen_truth
from torsio_studies.calibration.knobs import HiddenKnob

# The chip's converter rounds. The firmware, like the emulated device, assumes one that cuts off, so
# it adds half a step to the sensor's zero.
_HALF_STEP_V: Final = 3.3 / 4096 / 2


def board_plant(hidden: HiddenKnob) -> PlantParams:
    """Give a knob the electrics of the chosen board."""
    return electric_plant(hidden, ELECTRICS[pico.chosen.name])


@contextmanager
def _emulated(plant: PlantParams) -> Iterator[torsio.Knob]:
    options = torsio.EmulatorOptions(
        plant=plant,
        control_rate_hz=1e9 / pico.chosen.tick_ns,
        # It does not know which loop it has.
        actuator=torsio.ActuatorConfig(motor_time_constant_s=pico.chosen.motor_lag_s),
    )
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
    with (_emulated if emulated else _binary)(board_plant(hidden)) as knob:
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
                calibration.calibrate(knob, drift=quick)
                row["refused_rightly"] = False
            except calibration.Refusal as refusal:
                row["refused_rightly"] = refusal.reason == "reversed"
            knob.update(encoder_reversed=False)
            knob.sleep(1.0)  # until it stands again
        row |= {"refused": None, "found": {}}
        try:
            found = calibration.calibrate(knob, drift=quick)
        except calibration.Refusal as refusal:
            row["refused"] = f"{refusal.reason}: {refusal}"
            return row
        told = torsio.BoardConfig().motor_torque_constant_nm_per_a
        truth = seen_truth(
            board_plant(hidden),
            constant_known=found.board is not None
            and found.board.motor_torque_constant_nm_per_a != told,
        )
        if not emulated:
            truth["current_zero_v"] += _HALF_STEP_V
        row["knob_seconds"] = found.seconds
        row["found"] = {
            name: (of.value, of.standard_uncertainty, truth[name])
            for name, of in found.quantities.items()
        }
    return row
