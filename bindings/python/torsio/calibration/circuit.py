"""The steps that measure the motor's circuit: power off, brake held, knob turned."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from torsio.calibration.drive import drive_of
from torsio.calibration.electric import (
    SUPPLY_CONFIGURED,
    SUPPLY_METERED,
    Circuit,
    Intervals,
    check_current,
    current_zero,
    intervals,
    motor,
    winding,
)
from torsio.calibration.found import Findings, Runs
from torsio.calibration.play import Player
from torsio.calibration.quantity import Quantity
from torsio.knob import Knob
from torsio.printed.config import BoardConfig
from torsio.printed.told import MotorCurrent

__all__ = ["ELECTRIC_STEPS", "MEASURED_OF_BOARD", "CircuitSteps"]

ELECTRIC_STEPS = ("current sensor", "torque constant", "winding")
"""Steps that only a device with a current sensor takes, as `progress` names them.

They come before the signs, after them, and before the shaft. The step that holds the brake comes
late: a brake may keep some of its torque."""

MEASURED_OF_BOARD = (
    *("supply_v", "motor_resistance_ohm", "motor_inductance_h", "motor_torque_constant_nm_per_a"),
)
"""Proposed fields of `BoardConfig`; the supply only where its voltage was told."""

_REST_READINGS, _REST_EVERY_S = 300, 1e-3
# To and fro, so that the knob comes to rest; longer than a fault takes to show.
_PULSES, _PULSE_S, _PULSE_SHARE, _PULSE_RAD = (1.0, -1.0, -1.0, 1.0), 0.015, 0.2, 0.25
_HOLD_S = 0.5  # until the brake holds
_LEVELS = (0.4, -0.4, 0.7, -0.7, 1.0, -1.0)
_LEVEL_S, _RAMP_S, _LEVEL_SETTLE_S = 0.1, 4e-3, 14e-3
# About a middle that is higher, so that the voltage keeps its sign; too fast for the shaft.
_WAVE_S, _WAVE_MIDDLE, _WAVE_PEAK, _WAVE_HZ = 0.5, 0.75, 0.35, (230.0, 330.0)
_REST_S, _LET_GO_S = 0.3, 0.6  # until the shaft is relaxed; until the brake is off
_LOOK_S = 5e-3
_TRAVEL_RAD = 0.4
_SPEEDS_RAD_S = (25.0, 50.0, 75.0)
_TURN_S, _TURN_SETTLE_S, _TURN_LOOK_S = 0.3, 0.14, 20e-3
_TURN_LIMIT_RAD_S = 150.0
# Share of the found torque constant. A supply that is a tenth off makes it wrong by 1 / 0.9 - 1.
_BY_SUPPLY = 0.11


def listen_at_rest(player: Player, board: BoardConfig) -> tuple[Quantity, Quantity]:
    """Listen to the current sensor while nothing flows; give its zero and its noise.

    Raises
    ------
    Refusal
        "dead_sensor", "saturated_sensor".
    """
    readings: list[MotorCurrent] = []
    for _ in range(_REST_READINGS):
        player.watch(_REST_EVERY_S)
        readings.append(player.motor_current())
    return current_zero(
        np.array([of.current_a + of.zero_a for of in readings]) * np.sign(readings[0].zero_a),
        step_a=readings[0].step_a,
        v_per_a=board.current_sense_v_per_a,
    )


def pulse(player: Player, board: BoardConfig, *, motor_nm: float) -> None:
    """Give the motor small pulses, and compare the current with the voltage.

    Raises
    ------
    Refusal
        "no_current", "reversed_sensor", or why the device disarmed.
    """
    begin = player.motor_current()
    looks = _Looks(player, 0.0)
    log = player.chain(
        [(_PULSE_S, {"motor_command_nm": way * _PULSE_SHARE * motor_nm}) for way in _PULSES],
        look=looks,
        look_every_s=_PULSE_S,
        travel_rad=_PULSE_RAD,
        speed_limit_rad_s=60.0,
        torque_limit_nm=motor_nm,
    )
    over = intervals([begin, *looks.all, player.motor_current()], board.supply_v)
    pushed = over.chosen(np.abs(over.voltage_v_s) > 0.0)
    if pushed.duration_s.size > 0:
        check_current(pushed, board.motor_resistance_ohm, step=ELECTRIC_STEPS[0])
    if log.stopped != "excitation_stopped":  # a quarter of a radian is enough, too
        log.refuse_if_stopped(ELECTRIC_STEPS[0], "", "")
    player.watch(_LET_GO_S)


class _Looks:
    """Readings while a stretch plays, from `settle_s` after its begin."""

    def __init__(self, player: Player, settle_s: float) -> None:
        self._player, self._settle_s = player, settle_s
        self.all: list[MotorCurrent] = []
        self._parts: dict[int, list[MotorCurrent]] = {}
        self._begin_s: dict[int, float] = {}

    def __call__(self, stretch: int) -> MotorCurrent:
        now = self._player.motor_current()
        self.all.append(now)
        if now.time_s >= self._begin_s.setdefault(stretch, now.time_s) + self._settle_s:
            self._parts.setdefault(stretch, []).append(now)
        return now

    def intervals(self, stretches: Iterable[int], supply_v: float) -> Intervals:
        """Give those within these stretches; none reaches from one into the next."""
        parts = [self._parts.get(stretch, []) for stretch in stretches]
        return Intervals.together([intervals(part, supply_v) for part in parts if len(part) > 1])


def push_current(
    player: Player, board: BoardConfig, *, motor_nm: float, brake_nm: float
) -> Intervals:
    """Hold the brake; drive currents both ways, then waves of current.

    The motor's current loop makes them, so all of its limits hold.

    Raises
    ------
    Refusal
        "does_not_hold", or why the device disarmed.
    """
    continuous_nm = board.motor_current_continuous_a * board.motor_torque_constant_nm_per_a
    most_nm = min(0.45 * motor_nm, 0.5 * brake_nm, 0.9 * continuous_nm)
    levels = [
        (_LEVEL_S, {"motor_command_nm": share * most_nm, "ramp_s": _RAMP_S}) for share in _LEVELS
    ]
    begin_hz, end_hz = _WAVE_HZ
    wave = {"sine_nm": _WAVE_PEAK * most_nm, "sine_begin_hz": begin_hz, "sine_end_hz": end_hz}
    waves = [
        (_WAVE_S, {"motor_command_nm": way * _WAVE_MIDDLE * most_nm, "ramp_s": _RAMP_S, **wave})
        for way in (1.0, -1.0)
    ]
    rest = (_REST_S, {"motor_command_nm": 0.0, "ramp_s": 0.5 * _REST_S})
    looks = _Looks(player, _LEVEL_SETTLE_S)
    log = player.chain(
        [(_HOLD_S, {"motor_command_nm": 0.0}), *levels, *waves, rest],
        look=looks,
        look_every_s=_LOOK_S,
        brake_command_nm=brake_nm,
        travel_rad=_TRAVEL_RAD,
        speed_limit_rad_s=60.0,
        torque_limit_nm=most_nm,
    )
    log.refuse_if_stopped(
        ELECTRIC_STEPS[2], "does_not_hold", f"the motor pushed with {1e3 * most_nm:.0f} mN m and "
        f"the knob came loose, though the brake should hold {1e3 * brake_nm:.0f}: brake or its "
        "wires are dead, or a coupling slips",
    )  # fmt: skip
    player.watch(_LET_GO_S)
    return looks.intervals(range(1, 1 + len(levels) + len(waves)), board.supply_v)


def turn_steadily(player: Player, board: BoardConfig, *, motor_nm: float) -> Intervals:
    """Turn the knob at several speeds, both ways.

    Raises
    ------
    Refusal
        "runs_away", or why the device disarmed.
    """
    # A rest between the two directions: the braking motor raises the supply for a moment.
    speeds = (*_SPEEDS_RAD_S, 0.0, *(-speed for speed in _SPEEDS_RAD_S), 0.0)
    looks = _Looks(player, _TURN_SETTLE_S)
    log = player.chain(
        [
            (_TURN_S, {"damping_nm_s_per_rad": 6e-3, "servo_rad_s": speed})
            for speed in speeds
        ],
        look=looks,
        look_every_s=_TURN_LOOK_S,
        travel_rad=600.0,
        speed_limit_rad_s=_TURN_LIMIT_RAD_S,
        torque_limit_nm=0.75 * motor_nm,
    )  # fmt: skip
    log.refuse_if_stopped(
        ELECTRIC_STEPS[1], "runs_away", "the device stopped the turns: the encoder stopped "
        "counting while the motor pulled, or the knob is not what it was a moment ago",
    )  # fmt: skip
    turning = [stretch for stretch, speed in enumerate(speeds) if speed != 0.0]
    return looks.intervals(turning, board.supply_v)


class CircuitSteps:
    """The steps of a device that measures its motor's current.

    Parameters
    ----------
    motor_nm, brake_nm
        The most that they ask of both.
    supply_v
        Voltage by a meter; None: nobody has measured it.
    """

    def __init__(
        self, knob: Knob, *, motor_nm: float, brake_nm: float, supply_v: float | None
    ) -> None:
        self._knob, self._motor_nm, self._brake_nm = knob, motor_nm, brake_nm
        self._board = board = knob.board_config()
        self._supply_sigma = 0.0
        self._guesses_supply = supply_v is None and board.supply_sense_pin == 0
        if supply_v is not None:
            self._board = replace(board, supply_v=supply_v)
            self._supply_sigma = SUPPLY_METERED
        elif self._guesses_supply:
            self._supply_sigma = SUPPLY_CONFIGURED

    def look(self, player: Player, _: Findings) -> Runs:
        """Look at the current sensor before anything turns; raises as `listen_at_rest`, `pulse`."""
        self._sensor = listen_at_rest(player, self._board)
        pulse(player, self._board, motor_nm=self._motor_nm)
        return ()

    def turn(self, player: Player, _: Findings) -> Runs:
        """Turn the knob, which is free. Raises as `turn_steadily`."""
        self._turned = turn_steadily(player, self._board, motor_nm=self._motor_nm)
        return ()

    def hold(self, player: Player, _: Findings) -> Runs:
        """Hold the knob. Raises as `push_current`."""
        most = {"motor_nm": self._motor_nm, "brake_nm": self._brake_nm}
        self._held = push_current(player, self._board, **most)
        # The device may still use older values than the configured ones.
        self._believed_nm_per_a = player.motor_current().torque_constant_nm_per_a
        return ()

    def circuit(self, _: Runs, found: Findings) -> Findings:
        """Estimate circuit and drive; raises as `winding` and `motor`."""
        board, held = self._board, self._held
        believed_by_board = {
            "believed_ohm": board.motor_resistance_ohm,
            "believed_h": board.motor_inductance_h,
        }
        winding(held, **believed_by_board, constant_nm_per_a=board.motor_torque_constant_nm_per_a)
        of_motor = motor(held, self._turned, **believed_by_board, supply_sigma=self._supply_sigma)
        constant = of_motor.constant.value
        told = board.motor_torque_constant_nm_per_a
        # The data sheet is the better guess where the supply is one.
        if self._guesses_supply and abs(told / constant - 1.0) < _BY_SUPPLY:
            constant = told
        proposed = replace(
            board,
            motor_resistance_ohm=of_motor.resistance.value,
            motor_inductance_h=of_motor.inductance.value,
            motor_torque_constant_nm_per_a=constant,
        )
        measured = (of_motor.resistance, of_motor.inductance, of_motor.gain, of_motor.constant)
        circuit = Circuit(
            (*self._sensor, *measured),
            of_motor,
            proposed,
            torque_scale=constant / self._believed_nm_per_a,
            torque_share=of_motor.constant_sigma,
        )
        return {**found, "circuit": circuit, "drive": drive_of(self._knob, proposed)}

    def turns(self, player: Player, found: Findings) -> Runs:
        """Give the turns of before with the torques as they truly were."""
        return (player.rescaled(found["turns"]),)
