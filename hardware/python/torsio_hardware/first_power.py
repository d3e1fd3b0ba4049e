"""First power on an emulated knob: what a maker does at each step, and sees."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import torsio
from torsio import calibration
from torsio.apps.doctor.examination import check_state
from torsio.calibration import report
from torsio.printed.hands import NoHand, PrescribedMotion, TorqueHand
from torsio.printed.plant import PlantParams
from torsio_hardware.faults import FAULTS, Fault
from torsio_hardware.knob import WALL_NM_PER_RAD, WEIGHT_NM, Knob

KEEP = "calibrate:spring_off"  # within a print's band: the one finding that is no fault
_SETTLE_S = 0.3  # the board learns its sensor's zero
_CAPS: dict[str, Any] = {
    "motor_torque_cap_nm": 0.015,
    "brake_torque_cap_nm": 0.015,
    "speed_limit_rad_s": 10.0,
}
_DRAG_NM, _CONFIRM_NM, _TURN_S = 0.01, 0.03, 0.5
_PUSHED_RAD, _MOVED_RAD = 0.2, 0.02
_WALL_RAD, _STILL_RAD = 0.2, 0.01


@dataclass(frozen=True)
class Seen:
    """The result of a step."""

    step: str
    command: str
    text: str
    finding: str = ""  # empty if all is as it should be

    @property
    def causes(self) -> tuple[Fault, ...]:
        """Faults that it may be."""
        return tuple(of for of in FAULTS if self.finding in (of.finding, *of.also))


Shown = tuple[str, str]  # of a step: what to tell, and the finding


@dataclass
class Bench:
    """A knob on a bench: what a maker can do and see."""

    knob: Knob
    device: torsio.Knob
    world: Any
    fault: Fault
    plant: PlantParams
    quick: bool = False  # calibrate in 13 s

    def figure(self, step: str, what: str, value: float) -> tuple[str, int]:
        """Hold a figure against the band that `Knob.expected` has for it, by a part of its name.

        Returns
        -------
        tuple
            What to tell; 0, or -1 if it is below its band, or 1 if it is above.
        """
        rows = [row[1:] for row in self.knob.expected() if row[0] == step and what in row[1]]
        name, (low, high) = rows[0]
        text = f"{name}: {value:.4g}, expected {low:.4g} to {high:.4g}"
        return text, (value > high) - (value < low)

    def hold(self, push_nm: float) -> tuple[float, tuple[str, ...]]:
        """Hold the knob against a push; return the amperes in the motor's line, and the faults."""
        device = self.device
        self.world.set_hand(PrescribedMotion(angle_rad=device.position_rad()))
        device.arm()
        device.play(torsio.Constant(torque_nm=push_nm))
        device.sleep(0.3)
        # A meter shows the mean; at one moment the ripple of the PWM is in it.
        seen = []
        for _ in range(20):
            device.sleep(0.00131)
            seen.append(self.world.electrics.motor_current_a)
        amperes, faults = abs(sum(seen) / len(seen)), device.faults()
        self.rest()
        self.world.set_hand(NoHand())
        return amperes, faults

    def rest(self) -> None:
        """Disarm, and clear faults when all stands."""
        self.device.stop()
        if self.device.faults():
            self.device.sleep(0.5)
            self.device.clear_fault()


def _meter(bench: Bench) -> Shown:
    """Measure with a meter what the firmware cannot see.

    Ohms show a missing pull-down: volts do not, for chips have weak ones of their own.
    """
    text, off = bench.figure("Link", "kohm", bench.fault.pull_down_kohm)
    return text, "link:pull_down" if off else ""


def _apply(bench: Bench) -> Shown:
    """Look whether the board has the values and pins of the file."""
    bench.fault.happen(bench.world)
    bench.device.sleep(_SETTLE_S)
    board = bench.device.board_config()
    wrong = [name for name, pin in bench.knob.pins.items() if getattr(board, name) != pin]
    return "the board has the values and pins of the file", "link:pins" if wrong else ""


