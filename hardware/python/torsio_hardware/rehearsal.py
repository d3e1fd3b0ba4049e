"""First power before there are parts: the same steps, on an emulated knob with one thing wrong."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import torsio
from torsio import calibration
from torsio.apps.doctor.facts import ClockFit, KnobFacts
from torsio.apps.doctor.knob import check_parts, check_start, check_state
from torsio.printed.hands import NoHand, PrescribedMotion
from torsio_hardware.faults import FAULTS, Fault
from torsio_hardware.knob import RATES_HZ, Knob

# A meter's ohms show a missing pull-down: volts do not, for chips have weak ones of their own.
PULL_DOWN = "enable line to ground, no power"
PULL_DOWN_KOHM = 4.3  # 4.7, beside 100 of each bridge
KEEP = "calibrate:spring_off"  # within a print's band: the one finding that is no fault
_SETTLE_S = 0.3  # the board learns its sensor's zero
_CAPS: dict[str, Any] = {
    "motor_torque_cap_nm": 0.015,
    "brake_torque_cap_nm": 0.015,
    "speed_limit_rad_s": 10.0,
}
_DRAG_NM, _TURN_S = 0.01, 0.5
_PUSHED_RAD, _MOVED_RAD = 0.2, 0.02


@dataclass(frozen=True)
class Seen:
    """The result of a step."""

    step: str
    command: str
    text: str
    finding: str = ""  # empty if all is as it should be

    @property
    def causes(self) -> tuple[str, ...]:
        """Names of faults that it may be."""
        return tuple(of.name for of in FAULTS if self.finding in (of.finding, *of.also))


Shown = tuple[str, str]  # of a step: what to tell, and the finding


@dataclass
class Bench:
    """A knob on a bench: what a maker can do and see."""

    knob: Knob
    device: torsio.Knob
    world: Any
    fault: Fault


def options(knob: Knob, fault: Fault, seed: int | None) -> torsio.EmulatorOptions:
    """Describe the emulated device as after `torsio config load` and a start, with a fault."""
    configs, plant = knob.configs(), fault.change(knob.plant(seed))
    sign = configs["actuator"].encoder_reversed != fault.reversed_encoder
    configs["actuator"] = replace(configs["actuator"], encoder_reversed=sign)
    return torsio.EmulatorOptions(
        plant=plant, control_rate_hz=RATES_HZ[knob.board], seed=seed or 0, **configs
    )


@contextmanager
def emulated(knob: Knob, fault: Fault, seed: int | None = None) -> Iterator[Bench]:
    """Give the emulated device, of the firmware's own sources, wired with a fault or without."""
    with torsio.open("emulated", emulator=options(knob, fault, seed)) as device:
        yield Bench(knob, device, device.emulator, fault)


def _band(knob: Knob, step: str) -> tuple[float, float]:
    return next(row[2] for row in knob.expected() if row[0] == step)


def _apply(bench: Bench) -> Shown:
    """Look whether the board has the values and pins of the file."""
    bench.fault.happen(bench.world)
    bench.device.sleep(_SETTLE_S)
    board = bench.device.board_config()
    wrong = [name for name, pin in bench.knob.pins.items() if getattr(board, name) != pin]
    return "the board has the values and pins of the file", "link:pins" if wrong else ""


def _turn(bench: Bench) -> Shown:
    """Turn the knob by hand, once, and let go."""
    device = bench.device
    begin = device.position_rad()
    bench.world.set_hand(PrescribedMotion(angle_rad=[(0.0, begin), (_TURN_S, begin + 2 * math.pi)]))
    device.sleep(_TURN_S + 0.1)
    bench.world.set_hand(NoHand())
    counts = (device.position_rad() - begin) / math.tau * bench.knob.number("counts_per_rev")
    low, high = _band(bench.knob, "encoder")
    text = f"one turn: {counts:.0f} counts, expected {low:.0f} to {high:.0f}"
    finding = ""
    if abs(counts) < 50:
        finding = "encoder:still"
    elif counts < 0:
        finding = "encoder:backwards"
    elif not low <= counts <= high:
        finding = "encoder:counts"
    return text, finding


def _meter(bench: Bench) -> Shown:
    """Measure with a meter what the firmware cannot see."""
    kohm = bench.fault.meter.get(PULL_DOWN, PULL_DOWN_KOHM)
    low, high = next(row[2] for row in bench.knob.expected() if "no power" in row[1])
    text = f"{PULL_DOWN}: {kohm:.1f} kilohm, expected {low:g} to {high:g}"
    return text, "" if low <= kohm <= high else "link:pull_down"


def _doctor(bench: Bench) -> Shown:
    """Ask `doctor`, without clocks and answers: they mean nothing in virtual time."""
    device, health = bench.device, bench.device.health()
    facts = KnobFacts(
        info=device.info,
        before=health,
        after=health,
        watchdog_s=device.control_config().watchdog_s,
        watches_supply=device.board_config().supply_sense_pin != 0,
        limits=device.limits(),
        clock=ClockFit(0.0, 0.0, 0.0),
        round_trips=None,
        samples=0,
        link=device.statistics(),
    )
    for check in (check_state, check_start, check_parts):
        finding = check(facts)
        # Parts are not confirmed yet.
        if not finding.ok and finding.check != "parts":
            first = finding.faults[0] if finding.faults else finding.check
            return finding.text, f"doctor:{first}"
    return "no fault", ""


