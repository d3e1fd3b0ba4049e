"""The whole calibration: which steps in which order, and what becomes of their results."""

from __future__ import annotations

import dataclasses
import datetime
import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from torsio import checks, perception
from torsio.calibration.brake import Brake, estimate_brake, hold_and_let_go, slip
from torsio.calibration.brake_curve import BrakeCurve
from torsio.calibration.circuit import MEASURED_OF_BOARD, Circuit, CircuitSteps
from torsio.calibration.cogging import Cogging
from torsio.calibration.free import (
    FAST_RAD_S,
    FREE_LIMIT_RAD_S,
    SLOW_S,
    Free,
    estimate_free,
    find_signs,
    spin,
    through_shaft,
)
from torsio.calibration.left_out import (
    LEFT_OUT,
    LEFT_OUT_BY_DRIVE,
    honest,
    widened,
    with_left_out,
)
from torsio.calibration.play import Player, Recording
from torsio.calibration.quantity import Fit, Quantity, Refusal
from torsio.calibration.shaft import Shaft, estimate_shaft, hold_and_push
from torsio.config import ActuatorConfig, BoardConfig, CalibrationConfig, Law, ShaftConfig
from torsio.errors import Error, InvalidArgument
from torsio.knob import Knob

__all__ = ["STEPS", "Calibration", "apply", "calibrate"]

STEPS = ("signs", "friction and inertia", "shaft", "brake")
"""In their order, as `progress` names them."""

# What a device of this kind may be at most from what its configuration says: beyond it is a fault.
_PLAUSIBLE = 5.0

# Of the friction that is certain: bearings wear in.
_ASSISTED = 0.6

# Of all viscous friction the brake's side has from nothing up to so much, each as likely. Knob and
# brake turn alike in all that is played, so nothing tells them apart.
_BRAKE_VISCOUS = 0.25


@dataclass(frozen=True)
class Calibration:
    """What a knob was found to be.

    Attributes
    ----------
    quantities
        By name; all torques as parts of the motor's, with the torque constant that is proposed, or
        else the one that the device believes: they are as true as that.
    actuator, shaft
        The configurations that are proposed; nothing was saved.
    law, free_assist_nm
        What is proposed of the control: the law that uses all of these values, and of the friction
        what is certain; after a quick look what the knob has.
    known
        How well their values are known, with date and conditions, for the device to keep.
    cogging
        Over the angle from the device's zero; None after a quick look.
    curve
        Twist in rad and torque in N m of the shaft's corners.
    brake_curve
        The brake's torque over its command, up and down; None after a quick look.
    seconds
        Of the knob's time.
    conditions
        Serial number, board, firmware, rate, date, whether the motor's current is measured.
    board
        The same, of the motor; it takes effect when the knob starts the next time, and torques are
        these from then on. None: nothing of it was measured.
    """

    quantities: dict[str, Quantity]
    actuator: ActuatorConfig
    shaft: ShaftConfig
    law: Law
    free_assist_nm: float
    known: CalibrationConfig
    cogging: Cogging | None
    curve: tuple[tuple[float, float], ...]
    brake_curve: BrakeCurve | None
    seconds: float
    conditions: dict[str, Any]
    fits: tuple[Fit, ...] = field(repr=False)
    board: BoardConfig | None = None

    def as_dict(self) -> dict[str, Any]:
        """Give all but the pictures, as JSON has it."""
        return {
            "quantities": {
                name: {
                    "value": of.value,
                    "standard_uncertainty": of.standard_uncertainty,
                    "meaning": of.meaning,
                    "jnds": perception.jnds_of(name, of.value, of.standard_uncertainty),
                }
                for name, of in self.quantities.items()
            },
            "actuator": dataclasses.asdict(self.actuator),
            "shaft": dataclasses.asdict(self.shaft),
            "board": None if self.board is None else dataclasses.asdict(self.board),
            "law": self.law,
            "free_assist_nm": self.free_assist_nm,
            "known": dataclasses.asdict(self.known),
            "cogging": None if self.cogging is None else self.cogging.as_dict(),
            "curve": [list(corner) for corner in self.curve],
            "brake_curve": None
            if self.brake_curve is None
            else self.brake_curve.as_dict(self.conditions["brake_torque_constant_nm_per_a"]),
            "seconds": self.seconds,
            "conditions": self.conditions,
        }