def _turn(bench: Bench) -> Shown:
    """Turn the knob by hand, once, and let go."""
    device, begin = bench.device, bench.device.position_rad()
    bench.world.set_hand(PrescribedMotion(angle_rad=[(0.0, begin), (_TURN_S, begin + math.tau)]))
    device.sleep(_TURN_S + 0.1)
    bench.world.set_hand(NoHand())
    counts = (device.position_rad() - begin) / math.tau * bench.knob.number("counts_per_rev")
    text, off = bench.figure("Encoder", "counts", counts)
    if abs(counts) < 50:
        return text, "encoder:still"
    if counts < 0:
        return text, "encoder:backwards"
    return text, "encoder:counts" if off else ""


def _supply(bench: Bench) -> Shown:
    """Measure the supply."""
    assert bench.plant.electrics
    text, off = bench.figure("Supply", "bridges, V", bench.plant.electrics.supply_v)
    return text, "supply:volts" if off else ""


def doctor(bench: Bench) -> Shown:
    """Ask `doctor` for faults; clocks and answers mean nothing where time is virtual."""
    facts: Any = SimpleNamespace(after=bench.device.health())
    found = check_state(facts)
    if not found.ok:
        return found.text, f"doctor:{next(iter(found.faults), found.check)}"
    return "no fault", ""


def _stop(bench: Bench) -> Shown:
    """Press the emergency stop and release it."""
    device, told = bench.device, []
    for pressed in (True, False):
        bench.world.set_emergency_stop(pressed=pressed)
        device.sleep(0.1)
        told.append(device.faults())
    others = [fault for fault in told[1] if fault != "emergency_stop"]
    if others:
        return f"faults: {', '.join(others)}", f"doctor:{others[0]}"
    device.clear_fault()
    text = "pressed: fault emergency_stop; released and cleared: disarmed"
    return text, "" if "emergency_stop" in told[0] else "stop:not_seen"


def _push(bench: Bench) -> Shown:
    """Let the motor push a little more than the friction, held; then free, and with all it may.

    With the law `motor_only`: one that brakes holds a knob whose motor is swapped, unseen.
    """
    device = bench.device
    device.configure(torsio.ControlConfig(law="motor_only", **_CAPS))
    actuator = device.actuator_config()
    friction = actuator.knob_coulomb_nm + actuator.brake_drag_nm
    amperes, faults = bench.hold(1.3 * friction)
    text, off = bench.figure("Motor", "A", amperes)
    begin, moved = device.position_rad(), 0.0
    if not faults:
        device.arm()
    for push_nm in (1.3 * friction, _CAPS["motor_torque_cap_nm"]):
        for _ in range(20):
            if device.state == "armed" and abs(moved) < _PUSHED_RAD:
                device.play(torsio.Constant(torque_nm=push_nm))
                device.sleep(0.01)
                moved = device.position_rad() - begin
    faults = faults or device.faults()
    bench.rest()
    text += f"; then it turned by {moved:+.2f} rad; faults: {', '.join(faults) or 'none'}"
    if moved < -_PUSHED_RAD / 2:
        return text, "motor:backwards"
    if faults:
        return text, f"motor:{faults[0]}"
    if moved < _MOVED_RAD:
        return text, "motor:still"
    return text, "motor:amperes" if off else ""


def _pwm(bench: Bench) -> Shown:
    """Look at the motor's inputs with an oscilloscope, without torque and with it."""
    scope = getattr(bench.world, "scope", None)
    if scope is None:
        return "no pins to look at here: the RP2350 of --chip has them", ""
    drives = []
    bench.world.set_hand(PrescribedMotion(angle_rad=bench.device.position_rad()))
    bench.device.arm()
    for torque_nm in (0.0, _CAPS["motor_torque_cap_nm"]):
        bench.device.play(torsio.Constant(torque_nm=torque_nm))
        bench.device.sleep(0.05)
        looks = []
        for _ in range(20):  # the current loop answers its sensor's noise
            bench.device.sleep(1e-3)
            looks.append(scope())
        drives.append(sum(first - second for _, first, second in looks) / len(looks))
        lasting = min(max(first, second) for _, first, second in looks)
    bench.rest()
    bench.world.set_hand(NoHand())
    text, off = bench.figure("PWM", "kHz", looks[0][0])
    text += f"; one is low for {drives[0]:.1%} without torque, for {drives[1]:.1%} with it"
    return text, "" if not off and lasting == 1 and drives[1] > drives[0] + 0.03 else "pwm:inputs"


