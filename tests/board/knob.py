"""A board's binary as a knob that `torsio.calibration` measures."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from tests.board import pico
from tests.board.felt import ALIVE_MS, ELECTRICS, Bench, binary, twin
from tests.board.pico import STATUS
from torsio import calibration
from torsio.config import ActuatorConfig, CalibrationConfig, ControlConfig
from torsio.errors import Refused
from torsio.knob import Knob
from torsio.plant import PlantParams
from torsio.scenes import Excitation
from torsio.telemetry import TELEMETRY_DTYPE, Record
from torsio_studies.calibration.knobs import HiddenKnob, truth_of

MOST_RATE_HZ = 3600.0  # as the library takes it unless it is told otherwise


class BoardKnob:
    """What a calibration asks of a `Knob`, over the endpoints of a board's emulated chip."""

    is_open = True

    def __init__(self, bench: Bench) -> None:
        self._board = bench.board
        self._decimation = 0
        identity = self._board.get("identity")
        self._torque_step_nm = identity["torque_step_nm"]
        self.info = SimpleNamespace(
            serial=bytes(identity["serial"]).rstrip(b"\0").decode(),
            board=self._board.model.name,
            firmware_version=".".join(map(str, identity["firmware_version"])),
            control_rate_hz=1e9 / identity["control_period_ns"],
            counts_per_rev=identity["counts_per_rev"],
        )

    def as_knob(self) -> Knob:
        """Give it under the name that a calibration has for it."""
        return cast(Knob, self)

    @property
    def state(self) -> str:
        return str(self._board.get("health")["state"])

    @property
    def last_disarm(self) -> Any:
        """Why an excitation came to its end, by the device's last event that tells."""
        self._hear()
        kinds = [event["kind"] for event in self._board.events]
        told = [kind for kind in kinds if kind not in ("state_changed", "owner_changed")]
        return SimpleNamespace(reason=told[-1]) if told else None

    def actuator_config(self) -> ActuatorConfig:
        return cast(ActuatorConfig, self._config("actuator_config", ActuatorConfig))

    def control_config(self) -> ControlConfig:
        return cast(ControlConfig, self._config("control_config", ControlConfig))

    def calibration_config(self) -> CalibrationConfig:
        return cast(CalibrationConfig, self._config("calibration_config", CalibrationConfig))

    def configure(self, config: ActuatorConfig | ControlConfig) -> None:
        name = "actuator_config" if isinstance(config, ActuatorConfig) else "control_config"
        values = dataclasses.asdict(config)
        told = {k: ("off", "on")[v] if isinstance(v, bool) else v for k, v in values.items()}
        self._check(self._board.set(name, **told))

    def stop(self) -> None:
        self._check(self._board.send("command", op="stop"))

    def arm(self) -> None:
        self._board.events.clear()
        self._check(self._board.send("command", op="arm"))

    def disarm(self) -> None:
        self._check(self._board.send("command", op="disarm"))

    def excite(self, excitation: Excitation) -> None:
        self._check(self._board.send("excitation", **dataclasses.asdict(excitation)))

    def start_telemetry(self) -> float:
        self._decimation = -int(-self.info.control_rate_hz // MOST_RATE_HZ)
        self._check(self._board.send("stream", decimation=self._decimation, prompt="off"))
        return float(self.info.control_rate_hz / self._decimation)

    def stop_telemetry(self) -> None:
        self._check(self._board.send("stream", decimation=0, prompt="off"))

    def sleep(self, duration_s: float) -> None:
        """Let time pass with a host that is alive and reads all there is, each millisecond."""
        for ms in range(round(1e3 * duration_s)):
            if ms % ALIVE_MS == 0:
                self._board.post("command", op="keep_alive")
            self._board.run(1)
            self._hear()

    def read(self, *, max_samples: int = 4096, timeout_s: float = 1.0) -> Record:
        """Give what has come, and forget it."""
        if timeout_s > 0.0:
            self.sleep(2e-3)
        self._hear()
        rows = []
        tick_s = 1.0 / self.info.control_rate_hz
        for report in self._board.telemetry:
            for n in range(report["axis_samples"] >> 4):
                sample = report["sample"][n]
                tick = report["tick"] + n * report["decimation"]
                rows.append(
                    (
                        tick * tick_s,
                        report["base_counts"] + sample["offset_counts"],
                        self._torque_step_nm * sample["motor_command"],
                        self._torque_step_nm * sample["brake_capacity"],
                    )
                )
        self._board.telemetry.clear()
        log = np.zeros(min(len(rows), max_samples), dtype=TELEMETRY_DTYPE)
        names = ("time_s", "position_counts", "motor_command_nm", "brake_capacity_nm")
        for name, column in zip(names, zip(*rows, strict=True), strict=False):
            log[name] = column[:max_samples]
        return log

    def _hear(self) -> None:
        """Fetch input reports until the board has none."""
        board, heard = self._board, -1
        while heard != (heard := len(board.telemetry) + len(board.events)):
            board.listen(1, within_ms=0)

    def _config(self, name: str, kind: type[Any]) -> Any:
        values = self._board.get(name)
        told = {field.name: values[field.name] for field in dataclasses.fields(kind)}
        return kind(**{k: v == "on" if v in ("on", "off") else v for k, v in told.items()})

    @staticmethod
    def _check(acknowledgement: dict[str, Any]) -> None:
        status = STATUS[acknowledgement["status"]]
        if status != "ok":
            raise Refused(status)


def electric(plant: PlantParams) -> PlantParams:
    """Give a knob the electrics of the board; its brake then lags by its coil."""
    electrics = ELECTRICS[pico.chosen.name]
    coil_h = plant.brake_time_constant_s * electrics.coil_resistance_ohm
    return replace(plant, electrics=replace(electrics, coil_inductance_h=coil_h))


@contextmanager
def hidden_board(
    hidden: HiddenKnob, place: Callable[[PlantParams], AbstractContextManager[Bench]] = binary
) -> Iterator[BoardKnob]:
    """Give a board, or its twin, that knows nothing of its knob but counts and limits."""
    with place(electric(hidden.plant)) as bench:
        # For so long the winding stands more.
        assert bench.board.set("board_config", motor_current_continuous_a=2.0)["status"] == 0
        knob = BoardKnob(bench)
        knob.configure(replace(knob.actuator_config(), encoder_reversed=hidden.reversed))
        yield knob


def calibrate_hidden(hidden: HiddenKnob, *, quick: bool, emulated: bool = False) -> dict[str, Any]:
    """Calibrate a knob through the chosen board's binary; a reversed encoder must be refused.

    Parameters
    ----------
    emulated
        Through the emulated device in place of the binary.

    Returns
    -------
    dict
        ``found`` has value, standard uncertainty and truth of each quantity; ``refused`` why there
        are none, or None.
    """
    row: dict[str, Any] = {"number": hidden.number, "quick": quick, "refused_rightly": True}
    with hidden_board(hidden, twin if emulated else binary) as knob:
        if hidden.reversed:
            try:
                calibration.calibrate(knob.as_knob(), quick=quick)
                row["refused_rightly"] = False
            except calibration.Refusal as refusal:
                row["refused_rightly"] = refusal.reason == "reversed"
            knob.configure(replace(knob.actuator_config(), encoder_reversed=False))
            knob.sleep(1.0)  # until it stands again
        row |= {"refused": None, "found": {}}
        try:
            found = calibration.calibrate(knob.as_knob(), quick=quick)
        except calibration.Refusal as refusal:
            row["refused"] = f"{refusal.reason}: {refusal}"
            return row
        truth = truth_of(hidden.plant)
        row["knob_seconds"] = found.seconds
        row["found"] = {
            name: (of.value, of.standard_uncertainty, truth[name])
            for name, of in found.quantities.items()
        }
    return row
