"""The whole calibration: which steps in which order."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from torsio.calibration.circuit import CircuitSteps
from torsio.calibration.doubts import with_doubts
from torsio.calibration.drive import Drive
from torsio.calibration.found import Findings, Runs
from torsio.calibration.free import FAST_RAD_S, FREE_LIMIT_RAD_S
from torsio.calibration.play import Player
from torsio.calibration.proposal import Calibration, put_together
from torsio.calibration.quantity import Refusal
from torsio.calibration.shaft import pull_of
from torsio.calibration.steps import STEPS, Plan, Step, steps_of
from torsio.common import checks
from torsio.common.emulated import moves_parts
from torsio.errors import InvalidArgument
from torsio.knob import Knob, need_knob
from torsio.printed.config import ControlConfig

__all__ = ["STEPS", "calibrate"]

# Share of the brake's torque that calibration uses.
_BRAKE_SHARE = 0.95
# Reasons that too small a torque may give.
_OF_WEAKNESS = ("still", "inertia", "rigid")

# What estimates from runs, and the runs, by what it finds.
_Played = dict[str, tuple[Callable[[Runs, Findings], Findings], Runs]]


def calibrate(
    knob: Knob,
    *,
    drift: bool = False,
    ambient_c: float | None = None,
    supply_v: float | None = None,
    progress: Callable[[str], object] | None = None,
) -> Calibration:
    """Measure a knob that nobody touches; it turns by itself, some dozen turns both ways.

    Changes nothing: the configuration is as before, and `Calibration.actuator` only proposes.

    Parameters
    ----------
    drift
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
        _check_supply(knob, supply_v, drift=drift)
    actuator, control = knob.actuator_config(), knob.control_config()
    _check_ready(knob, control.speed_limit_rad_s)
    plan = Plan(
        actuator=actuator,
        motor_nm=min(actuator.motor_torque_max_nm, control.motor_torque_cap_nm),
        brake_nm=_BRAKE_SHARE * min(actuator.brake_torque_max_nm, control.brake_torque_cap_nm),
        demagnetised=knob.board_config().brake_inductance_h > 0.0,
        drift=drift,
    )
    electric = None
    try:
        with Player.playing(knob) as player:
            if not drift and player.motor_current().measured:
                most = {"motor_nm": plan.motor_nm, "brake_nm": plan.brake_nm}
                electric = CircuitSteps(knob, **most, supply_v=supply_v)
            else:
                player.believe_configured()
            found, played = _play(steps_of(plan, electric), player, progress or (lambda _: None))
            seconds = player.seconds
    except Refusal as error:
        raise _with_cap(error, plan, control) from None
    # A refusal at the bound stands: nobody would know how far the value is from the truth.
    drives = () if found["drive"] is None else found["drive"].others()
    others = [_under(drive, played) for drive in drives]
    doubted = with_doubts(found, tick_s=1.0 / knob.info.control_rate_hz, others=others)
    return put_together(knob, actuator, found, doubted, seconds, ambient_c)


def _play(
    steps: Sequence[Step], player: Player, say: Callable[[str], object]
) -> tuple[Findings, _Played]:
    """Play all steps in their order, each with what those before it have found."""
    found, played = Findings(drive=player.drive), {}
    for step in steps:
        if step.name:
            say(step.name)
        runs = step.play(player, found)
        found = step.estimate(runs, found)
        step.check(found)
        if step.finds:
            played[step.finds] = step.estimate, runs
        if "circuit" in found:
            player.torque_scale, player.drive = found["circuit"].torque_scale, found["drive"]
    return found, played


def _under(drive: Drive, played: _Played) -> Findings:
    """Estimate all again from the runs as they are under another drive."""
    found = Findings(drive=drive)
    for estimate, runs in played.values():
        found = estimate(tuple(run.driven_by(drive) for run in runs), found)
    return found


def _check_supply(knob: Knob, supply_v: float, *, drift: bool) -> None:
    checks.number("supply_v", supply_v, 3.0, 60.0)
    if drift or not knob.motor_current().measured:
        why = "a look for drift leaves them out" if drift else "this device measures no current"
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


def _with_cap(error: Refusal, plan: Plan, control: ControlConfig) -> Refusal:
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