def _drag(bench: Bench) -> Shown:
    """Turn the knob while motor and brake drag, half each by the law `parallel`."""
    device, begin = bench.device, bench.device.position_rad()
    device.configure(torsio.ControlConfig(law="parallel", **_CAPS))
    device.arm()
    device.play(torsio.Friction(torque_nm=_DRAG_NM))
    bench.world.set_hand(PrescribedMotion(angle_rad=[(0.0, begin), (1.0, begin + 2.0)]))
    device.sleep(0.8)
    armed = device.state == "armed"
    assert bench.plant.electrics
    coil_v = bench.world.electrics.coil_current_a * bench.plant.electrics.coil_resistance_ohm
    text, off = bench.figure("Brake", "coil", coil_v)
    bench.world.set_hand(NoHand())
    bench.rest()
    return text, "" if armed and not off else "brake:volts"


def _silence(bench: Bench) -> Shown:
    """Cut the board off from its host while it pushes, and see when all is off."""
    device, world = bench.device, bench.world
    world.set_hand(PrescribedMotion(angle_rad=device.position_rad()))
    device.arm()
    device.play(torsio.Constant(torque_nm=_DRAG_NM))
    device.sleep(0.1)
    pushed_a, silent_ms = world.electrics.motor_current_a, 0
    world.set_link_faults(torsio.LinkFaults(drop_output=1.0))
    while silent_ms < 1000 and abs(world.electrics.motor_current_a) > 0.01 * abs(pushed_a):
        world.advance(2e-3)
        silent_ms += 2
    world.set_link_faults(torsio.LinkFaults())
    world.set_hand(NoHand())
    bench.rest()
    text, off = bench.figure("Silence", "off", 1e-3 * silent_ms)
    return text, "silence:late" if off else ""


def confirm(bench: Bench) -> Shown:
    """Confirm the parts, hold the knob against 30 mN m, and raise the caps."""
    device, of = bench.device, bench.knob.number
    device.update(confirmed=True)
    device.update(values_are="stated")
    device.update(law="motor_only", speed_limit_rad_s=40.0, motor_torque_cap_nm=_CONFIRM_NM)
    device.sleep(_SETTLE_S)
    amperes, faults = bench.hold(_CONFIRM_NM)
    text, off = bench.figure("Confirm", "A", amperes)
    device.update(
        motor_torque_cap_nm=of("motor_torque_max_nm"), brake_torque_cap_nm=of("brake_torque_max_nm")
    )
    if faults:
        return f"{text}; faults: {', '.join(faults)}", f"confirm:{faults[0]}"
    return text, "confirm:amperes" if off else ""


def calibrate(bench: Bench) -> Shown:
    """Calibrate, and hold what is found against the file's bands: friction, then the spring."""
    device, knob = bench.device, bench.knob
    device.update(speed_limit_rad_s=160.0)
    try:
        supply_v = None if bench.quick else knob.number("supply_v")
        found = calibration.calibrate(device, supply_v=supply_v, drift=bench.quick)
    except (calibration.Refusal, torsio.Refused) as error:
        # A fault of the device is named by itself, as `torsio doctor` would.
        reason = next(iter(device.faults()), getattr(error, "reason", "refused"))
        return str(error), f"calibrate:{reason}"
    causes = "".join(report.cause(*row) for row in report.proposals(device, found))
    for name in found.quantities.keys() & {"coulomb_nm", "brake_drag_nm"}:
        text, off = bench.figure("Calibrate", name, found.quantities[name].value)
        if off > 0:
            return f"{text}{causes}", "calibrate:drag"
    stiffness = found.quantities["stiffness_nm_per_rad"].value
    text, off = bench.figure("Calibrate", "stiffness", stiffness)
    share = stiffness / knob.number("spring_stiffness_nm_per_rad") - 1
    text += f"; {100 * share:+.0f} % from the file's"
    if off < 0:
        return text + causes, "calibrate:shaft_soft"
    calibration.apply(device, found)
    finding = KEEP if abs(share) > 0.1 else ""
    return text + (f": keep what is proposed{causes}" if finding else ""), finding