def calibrate(
    knob: Knob,
    *,
    quick: bool = False,
    ambient_c: float | None = None,
    supply_v: float | None = None,
    progress: Callable[[str], object] | None = None,
) -> Calibration:
    """Measure a knob that nobody touches; it turns by itself, some dozen turns both ways.

    Changes nothing: the configuration is as before, and `Calibration.actuator` only proposes.

    Parameters
    ----------
    quick
        Ten seconds, for a comparison with what was found before: no circuit, no cogging, no swings,
        no brake.
    ambient_c
        How warm it is, for the record; above -273 degrees.
    supply_v
        What a meter says of the motor's supply, for the electrical steps, and proposed if it is
        another than what is configured; 3 to 60. None: nobody has measured it, and a torque
        constant that may be right stays as it is.
    progress
        Called with the name of each step as it begins; one of `STEPS` or `ELECTRIC_STEPS`.

    Raises
    ------
    Refusal
        Names the step and the likely fault; the knob is disarmed.
    Refused
        The knob is in use, or has a fault.
    InvalidArgument
        Of `supply_v` too, where no electrical step would use it.
    """
    if ambient_c is not None:
        checks.number("ambient_c", ambient_c, -273.0, 700.0)
    if supply_v is not None:
        checks.number("supply_v", supply_v, 3.0, 60.0)
        if quick or not knob.motor_current().measured:
            why = "a quick look leaves them out" if quick else "this device measures no current"
            raise InvalidArgument(f"supply_v is for the electrical steps, and {why}")
    say = progress or (lambda _: None)
    actuator, control = knob.actuator_config(), knob.control_config()
    motor_nm = min(actuator.motor_torque_max_nm, control.motor_torque_cap_nm)
    brake_nm = 0.95 * min(actuator.brake_torque_max_nm, control.brake_torque_cap_nm)
    if 0.0 < control.speed_limit_rad_s < FREE_LIMIT_RAD_S:
        raise Refusal(
            STEPS[0], "limited", f"it turns the knob at {FAST_RAD_S:g} rad/s, and the speed limit "
            f"is {control.speed_limit_rad_s:g}: torsio config set "
            f"speed_limit_rad_s={FREE_LIMIT_RAD_S:g}, and back when it is done",
        )  # fmt: skip
    if knob.info.board != "emulated" and not knob.board_config().confirmed:
        raise Refusal(
            STEPS[0], "unconfirmed", "nobody has confirmed the parts of this board, so it gives "
            f"{1e3 * knob.limits().motor_torque_max_nm:.3g} mN m at most: set what motor, brake "
            "and encoder it has (docs/hardware.md, first power), then torsio config set "
            "confirmed=on",
        )  # fmt: skip
    demagnetised = knob.board_config().brake_inductance_h > 0.0
    with Player.playing(knob) as player:
        most: dict[str, Any] = {"motor_nm": motor_nm, "brake_nm": brake_nm}
        circuit = electric = None
        if not quick:
            electric = CircuitSteps.of(knob, player, say, supply_v=supply_v)
        if electric is None:
            player.believe_configured()
        else:
            electric.look(motor_nm)
        say(STEPS[0])
        # All steps shall find the brake as it is left, whether it was used before or not.
        hold_and_let_go(player, brake_nm, STEPS[0])
        find_signs(player, motor_nm, actuator.knob_inertia_kg_m2)
        if electric is not None:
            electric.turn(motor_nm)
        say(STEPS[1])
        slow_s = 0.8 if quick else SLOW_S
        turns = spin(player, motor_nm, slow_s=slow_s)
        free = estimate_free(turns, slow_s=slow_s)
        if electric is not None:
            circuit = electric.hold(**most)
            turns = player.known(turns)
            free = estimate_free(turns, slow_s=slow_s)
        _check_plausible(free, actuator)
        say(STEPS[2])
        most |= {"coulomb_nm": free.coulomb.value}
        held = hold_and_push(player, **most, quick=quick)
        shaft = estimate_shaft(*held, free.cogging.torque_nm, free.inertia.value)
        free = _through(shaft, free, turns)
        brake = stairs = None
        if not quick:
            say(STEPS[3])
            hold_and_let_go(player, brake_nm)  # what the shaft was held with dies away
            stairs = slip(player, **most)
            brake = _brake(stairs, free, shaft, demagnetised=demagnetised)
        seconds = player.seconds
    parts = _Parts(free, shaft, brake)
    found, curve = _quantities(parts), None
    if brake is not None:
        curve = brake.curve.with_left_out(*LEFT_OUT["brake_curve"])
    if player.drive is not None:
        found = {name: with_left_out(of, LEFT_OUT_BY_DRIVE) for name, of in found.items()}
        if curve is not None:
            curve = curve.with_left_out(*LEFT_OUT_BY_DRIVE["brake_curve"])
        for drive in player.drive.others():
            logs = [log.driven_by(drive) for log in (turns, *held)]
            through = None if stairs is None else stairs.driven_by(drive)
            # What is refused under it is refused: nobody would know how far it is from the truth.
            other = _parts_of(logs, through, slow_s, demagnetised=demagnetised)
            found = widened(found, _quantities(other))
            if curve is not None and other.brake is not None:
                curve = curve.widened(other.brake.curve)
    if circuit is not None:
        found = {of.name: of for of in circuit.quantities} | {
            name: circuit.scaled(of) for name, of in found.items()
        }
        if curve is not None:
            curve = curve.with_left_out(circuit.torque_share, 0.0)
    return _put_together(knob, actuator, parts, (found, curve), circuit, seconds, ambient_c)


