"""The whole calibration: which steps in which order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from torsio.calibration.brake import Brake, estimate_brake, hold_and_let_go, slip
from torsio.calibration.brake_curve import BrakeCurve
from torsio.calibration.circuit import Circuit, CircuitSteps
from torsio.calibration.drive import Drive
from torsio.calibration.found import Parts, quantities_of
from torsio.calibration.free import (
    FAST_RAD_S,
    FREE_LIMIT_RAD_S,
    SLOW_S,
    Free,
    estimate_free,
    spin,
    through_shaft,
)
from torsio.calibration.left_out import (
    LEFT_OUT,
    LEFT_OUT_BY_DRIVE,
    LEFT_OUT_BY_SIMPLE_LOOP,
    by_tick,
    honest,
    widened,
    with_left_out,
)
from torsio.calibration.play import Player, Run
from torsio.calibration.proposal import Calibration, put_together
from torsio.calibration.quantity import Quantity, Refusal
from torsio.calibration.shaft import Shaft, estimate_shaft, hold_and_push, pull_of
from torsio.calibration.signs import find_signs
from torsio.common import checks
from torsio.common.emulated import moves_parts
from torsio.errors import InvalidArgument
from torsio.knob import Knob, need_knob
from torsio.printed.config import ActuatorConfig, ControlConfig

__all__ = ["STEPS", "calibrate"]

STEPS = ("signs", "friction and inertia", "shaft", "brake")
"""In their order, as `progress` names them."""

# Largest factor between a device and its configuration; beyond it is a fault.
_PLAUSIBLE = 5.0
# Share of a wave of the cogging beyond which the slow turns do not tell its size.
_SEEN_THROUGH_SHAFT = 0.6
_LEAST_WAVE_NM = 2e-4  # smaller ones may be noise, and widen the intervals alone
# Share of the brake's torque that calibration uses.
_BRAKE_SHARE = 0.95
# Reasons that too small a torque may give.
_OF_WEAKNESS = ("still", "inertia", "rigid")


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
        13 seconds, to compare with earlier values: no circuit, no cogging, no swings, no brake.
    ambient_c
        Ambient temperature, for the record; above -273 degrees.
    supply_v
        The motor's supply, as a meter shows it, for the electrical steps; 3 to 60. It is proposed
        if it differs from the configured one. None: not measured; a torque constant that
        may be right then stays as it is.
    progress
        Called with the name of each step as it begins; one of `STEPS` or `ELECTRIC_STEPS`.

    Raises
    ------
    Refusal
        Names the step and the likely fault; the knob is disarmed.
    Refused
        The knob is in use, or has a fault.
    InvalidArgument
        Also if no electrical step would use `supply_v`.
    """
    need_knob(knob)
    if progress is not None:
        checks.function("progress", progress)
    if ambient_c is not None:
        checks.number("ambient_c", ambient_c, -273.0, 700.0)
    if supply_v is not None:
        _check_supply(knob, supply_v, quick=quick)
    actuator, control = knob.actuator_config(), knob.control_config()
    _check_ready(knob, control.speed_limit_rad_s)
    plan = _Plan(
        actuator=actuator,
        motor_nm=min(actuator.motor_torque_max_nm, control.motor_torque_cap_nm),
        brake_nm=_BRAKE_SHARE * min(actuator.brake_torque_max_nm, control.brake_torque_cap_nm),
        demagnetised=knob.board_config().brake_inductance_h > 0.0,
        quick=quick,
        supply_v=supply_v,
    )
    try:
        with Player.playing(knob) as player:
            measured = _measure(knob, player, plan, progress or (lambda _: None))
    except Refusal as error:
        raise _with_cap(error, plan, control) from None
    found = _with_doubts(measured, plan, player.drive)
    return put_together(
        knob, actuator, measured.parts, found, measured.circuit, measured.seconds, ambient_c
    )


def _check_supply(knob: Knob, supply_v: float, *, quick: bool) -> None:
    checks.number("supply_v", supply_v, 3.0, 60.0)
    if quick or not knob.motor_current().measured:
        why = "a quick look leaves them out" if quick else "this device measures no current"
        raise InvalidArgument(f"supply_v is for the electrical steps, and {why}")


