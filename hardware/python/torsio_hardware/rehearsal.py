"""`torsio rehearse`: first power before there are parts, on a knob with one thing wrong."""

from __future__ import annotations

import importlib
import random
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

import torsio
from torsio.common.extras import how_to_install
from torsio.studio.page import page_folder
from torsio_hardware.cli import File, fail, tell
from torsio_hardware.faults import FAULTS, Fault, named
from torsio_hardware.first_power import KEEP, Bench, Seen, run
from torsio_hardware.knob import DEFAULT, RATES_HZ, Knob, load

app = typer.Typer(help="Rehearse first power of a knob that is not built yet.")


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
        yield Bench(knob, device, device.emulator, fault, fault.change(knob.plant(seed)))


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


def _go_through(knob: Knob, fault: Fault, seed: int | None, *, chip: bool, quick: bool) -> bool:
    """Take all steps, and say what they show; True if something is wrong."""

    def told(seen: Seen) -> None:
        mark = {"": "ok", KEEP: "off"}.get(seen.finding, "WRONG")
        tell(f"{mark:6} {seen.step:15} $ {seen.command}", f"{'':23}{seen.text}")

    with (_on_chip if chip else emulated)(knob, fault, seed) as bench:
        bench.quick = quick
        seen = run(bench, told)
    tell(f"found    {seen.finding or 'nothing wrong'}")
    tell(*(f"         maybe: {of.words}; without the steps: {of.alone}" for of in seen.causes))
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
    quick: Annotated[bool, typer.Option("--quick", help="Calibrate with --drift.")] = False,
) -> None:
    """Go through the steps of docs/how-to/first-power.md, and name what is wrong.

    The device is the emulated one, of the firmware's own sources. Exit status 1: something was
    found.
    """
    if fault == "list":
        tell(*(f"| {of.name} | {of.words} | {of.finding} | {of.alone} |" for of in FAULTS))
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
            found = _go_through(knob, chosen, blind, chip=chip, quick=quick)
    except (ValueError, OSError, torsio.Error) as error:
        raise fail(error) from None
    if reveal:
        tell(f"built in {chosen.words}")
        if blind is not None:
            print_nm_per_rad = knob.plant(blind).shaft_stiffness_nm_per_rad
            tell(f"         beside it this print's spring has {print_nm_per_rad:.3f} N m/rad")
    if found:
        raise typer.Exit(1)