@dataclass(frozen=True)
class _Parts:
    """What the steps found, one by one."""

    free: Free
    shaft: Shaft
    brake: Brake | None


def _brake(stairs: Recording, free: Free, shaft: Shaft, *, demagnetised: bool) -> Brake:
    return estimate_brake(
        stairs,
        free.cogging.torque_nm,
        inertia_kg_m2=free.inertia.value,
        viscous_nm_s_per_rad=free.viscous.value,
        coulomb=honest(free.coulomb),
        flexible_s2=_flexible_s2(free, shaft),
        demagnetised=demagnetised,
    )


def _parts_of(
    logs: Sequence[Recording], stairs: Recording | None, slow_s: float, *, demagnetised: bool
) -> _Parts:
    """Estimate all from recordings: of the turns, the pulls and the steps, and of the brake."""
    turns, pulls, steps = logs
    free = estimate_free(turns, slow_s=slow_s)
    shaft = estimate_shaft(pulls, steps, free.cogging.torque_nm, free.inertia.value)
    free = _through(shaft, free, turns)
    if stairs is None:
        return _Parts(free, shaft, None)
    return _Parts(free, shaft, _brake(stairs, free, shaft, demagnetised=demagnetised))


def _check_plausible(free: Free, actuator: ActuatorConfig) -> None:
    knob_alone = actuator.knob_inertia_kg_m2
    if not knob_alone / _PLAUSIBLE < free.inertia.value < 2.0 * _PLAUSIBLE * knob_alone:
        raise Refusal(
            STEPS[1], "inertia", f"all that turns has {free.inertia.value:.2e} kg m^2, and "
            f"knob_inertia_kg_m2 is {knob_alone:.2e}: the motor's torque constant or the encoder's "
            "counts are wrong, or something heavy is on the knob; else correct the configuration",
        )  # fmt: skip


def _knob_inertia(free: Free, shaft: Shaft) -> float:
    return 0.6 * free.inertia.value if shaft.knob_inertia is None else shaft.knob_inertia.value


def _flexible_s2(free: Free, shaft: Shaft) -> float:
    return max(free.inertia.value - _knob_inertia(free, shaft), 0.0) / shaft.stiffness.value


def _through(shaft: Shaft, free: Free, turns: Recording) -> Free:
    return through_shaft(free, turns, _flexible_s2(free, shaft), _knob_inertia(free, shaft))


def apply(knob: Knob, calibration: Calibration) -> None:
    """Configure a disarmed knob as proposed, or change nothing; `Knob.save` keeps that.

    What is proposed for the board takes effect when the knob starts the next time.
    """
    board, control = knob.board_config(), knob.control_config()
    before = (knob.actuator_config(), knob.shaft_config(), board, control)
    # Its caps, limits and pins may be others by now.
    law = replace(control, law=calibration.law, free_assist_nm=calibration.free_assist_nm)
    motor = board
    if calibration.board is not None:
        measured = dataclasses.asdict(calibration.board)
        motor = replace(board, **{name: measured[name] for name in MEASURED_OF_BOARD})
    proposed = (calibration.actuator, calibration.shaft, motor, law)
    known = knob.calibration_config()
    try:
        # What is known comes last: it is about the values that the device has by then.
        for config in (*proposed, calibration.known):
            knob.configure(config)
    except Error:
        for config in (*before, known):
            with suppress(Error):
                knob.configure(config)
        raise


