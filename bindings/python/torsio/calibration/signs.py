"""A step with the brake off: whether the knob turns, both ways, and as the encoder counts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from torsio.calibration.play import Player
from torsio.calibration.quantity import Refusal

__all__ = ["UNSEEN_RAD_S", "find_signs"]

_SIGNS = "signs"
_NOISE_COUNTS = 4.0
UNSEEN_RAD_S = 50.0
"""As fast as a knob may get whose encoder tells nothing."""
_PULSES = tuple(2.0 ** (-0.5 * step) for step in range(8, -1, -1))  # shares of the largest
_PULSE_S = (2e-3, 0.1)  # they last so long at least and at most
_PULSE_LIMIT_RAD_S = 60.0
_COAST_S = 0.1
# Far enough for a pulse: the shaft's twist under the motor's full torque is less.
_FREE_RAD = 0.25
# A knob that stays so far away has turned. A held knob springs back, except for its friction.
_TURNED_RAD = 0.05


def find_signs(player: Player, torque_nm: float, inertia_kg_m2: float) -> None:
    """Give the motor pulses to and fro, larger and larger, until the knob turns both ways.

    Each pulse brakes what the one before has set in motion. So a free knob of half the inertia that
    is configured never gets faster than `UNSEEN_RAD_S`, even if its encoder is dead and nobody sees
    it turn.

    Parameters
    ----------
    torque_nm
        Torque of the largest pulse.
    inertia_kg_m2
        That is configured for the knob.

    Raises
    ------
    Refusal
        "moved", "noisy", "still", "held", "inertia", "reversed", "one_way", "pulled".
    """
    # It may still swing from what was before.
    idle = player.settled(0.3, _NOISE_COUNTS)
    moved = float(np.ptp(idle.counts))
    if moved > _NOISE_COUNTS + 0.02 / player.count_rad:
        raise Refusal(
            _SIGNS, "moved", f"the knob moved by {moved:.0f} counts with the motor off: take your "
            "hand off it, and look for what turns it", counts=moved,
        )  # fmt: skip
    if moved > _NOISE_COUNTS:
        raise Refusal(
            _SIGNS, "noisy", f"the encoder jitters by {moved:.0f} counts while nothing moves: look "
            "at its supply, its wires and their shield", counts=moved,
        )  # fmt: skip
    most_nm_s = UNSEEN_RAD_S * 0.5 * inertia_kg_m2
    torque_nm = min(torque_nm, most_nm_s / _PULSE_S[0])
    pulse_s = min(most_nm_s / torque_nm, _PULSE_S[1])
    turned_at_nm: dict[float, float] = {}
    for share in _PULSES:
        pulses = [_push(player, way * share * torque_nm, pulse_s) for way in (1.0, -1.0)]
        for way, pulse in enumerate(pulses):
            if pulse.stays_rad > _TURNED_RAD:
                turned_at_nm.setdefault(way, share * torque_nm)
        if len(turned_at_nm) == 2:
            break
    if not turned_at_nm:
        _refuse_to_turn(torque_nm, pulses, player.count_rad)
    _refuse_pulled(list(turned_at_nm.values()))


@dataclass(frozen=True)
class _Pulse:
    """How far the knob came while a pulse lasted, and where it stayed; along its torque."""

    reached_rad: float
    stays_rad: float


def _push(player: Player, torque_nm: float, duration_s: float) -> _Pulse:
    """Give one pulse, and wait until the knob is at rest again.

    Raises
    ------
    Refusal
        "reversed", or why the device disarmed.
    """
    log = player.pulse(
        duration_s,
        motor_command_nm=torque_nm,
        travel_rad=_FREE_RAD,
        speed_limit_rad_s=_PULSE_LIMIT_RAD_S,
        torque_limit_nm=abs(torque_nm),
    )
    # It ends it by itself, and ends it sooner where the knob turns freely.
    if log.stopped not in ("", "excitation_over", "excitation_stopped"):
        log.refuse_if_stopped(_SIGNS, "", "")
    rest = player.settled(_COAST_S, _NOISE_COUNTS)
    along = np.copysign(1.0, torque_nm) * (log.angle_rad - log.angle_rad[0])
    pushed = along[np.flatnonzero(log.told_nm)]
    reached = float(pushed[np.argmax(np.abs(pushed))]) if pushed.size else 0.0
    stays = abs(float(rest.angle_rad[-1] - log.angle_rad[0]))
    if reached < 0.0 and stays > _TURNED_RAD:
        raise Refusal(
            _SIGNS, "reversed", "the encoder counts down while the motor's torque is positive: "
            "change "
            "encoder_reversed of the actuator, or motor_reversed of the board, not both",
            against_rad=-reached,
        )  # fmt: skip
    return _Pulse(abs(reached), stays)


def _refuse_to_turn(torque_nm: float, pulses: list[_Pulse], count_rad: float) -> None:
    """Say why the largest pulses, one each way, did not turn the knob."""
    reached = max(pulse.reached_rad for pulse in pulses)
    if max(reached, *(pulse.stays_rad for pulse in pulses)) < 5.0 * count_rad:
        raise Refusal(
            _SIGNS, "still", f"nothing moves at {1e3 * torque_nm:.0f} mN m: the motor is not "
            "connected, or far too weak, "
            "the encoder stands still, or the knob is jammed", reached_rad=reached,
        )  # fmt: skip
    # A knob that is held or rubs is soon at rest after the pulse; a heavy one goes on.
    if all(pulse.stays_rad > 2.0 * pulse.reached_rad for pulse in pulses):
        raise Refusal(
            _SIGNS, "inertia", f"a pulse of {1e3 * torque_nm:.0f} mN m hardly turns the knob: "
            "something heavy is on it, or the motor gives far less than motor_torque_max_nm says",
            reached_rad=reached,
        )  # fmt: skip
    raise Refusal(
        _SIGNS, "held", f"the knob gives way and does not turn at {1e3 * torque_nm:.0f} mN m: take "
        "your hand off it. Otherwise the brake is stuck on, or the motor is far too weak",
        reached_rad=reached,
    )  # fmt: skip


def _refuse_pulled(turned_at_nm: list[float]) -> None:
    """Refuse a knob that turns one way only, or far more easily than the other."""
    low_nm, high_nm = min(turned_at_nm), max(turned_at_nm)
    begins = f"the knob begins to turn at {1e3 * low_nm:.1f} mN m one way and"
    if len(turned_at_nm) == 1:
        raise Refusal(
            _SIGNS, "one_way", f"{begins} not at all the other: something stops it there, or the "
            "encoder has failed", torques_nm=turned_at_nm,
        )  # fmt: skip
    if high_nm > 4.0 * low_nm + 2e-3:
        raise Refusal(
            _SIGNS, "pulled", f"{begins} at {1e3 * high_nm:.1f} the other: something pulls at it; "
            "turn the axis upright, take off weights and cables", torques_nm=turned_at_nm,
        )  # fmt: skip
