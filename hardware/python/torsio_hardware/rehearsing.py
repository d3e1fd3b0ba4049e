"""`torsio rehearse`: the whole of first power before there are parts."""

from __future__ import annotations

import importlib
import random
import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

import torsio
from torsio.common.extras import how_to_install, lacking
from torsio.studio.page import page_folder
from torsio_hardware import faults, rehearsal
from torsio_hardware.cli import File, fail, tell
from torsio_hardware.knob import DEFAULT, Knob, load

app = typer.Typer(help="Rehearse first power of a knob that is not built yet.")


def _on_chip(knob: Knob, fault: faults.Fault, seed: int | None) -> Any:
    """Give the bench of the tests, which have the emulated chip."""
    try:
        sys.path.insert(0, str(Path.cwd()))
        return importlib.import_module("tests.making.chip").binary(knob, fault, seed)
    except ModuleNotFoundError as error:
        needed = "--chip runs in a clone of the project alone, after ./dev test making"
        raise ValueError(f"{needed}: {error}") from None


def served(knob: Knob, fault: faults.Fault, seed: int | None) -> Any:
    """Describe the knob as the page has it; a calibration has its parts confirmed.

    Raises `ValueError` without what serves pages.
    """
    try:
        from torsio.studio.server import Emulated
    except ModuleNotFoundError as error:
        raise ValueError(lacking("the studio", "studio", error)) from None
    options = rehearsal.options(knob, fault, seed)
    board = replace(options.board, confirmed=True, motor_current_continuous_a=2.0)  # type: ignore[type-var]
    return Emulated(
        replace(options, paced=True, log_truth=True),
        replace(options, board=board, control=torsio.ControlConfig(speed_limit_rad_s=160.0)),
        fault.happen,
    )


def _page() -> Path:
    """Return the built page; raise `ValueError` that says all that serving it needs."""
    try:
        importlib.import_module("torsio.studio.server")
        return page_folder()
    except (ModuleNotFoundError, torsio.Error) as error:
        missing = error.name if isinstance(error, ModuleNotFoundError) else "the built page"
        raise ValueError(
            f"--page needs {how_to_install('studio')}, and then once ./dev studio in the clone, "
            f"which builds the page (Ctrl-C ends it); missing now: {missing}"
        ) from None


def _serve(knob: Knob, fault: faults.Fault, seed: int | None) -> None:
    """Serve the page until Ctrl-C, and say what a meter shows: the page cannot."""
    page = _page()
    world = served(knob, fault, seed)
    from torsio.studio.server import serve

    kohm = fault.meter.get(rehearsal.PULL_DOWN, rehearsal.PULL_DOWN_KOHM)
    tell(f"meter   {kohm:.1f} kilohm from {rehearsal.PULL_DOWN}")
    tell(f"meter   {world.options.plant.electrics.supply_v:.1f} V at bridges")
    serve("emulated", page, 0, lambda address: tell(f"studio  {address}"), world)


def _go_through(knob: Knob, fault: faults.Fault, seed: int | None, *, chip: bool) -> bool:
    """Take all steps, and say what they show; True if something is wrong."""

    def told(seen: rehearsal.Seen) -> None:
        mark = {"": "ok", rehearsal.KEEP: "off"}.get(seen.finding, "WRONG")
        tell(f"{mark:6} {seen.step:10} $ {seen.command}", f"{'':18}{seen.text}")

    with (_on_chip if chip else rehearsal.emulated)(knob, fault, seed) as bench:
        seen = rehearsal.run(bench, told, rehearsal.STEPS[:-2] if chip else rehearsal.STEPS)
    tell(f"found    {seen.finding or 'nothing wrong'}")
    tell(*(f"         maybe: {faults.named(name).words}" for name in seen.causes))
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
        bool, typer.Option("--chip", help="The released firmware in its chip; no calibration.")
    ] = False,
) -> None:
    """Go through the steps of docs/how-to/first-power.md, and name what is wrong.

    The device is the emulated one, of the firmware's own sources. Exit status 1: something was
    found.
    """
    if fault == "list":
        tell(*(f"{each.name:18} {each.words}" for each in faults.FAULTS))
        return
    found = False
    try:
        knob = load(file)
        chosen = faults.named(fault)
        if blind is not None:
            chosen = random.Random(blind).choice(faults.FAULTS)
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