def _sigmas_of_knee(quantities: dict[str, Quantity]) -> dict[str, Any]:
    """Give the uncertainties of a knee, if one was found."""
    sigmas = {}
    if "knee_rad" in quantities:
        sigmas["sigma_knee_1_rad"] = quantities["knee_rad"].standard_uncertainty
    stiffness, factor = quantities["stiffness_nm_per_rad"], quantities.get("stiffness_factor")
    if factor is not None:
        sigmas["sigma_knee_1_nm_per_rad"] = math.hypot(
            factor.value * stiffness.standard_uncertainty,
            stiffness.value * factor.standard_uncertainty,
        )
    return sigmas


def _bent(shaft: Shaft, configured: ShaftConfig, sigmas: dict[str, Any]) -> ShaftConfig:
    if shaft.knee is None or shaft.factor is None:
        return ShaftConfig()
    found = ShaftConfig(
        knee_1_rad=shaft.knee.value,
        knee_1_nm_per_rad=shaft.stiffness.value * shaft.factor.value,
    )
    is_noise = all(
        abs(getattr(found, name) - getattr(configured, name)) <= 1.96 * sigmas[f"sigma_{name}"]
        for name in ("knee_1_rad", "knee_1_nm_per_rad")
    )
    return configured if is_noise else found


def _knob_viscous(viscous: Quantity) -> Quantity:
    """Give the viscous friction of the knob's side, of that of all that turns."""
    share = 1.0 - 0.5 * _BRAKE_VISCOUS
    return Quantity(
        "knob_viscous_nm_s_per_rad",
        share * viscous.value,
        math.hypot(
            share * viscous.standard_uncertainty, _BRAKE_VISCOUS / math.sqrt(12.0) * viscous.value
        ),
        f"of the knob's side, if the brake's has {100 * _BRAKE_VISCOUS:.0f} % of it at most",
    )


def _quantities(parts: _Parts) -> dict[str, Quantity]:
    free, shaft, brake = parts.free, parts.shaft, parts.brake
    inertia, knob_coulomb = honest(free.inertia), honest(shaft.knob_coulomb)
    found = [
        *(inertia, free.coulomb, free.viscous, free.offset),
        _knob_viscous(honest(free.viscous)),
        *(shaft.stiffness, shaft.backlash, knob_coulomb),
        *(of for of in (shaft.knee, shaft.factor, shaft.damping) if of is not None),
    ]
    if shaft.knob_inertia is not None:
        knob_inertia = honest(shaft.knob_inertia)
        found += [
            knob_inertia,
            inertia.less("brake_inertia_kg_m2", knob_inertia, "of pulleys and brake"),
        ]
    if brake is not None:
        held_off = honest(free.coulomb).less("", knob_coulomb, "")
        found.append(
            held_off.less(
                "brake_drag_nm", brake.left, "what the brake holds with no current, its loop aside"
            )
        )
        found += [free.amplitude, brake.gain, brake.hysteresis, brake.rise, brake.release]
    done = {inertia.name, knob_coulomb.name, "knob_inertia_kg_m2"}
    return {of.name: of if of.name in done else honest(of) for of in found}


_PROPOSED_FROM: Final = {
    "spring_stiffness_nm_per_rad": "stiffness_nm_per_rad",
    "knob_coulomb_nm": "knob_coulomb_nm",
    "knob_viscous_nm_s_per_rad": "knob_viscous_nm_s_per_rad",
    "knob_inertia_kg_m2": "knob_inertia_kg_m2",
    "brake_inertia_kg_m2": "brake_inertia_kg_m2",
    "brake_time_constant_s": "rise_s",
    "brake_release_time_constant_s": "release_s",
    "brake_hysteresis_nm": "hysteresis_nm",
    "brake_drag_nm": "brake_drag_nm",
}


def _proposed(
    actuator: ActuatorConfig, quantities: dict[str, Quantity]
) -> tuple[dict[str, float], dict[str, Any]]:
    """Give what was found, but for changes that are noise, and the uncertainties of that.

    What is configured stays if it may be true; what may as well be nothing is none.
    """
    values: dict[str, float] = {}
    sigmas: dict[str, Any] = {}
    for name, of in _PROPOSED_FROM.items():
        if of not in quantities:
            continue
        found = quantities[of]
        configured, best = float(getattr(actuator, name)), max(found.value, 0.0)
        values[name] = next((one for one in (configured, 0.0) if found.holds(one)), best)
        sigmas[f"sigma_{name}"] = math.hypot(found.standard_uncertainty, values[name] - best)
    rise, release = "brake_time_constant_s", "brake_release_time_constant_s"
    lag_s = float(getattr(actuator, rise))
    # Without a value of its own it lets go as it takes hold.
    if (
        getattr(actuator, release) == 0.0
        and values.get(rise) == lag_s
        and quantities["release_s"].holds(lag_s)
    ):
        values[release], sigmas[f"sigma_{release}"] = 0.0, 0.0
    return values, sigmas