def _soft_wall(bench: Bench) -> Shown:
    """Hang a weight from the knob, so that it rests in a soft wall."""
    device = bench.device
    wall_rad = device.position_rad() + _WALL_RAD
    device.arm()
    device.play(torsio.Wall(angle_rad=wall_rad, stiffness_nm_per_rad=WALL_NM_PER_RAD))
    bench.world.set_hand(TorqueHand(torque_nm=[(0.0, 0.0), (0.5, WEIGHT_NM)]))
    device.sleep(1.5)
    seen = []
    for _ in range(25):
        device.sleep(0.02)
        seen.append(device.position_rad() - wall_rad)
    faults = device.faults()
    bench.world.set_hand(NoHand())
    bench.rest()
    text, off = bench.figure("A soft wall", "rad", seen[-1])
    swing = max(seen) - min(seen)
    text += f"; it swings by {1e3 * swing:.0f} mrad; faults: {', '.join(faults) or 'none'}"
    return text, "wall:swings" if off or faults or swing > _STILL_RAD else ""


STEPS: tuple[tuple[str, str, Callable[[Bench], Shown]], ...] = (
    ("Link", "meter", _meter),
    ("Link", "torsio config load settings.json", _apply),
    ("Encoder", "torsio monitor", _turn),
    ("Supply", "meter", _supply),
    ("Supply", "torsio doctor", doctor),
    ("Emergency stop", "torsio clear-fault", _stop),
    ("Motor", "torsio studio", _push),
    ("PWM", "oscilloscope", _pwm),
    ("Brake", "torsio studio", _drag),
    ("Silence", "watch", _silence),
    (
        "Confirm",
        "torsio config set law=motor_only speed_limit_rad_s=40 confirmed=on values_are=stated "
        "motor_torque_cap_nm=0.03",
        confirm,
    ),
    (
        "Calibrate",
        "torsio config set speed_limit_rad_s=160; torsio calibrate {how}",
        calibrate,
    ),
    ("A soft wall", "torsio studio", _soft_wall),
)
"""Title in docs/how-to/first-power.md and on the page, command, and what it does here."""


def alone(bench: Bench) -> str:
    """Skip all steps; return what `torsio doctor` finds, or else `torsio calibrate`."""
    _apply(bench)
    of = bench.knob.number
    bench.device.update(
        motor_torque_cap_nm=of("motor_torque_max_nm"), brake_torque_cap_nm=of("brake_torque_max_nm")
    )
    bench.device.update(confirmed=True)
    return doctor(bench)[1] or calibrate(bench)[1]


def run(bench: Bench, tell: Callable[[Seen], object], steps: Any = STEPS) -> Seen:
    """Go through the steps until one shows something wrong; return the last that shows a thing."""
    kept: Seen | None = None
    for title, command, step in steps:
        with warnings.catch_warnings():
            # The parts of this board are not confirmed yet.
            warnings.simplefilter("ignore", torsio.HeldLowWarning)
            warnings.simplefilter("ignore", torsio.SceneWarning)
            text, finding = step(bench)
        how = "--drift" if bench.quick else f"--supply {bench.knob.number('supply_v'):g}"
        seen = Seen(title, command.format(how=how), text, finding)
        tell(seen)
        if finding == KEEP:
            kept = seen
        elif finding:
            return seen
    return kept or seen