def _check_ready(knob: Knob, speed_limit_rad_s: float) -> None:
    """Refuse a knob that its own limits would stop on the way."""
    if 0.0 < speed_limit_rad_s < FREE_LIMIT_RAD_S:
        raise Refusal(
            STEPS[0], "limited", f"it turns the knob at {FAST_RAD_S:g} rad/s, and the speed limit "
            f"is {speed_limit_rad_s:g}: torsio config set "
            f"speed_limit_rad_s={FREE_LIMIT_RAD_S:g}, and set it back afterwards",
        )  # fmt: skip
    if moves_parts(knob.info.board) and not knob.board_config().confirmed:
        raise Refusal(
            STEPS[0], "unconfirmed", "nobody has confirmed the parts of this board, so it gives "
            f"{1e3 * knob.limits().motor_torque_max_nm:.3g} mN m at most. Set the values of motor, "
            "brake and encoder (docs/how-to/first-power.md), then torsio config set "
            "confirmed=on",
        )  # fmt: skip


@dataclass(frozen=True)
class _Plan:
    """Everything that the steps use, and the list of steps."""

    actuator: ActuatorConfig
    motor_nm: float
    brake_nm: float
    demagnetised: bool
    quick: bool
    supply_v: float | None

    @property
    def slow_s(self) -> float:
        """Duration of the slow turns."""
        return 0.8 if self.quick else SLOW_S


def _with_cap(error: Refusal, plan: _Plan, control: ControlConfig) -> Refusal:
    """Name the cap that kept the torque small, where that may be why; else give the refusal."""
    most = plan.actuator
    most_pull_nm = pull_of(plan.motor_nm, _BRAKE_SHARE * most.brake_torque_max_nm)
    capped = plan.motor_nm < most.motor_torque_max_nm
    name, cap_nm, max_nm = "motor_torque_cap_nm", plan.motor_nm, most.motor_torque_max_nm
    if error.reason == "rigid" and pull_of(plan.motor_nm, plan.brake_nm) < most_pull_nm:
        capped, name = True, "brake_torque_cap_nm"
        cap_nm, max_nm = control.brake_torque_cap_nm, most.brake_torque_max_nm
    if error.reason not in _OF_WEAKNESS or not capped:
        return error
    sentence = (
        f"{name} is {cap_nm:g}, of {max_nm:g}: raise it step by step, and calibrate again. "
        f"Otherwise {str(error).removeprefix(f'{error.step}: ')}"
    )
    return Refusal(error.step, "limited", sentence, **error.facts)


@dataclass(frozen=True)
class _Measured:
    """The runs of a calibration, and what they gave at first."""

    turns: Run
    held: tuple[Run, Run]
    stairs: Run | None
    parts: Parts
    circuit: Circuit | None
    seconds: float


def _measure(knob: Knob, player: Player, plan: _Plan, say: Callable[[str], object]) -> _Measured:
    """Play all steps in their order."""
    circuit = electric = None
    if not plan.quick:
        electric = CircuitSteps.of(knob, player, say, supply_v=plan.supply_v)
    if electric is None:
        player.believe_configured()
    else:
        electric.look(plan.motor_nm)
    say(STEPS[0])
    # All steps shall find the brake as it is left, whether it was used before or not.
    hold_and_let_go(player, plan.brake_nm, STEPS[0])
    find_signs(player, plan.motor_nm, plan.actuator.knob_inertia_kg_m2)
    if electric is not None:
        electric.turn(plan.motor_nm)
    say(STEPS[1])
    turns = spin(player, plan.motor_nm, slow_s=plan.slow_s)
    free = estimate_free(turns, slow_s=plan.slow_s)
    most: dict[str, Any] = {"motor_nm": plan.motor_nm, "brake_nm": plan.brake_nm}
    if electric is not None:
        circuit = electric.hold(**most)
        turns = player.known(turns)
        free = estimate_free(turns, slow_s=plan.slow_s)
    _check_plausible(free, plan.actuator)
    say(STEPS[2])
    most |= {"coulomb_nm": free.coulomb.value}
    held = hold_and_push(player, **most, quick=plan.quick)
    free, shaft = _shaft(free, turns, held)
    if not plan.quick:
        _check_cogging(free, shaft)
    brake = stairs = None
    if not plan.quick:
        say(STEPS[3])
        hold_and_let_go(player, plan.brake_nm)  # relaxes the shaft
        stairs = slip(player, **most)
        brake = _brake(stairs, free, shaft, demagnetised=plan.demagnetised)
    return _Measured(turns, held, stairs, Parts(free, shaft, brake), circuit, player.seconds)


_Found = tuple[dict[str, Quantity], BrakeCurve | None]