def _certain_assist_nm(quantities: dict[str, Quantity], configured_nm: float) -> float:
    """Give what may be taken off the friction: that is there for certain, and wears off.

    What the brake's loop leaves is not: a knob that has not braked yet is without it. What is
    configured stays if noise makes the difference.
    """
    # Of the sum nobody knows less than of the drag, which is all the friction less the knob's.
    certain_nm = quantities["knob_coulomb_nm"].value + quantities["brake_drag_nm"].interval[0]
    certain_nm = _ASSISTED * max(certain_nm, 0.0)
    noise_nm = _ASSISTED * 1.96 * quantities["brake_drag_nm"].standard_uncertainty
    return configured_nm if abs(configured_nm - certain_nm) <= noise_nm else certain_nm


def _mapped(free: Free, circuit: Circuit | None) -> Cogging:
    """Give the cogging with what its waves cannot know of."""
    left_out, _ = LEFT_OUT["cogging_nm"]
    constant = 0.0 if circuit is None else circuit.torque_share
    return free.cogging.widened(math.hypot(left_out, constant))


def _put_together(
    knob: Knob,
    actuator: ActuatorConfig,
    parts: _Parts,
    found: tuple[dict[str, Quantity], BrakeCurve | None],
    circuit: Circuit | None,
    seconds: float,
    ambient_c: float | None,
) -> Calibration:
    free, shaft, brake = parts.free, parts.shaft, parts.brake
    quantities, brake_curve = found
    values, sigmas = _proposed(actuator, quantities)
    sigmas |= _sigmas_of_knee(quantities)
    info, board = knob.info, knob.board_config()
    if board.brake_inductance_h > 0.0:
        # The bridge drives the coil as slowly as this says: it would be slower each time.
        values.pop("brake_time_constant_s", None)
        sigmas["sigma_brake_time_constant_s"] = 0.0
    proposed = replace(actuator, **values)  # type: ignore[arg-type]
    now = datetime.datetime.now(datetime.timezone.utc)
    # Ten seconds may miss a knee, and are not enough to know the brake: what was known stays.
    keeps_shaft = brake is None and shaft.knee is None
    configured = knob.shaft_config()
    bent = configured if keeps_shaft else _bent(shaft, configured, sigmas)
    straight = {} if keeps_shaft else {"sigma_knee_1_rad": 0.0, "sigma_knee_1_nm_per_rad": 0.0}
    before, control = knob.calibration_config(), knob.control_config()
    known = replace(
        before,
        values_are=before.values_are if brake is None else "measured",
        calibrated_unix_s=int(now.timestamp()),
        ambient_k=0.0 if ambient_c is None else ambient_c + 273.15,
        calibrated_rate_hz=info.control_rate_hz,
        **(straight | sigmas | ({} if circuit is None else circuit.sigmas())),
    )
    return Calibration(
        quantities,
        proposed,
        bent,
        control.law if brake is None else "calibrated",
        control.free_assist_nm
        if brake is None
        else _certain_assist_nm(quantities, control.free_assist_nm),
        known,
        None if brake is None else _mapped(free, circuit),
        tuple((float(twist), float(torque)) for twist, torque in np.asarray(shaft.curve)),
        brake_curve,
        seconds,
        {
            "serial": info.serial,
            "board": info.board,
            "firmware_version": info.firmware_version,
            "control_rate_hz": info.control_rate_hz,
            "counts_per_rev": info.counts_per_rev,
            "brake_torque_constant_nm_per_a": board.brake_torque_constant_nm_per_a,
            "ambient_c": ambient_c,
            "current_measured": knob.motor_current().measured,
            "date": now.isoformat(timespec="seconds"),
        },
        (
            *(circuit.motor.fits if circuit is not None else ()),
            *(*free.fits, *shaft.fits, *(brake.fits if brake is not None else ())),
        ),
        None if circuit is None else circuit.board,
    )