def _stop(bench: Bench) -> Shown:
    """Press the emergency stop and release it."""
    device = bench.device
    bench.world.set_emergency_stop(pressed=True)
    device.sleep(0.1)
    pressed = "emergency_stop" in device.faults()
    bench.world.set_emergency_stop(pressed=False)
    device.sleep(0.1)
    others = [fault for fault in device.faults() if fault != "emergency_stop"]
    if others:
        return f"faults: {', '.join(others)}", f"doctor:{others[0]}"
    device.clear_fault()
    text = "pressed: fault emergency_stop; released and cleared: disarmed"
    return text, "" if pressed else "stop:not_seen"


def _push(bench: Bench) -> Shown:
    """Let the motor push a little more than the friction, then with all that the cap lets.

    With the law `motor_only`: one that brakes holds a knob whose motor is swapped, unseen.
    """
    device = bench.device
    device.configure(torsio.ControlConfig(law="motor_only", **_CAPS))
    actuator = device.actuator_config()
    friction = actuator.knob_coulomb_nm + actuator.brake_drag_nm
    begin, fastest = device.position_rad(), 0.0
    device.arm()
    for n in range(40):
        if device.state != "armed" or abs(fastest) > _PUSHED_RAD:
            break
        if n % 20 == 0:
            push_nm = _CAPS["motor_torque_cap_nm"] if n else 1.3 * friction
            device.play(torsio.Constant(torque_nm=push_nm))
        device.sleep(0.01)
        fastest = device.position_rad() - begin
    faults = device.faults()
    if device.state == "armed":
        device.stop()
        device.disarm()
    if faults:
        device.sleep(0.5)
        device.clear_fault()
    finding = f"motor:{faults[0]}" if faults else ""
    if fastest < -_PUSHED_RAD / 2:
        finding = "motor:backwards"
    elif not faults and fastest < _MOVED_RAD:
        finding = "motor:still"
    text = f"a push turned the knob by {fastest:+.2f} rad; faults: {', '.join(faults) or 'none'}"
    return text, finding


def _drag(bench: Bench) -> Shown:
    """Let the brake drag, by the law `parallel`."""
    device = bench.device
    device.configure(torsio.ControlConfig(law="parallel", **_CAPS))
    device.arm()
    device.play(torsio.Friction(torque_nm=_DRAG_NM))
    device.sleep(0.5)
    armed = device.state == "armed"
    if armed:
        device.disarm()
    low, high = _band(bench.knob, "brake")
    text = f"friction of 10 mN m: measure {low:.2f} to {high:.2f} V at the coil"
    return text, "" if armed else "brake:disarmed"


def _confirm(bench: Bench) -> Shown:
    """Confirm the parts; give calibration the torques and the speed that it takes."""
    device, of = bench.device, bench.knob.number
    device.update(
        speed_limit_rad_s=160.0,
        motor_torque_cap_nm=of("motor_torque_max_nm"),
        brake_torque_cap_nm=of("brake_torque_max_nm"),
    )
    device.update(confirmed=True, motor_current_continuous_a=2.0)
    device.sleep(_SETTLE_S)
    return "done", ""


def _calibrate(bench: Bench) -> Shown:
    """Calibrate, and hold what is found against the file's bands: friction, then the spring."""
    knob = bench.knob
    try:
        quantities = calibration.calibrate(bench.device).quantities
    except (calibration.Refusal, torsio.Refused) as error:
        # A fault of the device is named by itself, as `torsio doctor` would.
        reason = next(iter(bench.device.faults()), getattr(error, "reason", "refused"))
        return str(error), f"calibrate:{reason}"
    bands = {row[1]: row[2] for row in knob.expected() if row[0] == "calibrate"}
    for name in ("coulomb_nm", "brake_drag_nm"):
        found, most = quantities[name].value, bands[name][1]
        if found > most:
            text = f"{name} is {1e3 * found:.1f} mN m, expected at most {1e3 * most:.1f}"
            return text, "calibrate:drag"
    stiffness = quantities["stiffness_nm_per_rad"].value
    low, high = bands["stiffness_nm_per_rad"]
    off = stiffness / knob.number("spring_stiffness_nm_per_rad") - 1
    text = (
        f"shaft {stiffness:.3f} N m/rad, {100 * off:+.0f} % from the file's; a "
        f"print may have {low:.2f} to {high:.2f}"
    )
    if stiffness < low:
        return text, "calibrate:shaft_soft"
    if abs(off) > 0.1:
        return f"{text}: keep what is proposed", KEEP
    return text, ""


STEPS: tuple[tuple[str, str, Callable[[Bench], Shown]], ...] = (
    ("link", "meter", _meter),
    ("link", "torsio config load settings.json", _apply),
    ("encoder", "torsio monitor", _turn),
    ("doctor", "torsio doctor", _doctor),
    ("stop", "torsio monitor", _stop),
    ("motor", "torsio studio", _push),
    ("brake", "torsio studio", _drag),
    (
        "confirm",
        "torsio config set confirmed=on speed_limit_rad_s=160 "
        "motor_torque_cap_nm={motor_torque_max_nm:g} brake_torque_cap_nm={brake_torque_max_nm:g}",
        _confirm,
    ),
    ("calibrate", "torsio calibrate --supply {supply_v:g}", _calibrate),
)


def run(bench: Bench, tell: Callable[[Seen], object], steps: Any = STEPS) -> Seen:
    """Go through the steps of first power until one shows something wrong; return the last."""
    for step_name, command, step in steps:
        with warnings.catch_warnings():
            # The parts of this board are not confirmed yet.
            warnings.simplefilter("ignore", torsio.HeldLowWarning)
            warnings.simplefilter("ignore", torsio.SceneWarning)
            text, finding = step(bench)
        values = {name: value.value for name, value in bench.knob.values.items()}
        seen = Seen(step_name, command.format(**values), text, finding)
        tell(seen)
        if finding:
            break
    return seen