def _with_doubts(measured: _Measured, plan: _Plan, drive: Drive | None) -> _Found:
    """Give the quantities and the brake's curve with all that the models leave out."""
    brake = measured.parts.brake
    quantities = quantities_of(measured.parts, drive)
    found = {name: by_tick(of, measured.turns.tick_s) for name, of in quantities.items()}
    curve = None if brake is None else brake.curve.with_left_out(*LEFT_OUT["brake_curve"])
    if drive is not None:
        found, curve = _with_drives(found, curve, measured, plan, drive)
    circuit = measured.circuit
    if circuit is not None:
        found = {of.name: of for of in circuit.quantities} | {
            name: circuit.scaled(of) for name, of in found.items()
        }
        if curve is not None:
            curve = curve.with_left_out(circuit.torque_share, 0.0)
    return found, curve


def _with_drives(
    found: dict[str, Quantity],
    curve: BrakeCurve | None,
    measured: _Measured,
    plan: _Plan,
    drive: Drive,
) -> _Found:
    """Widen the uncertainties by the errors of this drive and of other drives."""
    found = {name: with_left_out(of, LEFT_OUT_BY_DRIVE) for name, of in found.items()}
    if not drive.predicts:
        found = {name: with_left_out(of, LEFT_OUT_BY_SIMPLE_LOOP) for name, of in found.items()}
    if curve is not None:
        curve = curve.with_left_out(*LEFT_OUT_BY_DRIVE["brake_curve"])
    for one in drive.others():
        logs = [log.driven_by(one) for log in (measured.turns, *measured.held)]
        through = None if measured.stairs is None else measured.stairs.driven_by(one)
        # A refusal at the bound stands: nobody would know how far the value is from the truth.
        other = _parts_of(logs, through, plan.slow_s, demagnetised=plan.demagnetised)
        found = widened(found, quantities_of(other, one))
        if curve is not None and other.brake is not None:
            curve = curve.widened(other.brake.curve)
    return found, curve


def _brake(stairs: Run, free: Free, shaft: Shaft, *, demagnetised: bool) -> Brake:
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
    logs: Sequence[Run], stairs: Run | None, slow_s: float, *, demagnetised: bool
) -> Parts:
    """Estimate all from runs: of the turns, the pulls and the steps, and of the brake."""
    turns, pulls, steps = logs
    free, shaft = _shaft(estimate_free(turns, slow_s=slow_s), turns, (pulls, steps))
    if stairs is None:
        return Parts(free, shaft, None)
    return Parts(free, shaft, _brake(stairs, free, shaft, demagnetised=demagnetised))


def _check_plausible(free: Free, actuator: ActuatorConfig) -> None:
    knob_alone = actuator.knob_inertia_kg_m2
    if not knob_alone / _PLAUSIBLE < free.inertia.value < 2.0 * _PLAUSIBLE * knob_alone:
        raise Refusal(
            STEPS[1], "inertia", f"all that turns has {free.inertia.value:.2e} kg m^2, but "
            f"knob_inertia_kg_m2 is {knob_alone:.2e}: the motor's torque constant or the encoder's "
            "counts are wrong, or something heavy is on the knob. Otherwise correct the "
            "configuration",
        )  # fmt: skip


def _check_cogging(free: Free, shaft: Shaft) -> None:
    is_wave = free.amplitude.value > _LEAST_WAVE_NM
    is_hidden = is_wave and free.through_shaft > _SEEN_THROUGH_SHAFT
    if is_hidden or shaft.shape_nm > _LEAST_WAVE_NM:
        raise Refusal(
            STEPS[2], "unexplained", "the turns do not tell how large the motor's cogging is: it "
            "cogs so often in a turn that the brake's side swings with it, or something rubs or "
            f"slips. The slow pulls leave a wave of {1e3 * shaft.shape_nm:.1f} mN m",
            residual_nm=shaft.shape_nm,
        )  # fmt: skip


def _knob_inertia(free: Free, shaft: Shaft) -> float:
    return 0.6 * free.inertia.value if shaft.knob_inertia is None else shaft.knob_inertia.value


def _flexible_s2(free: Free, shaft: Shaft) -> float:
    return max(free.inertia.value - _knob_inertia(free, shaft), 0.0) / shaft.stiffness.value


def _shaft(free: Free, turns: Run, held: tuple[Run, Run]) -> tuple[Free, Shaft]:
    """Estimate the shaft, then the cogging through it, and the shaft with that cogging."""
    shaft = estimate_shaft(*held, free.cogging.torque_nm, free.inertia.value)
    if not free.cogging.periods_per_rev:
        return free, shaft
    free = through_shaft(free, turns, _flexible_s2(free, shaft), _knob_inertia(free, shaft))
    return free, estimate_shaft(*held, free.cogging.torque_nm, free.inertia.value)
