"""`torsio rehearse`: first power before there are parts, on a knob with one thing wrong."""

from __future__ import annotations

import importlib
import math
import random
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any

import typer

import torsio
from torsio import calibration
from torsio.apps.doctor.knob import check_start, check_state
from torsio.common.extras import how_to_install
from torsio.printed.hands import NoHand, PrescribedMotion
from torsio.studio.page import page_folder
from torsio_hardware.cli import File, fail, tell
from torsio_hardware.faults import FAULTS, Fault, named
from torsio_hardware.knob import DEFAULT, RATES_HZ, Knob, load

app = typer.Typer(help="Rehearse first power of a knob that is not built yet.")

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


def _band(knob: Knob, step: str, what: str = "") -> tuple[float, float]:
    """Look an expected figure up, by its step and a part of its name."""
    return next(row[2] for row in knob.expected() if row[0] == step and what in row[1])


def _meter(bench: Bench) -> Shown:
    """Measure with a meter what the firmware cannot see.

    Ohms show a missing pull-down: volts do not, for chips have weak ones of their own.
    """
    kohm = bench.fault.pull_down_kohm
    low, high = _band(bench.knob, "link", "no power")
    text = f"enable line to ground, no power: {kohm:.1f} kilohm, expected {low:g} to {high:g}"
    return text, "" if low <= kohm <= high else "link:pull_down"


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
    low, high = _band(bench.knob, "encoder")
    text = f"one turn: {counts:.0f} counts, expected {low:.0f} to {high:.0f}"
    if abs(counts) < 50:
        return text, "encoder:still"
    if counts < 0:
        return text, "encoder:backwards"
    return text, "" if low <= counts <= high else "encoder:counts"


def _doctor(bench: Bench) -> Shown:
    """Ask `doctor` for faults; clocks and answers mean nothing where time is virtual."""
    facts: Any = SimpleNamespace(after=bench.device.health())
    for finding in (check_state(facts), check_start(facts)):
        if not finding.ok:
            first = finding.faults[0] if finding.faults else finding.check
            return finding.text, f"doctor:{first}"
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
    """Let the motor push a little more than the friction, then with all that the cap lets.

    With the law `motor_only`: one that brakes holds a knob whose motor is swapped, unseen.
    """
    device = bench.device
    device.configure(torsio.ControlConfig(law="motor_only", **_CAPS))
    actuator = device.actuator_config()
    friction = actuator.knob_coulomb_nm + actuator.brake_drag_nm
    begin, moved = device.position_rad(), 0.0
    device.arm()
    for push_nm in (1.3 * friction, _CAPS["motor_torque_cap_nm"]):
        for _ in range(20):
            if device.state == "armed" and abs(moved) < _PUSHED_RAD:
                device.play(torsio.Constant(torque_nm=push_nm))
                device.sleep(0.01)
                moved = device.position_rad() - begin
    faults = device.faults()
    device.stop()
    if faults:
        device.sleep(0.5)
        device.clear_fault()
    text = f"a push turned the knob by {moved:+.2f} rad; faults: {', '.join(faults) or 'none'}"
    if moved < -_PUSHED_RAD / 2:
        return text, "motor:backwards"
    if faults:
        return text, f"motor:{faults[0]}"
    return text, "" if moved > _MOVED_RAD else "motor:still"


def _drag(bench: Bench) -> Shown:
    """Let the brake drag, by the law `parallel`."""
    device = bench.device
    device.configure(torsio.ControlConfig(law="parallel", **_CAPS))
    device.arm()
    device.play(torsio.Friction(torque_nm=_DRAG_NM))
    device.sleep(0.5)
    armed = device.state == "armed"
    device.stop()
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
    device.update(confirmed=True)
    device.sleep(_SETTLE_S)
    return "done", ""


def _calibrate(bench: Bench) -> Shown:
    """Calibrate, and hold what is found against the file's bands: friction, then the spring."""
    knob = bench.knob
    try:
        supply_v = knob.number("supply_v")
        quantities = calibration.calibrate(bench.device, supply_v=supply_v).quantities
    except (calibration.Refusal, torsio.Refused) as error:
        # A fault of the device is named by itself, as `torsio doctor` would.
        reason = next(iter(bench.device.faults()), getattr(error, "reason", "refused"))
        return str(error), f"calibrate:{reason}"
    for name in ("coulomb_nm", "brake_drag_nm"):
        found, most = quantities[name].value, _band(knob, "calibrate", name)[1]
        if found > most:
            text = f"{name} is {1e3 * found:.1f} mN m, expected at most {1e3 * most:.1f}"
            return text, "calibrate:drag"
    stiffness = quantities["stiffness_nm_per_rad"].value
    low, high = _band(knob, "calibrate", "stiffness")
    off = stiffness / knob.number("spring_stiffness_nm_per_rad") - 1
    text = (
        f"shaft {stiffness:.3f} N m/rad, {100 * off:+.0f} % from the file's; a "
        f"print may have {low:.2f} to {high:.2f}"
    )
    if stiffness < low:
        return text, "calibrate:shaft_soft"
    return (f"{text}: keep what is proposed", KEEP) if abs(off) > 0.1 else (text, "")


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


