"""`torsio rehearse`: the whole of first power before there are parts."""

from __future__ import annotations

import importlib
import random
import sys
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

import torsio
from torsio.extras import lacking
from torsio.studio.page import page_folder
from torsio_hardware import faults, rehearsal
from torsio_hardware.cli import fail, tell
from torsio_hardware.knob import DEFAULT, Knob, load

app = typer.Typer(help="Rehearse first power of a knob that is not built yet.")

_ADVICE = {fault.name: fault.words for fault in faults.FAULTS}


def _bench(
    knob: Knob, fault: faults.Fault | None, seed: int | None, *, chip: bool
) -> AbstractContextManager[rehearsal.Bench]:
    if not chip:
        return rehearsal.emulated(knob, fault, seed)
    try:
        sys.path.insert(0, str(Path.cwd()))  # the tests of a clone have the chip
        binary = importlib.import_module("tests.making.chip").binary
    except ModuleNotFoundError as error:
        raise ValueError(
            f"--chip runs in a clone of the project alone, after ./dev firmware: {error}"
        ) from None
    found: AbstractContextManager[rehearsal.Bench] = binary(knob, fault, seed)
    return found


def served(knob: Knob, fault: faults.Fault | None, seed: int | None) -> Any:
    """Describe the knob as the page has it; a calibration has its parts confirmed.

    Raises
    ------
    ValueError
        Without what serves pages.
    """
    try:
        from torsio.studio.server import Emulated
    except ModuleNotFoundError as error:
        raise ValueError(lacking("the studio", "studio", error)) from None
    options = rehearsal.options(knob, fault, seed)
    board, speed = options.board, torsio.ControlConfig(speed_limit_rad_s=160.0)
    assert board is not None
    confirmed = replace(board, confirmed=True, motor_current_continuous_a=2.0)
    return Emulated(
        replace(options, paced=True, log_truth=True),
        replace(options, board=confirmed, control=speed),
        fault.happen if fault else lambda world: None,
    )


def _serve(knob: Knob, fault: faults.Fault | None, seed: int | None) -> None:
    """Serve the page until Ctrl-C, and say what a meter shows: the page cannot."""
    world = served(knob, fault, seed)
    from torsio.studio.server import serve

    assert world.options.plant.electrics is not None
    volts = {"bridges": world.options.plant.electrics.supply_v, "enable, board held in reset": 0.0}
    volts |= fault.meter if fault else {}
    tell([f"meter   {value:.1f} V at {point}" for point, value in volts.items()])
    serve("emulated", page_folder(), 0, lambda address: tell([f"studio  {address}"]), world)


@app.callback(invoke_without_command=True)
def rehearse(
    file: Annotated[
        Path, typer.Argument(help="A knob's file; the reference knob if unset.", show_default=False)
    ] = DEFAULT,
    fault: Annotated[
        str, typer.Option(metavar="NAME", help="Build this fault in; `list` names all.")
    ] = "",
    blind: Annotated[
        int | None,
        typer.Option(metavar="NUMBER", help="Have a fault and parts drawn, and not told."),
    ] = None,
    reveal: Annotated[
        bool, typer.Option("--reveal", help="Tell at the end which fault it was.")
    ] = False,
    page: Annotated[
        bool,
        typer.Option("--page", help="Serve this knob to the studio's page, for you to go on with."),
    ] = False,
    chip: Annotated[
        bool,
        typer.Option(
            "--chip", help="The released firmware in the emulated chip; slow, without calibration."
        ),
    ] = False,
) -> None:
    """Go through the steps of docs/how-to/hardware.md, First power, and name what is wrong.

    The device is the emulated one, of the firmware's own sources. Exit status 1: something was
    found.
    """
    if fault == "list":
        tell([f"{each.name:18} {each.words}" for each in faults.FAULTS])
        return
    try:
        knob = load(file)
        chosen = faults.named(fault) if fault else None
        if blind is not None:
            chosen = random.Random(blind).choice(faults.FAULTS)
        if page:
            _serve(knob, chosen, blind)
            seen = None
        else:
            with _bench(knob, chosen, blind, chip=chip) as bench:
                steps = rehearsal.STEPS[:-2] if chip else rehearsal.STEPS
                seen = rehearsal.run(bench, _tell_step, steps)
    except (ValueError, OSError, torsio.Error) as error:
        raise fail(error) from None
    if seen is not None:
        tell(
            [
                f"found    {seen.finding}",
                *(f"         maybe: {_ADVICE[name]}" for name in seen.causes),
            ]
        )
    elif not page:
        tell(["found    nothing wrong"])
    if reveal:
        tell([f"built in {chosen.words if chosen else 'no fault'}"])
    if seen is not None:
        raise typer.Exit(1)


def _tell_step(seen: rehearsal.Seen) -> None:
    tell(
        [
            f"{'WRONG' if seen.finding else 'ok':6} {seen.step:10} $ {seen.command}",
            f"{'':18}{seen.text}",
        ]
    )