def _on_chip(knob: Knob, fault: Fault, seed: int | None) -> Any:
    """Give the bench of the tests, which have the emulated chip."""
    try:
        sys.path.insert(0, str(Path.cwd()))
        return importlib.import_module("tests.making.chip").binary(knob, fault, seed)
    except ModuleNotFoundError as error:
        needed = "--chip runs in a clone of the project alone, after ./dev test making"
        raise ValueError(f"{needed}: {error}") from None


def served(knob: Knob, fault: Fault, seed: int | None) -> Any:
    """Describe the knob as the page has it; a calibration has its parts confirmed.

    Raises `ModuleNotFoundError` without what serves pages.
    """
    from torsio.studio.server import Emulated

    of = options(knob, fault, seed)
    board = replace(of.board, confirmed=True)  # type: ignore[type-var]
    return Emulated(
        replace(of, paced=True, log_truth=True),
        replace(of, board=board, control=torsio.ControlConfig(speed_limit_rad_s=160.0)),
        fault.happen,
    )


def _serve(knob: Knob, fault: Fault, seed: int | None) -> None:
    """Serve the page until Ctrl-C, and say what a meter shows: the page cannot."""
    try:
        from torsio.studio.server import serve

        page = page_folder()
    except (ModuleNotFoundError, torsio.Error) as error:
        missing = error.name if isinstance(error, ModuleNotFoundError) else "the built page"
        raise ValueError(
            f"--page needs {how_to_install('studio')}, and then once ./dev studio in the clone, "
            f"which builds the page (Ctrl-C ends it); missing now: {missing}"
        ) from None
    world = served(knob, fault, seed)
    tell(f"meter   {fault.pull_down_kohm:.1f} kilohm from enable line to ground, no power")
    tell(f"meter   {world.options.plant.electrics.supply_v:.1f} V at bridges")
    serve("emulated", page, 0, lambda address: tell(f"studio  {address}"), world)


def _go_through(knob: Knob, fault: Fault, seed: int | None, *, chip: bool) -> bool:
    """Take all steps, and say what they show; True if something is wrong."""

    def told(seen: Seen) -> None:
        mark = {"": "ok", KEEP: "off"}.get(seen.finding, "WRONG")
        tell(f"{mark:6} {seen.step:10} $ {seen.command}", f"{'':18}{seen.text}")

    with (_on_chip if chip else emulated)(knob, fault, seed) as bench:
        seen = run(bench, told)
    tell(f"found    {seen.finding or 'nothing wrong'}")
    tell(*(f"         maybe: {named(name).words}" for name in seen.causes))
    return bool(seen.finding)


@app.callback(invoke_without_command=True)
def rehearse(
    file: File = DEFAULT,
    fault: Annotated[
        str, typer.Option(metavar="NAME", help="Build this fault in; `--fault list` names all.")
    ] = "",
    blind: Annotated[
        int | None,
        typer.Option(metavar="NUMBER", help="Draw a hidden fault and parts by this number."),
    ] = None,
    reveal: Annotated[bool, typer.Option("--reveal", help="Tell at the end which it was.")] = False,
    page: Annotated[bool, typer.Option("--page", help="Serve this knob to the studio.")] = False,
    chip: Annotated[
        bool, typer.Option("--chip", help="The released firmware in its chip: takes minutes.")
    ] = False,
) -> None:
    """Go through the steps of docs/how-to/first-power.md, and name what is wrong.

    The device is the emulated one, of the firmware's own sources. Exit status 1: something was
    found.
    """
    if fault == "list":
        tell(*(f"{each.name:18} {each.words}" for each in FAULTS))
        return
    found = False
    try:
        knob = load(file)
        chosen = named(fault)
        if blind is not None:
            chosen = random.Random(blind).choice(FAULTS)
        if page:
            _serve(knob, chosen, blind)
        else:
            found = _go_through(knob, chosen, blind, chip=chip)
    except (ValueError, OSError, torsio.Error) as error:
        raise fail(error) from None
    if reveal:
        tell(f"built in {chosen.words}")
        if blind is not None:
            print_nm_per_rad = knob.plant(blind).shaft_stiffness_nm_per_rad
            tell(f"         beside it this print's spring has {print_nm_per_rad:.3f} N m/rad")
    if found:
        raise typer.Exit(1)
