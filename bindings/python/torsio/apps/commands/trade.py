"""`torsio trade`: what of the simulation a scene needs."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Annotated, Any

import typer

import torsio
from torsio.apps.commands.shared import AsJson, option, plainly, print_json
from torsio.common import screen
from torsio.common.extras import need_matplotlib
from torsio.common.screen import err, line, out
from torsio.errors import Error, InvalidArgument
from torsio.trading.found import Trade
from torsio.trading.sources import configuration_of
from torsio.trading.words import as_dict, lines

__all__ = ["add_to"]


def trade_command(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="A Python file that sets `scene`, and perhaps `hand`, `plant` and `control`; or a "
            "recording, which ends in .mcap.",
        ),
    ],
    wanted: Annotated[
        float,
        typer.Option(
            "--wanted", metavar="JND", help="Largest change of the felt torque that you accept."
        ),
    ] = 0.5,
    parts: Annotated[
        str | None,
        option(
            "--parts",
            "NAMES",
            "Parts that the plant has, such as belt,cogging. By default all that are known.",
        ),
    ] = None,
    config: Annotated[
        Path | None,
        option("--config", "FILE", "The knob's configuration, from `torsio config dump`."),
    ] = None,
    picture: Annotated[
        Path | None, option("--picture", "FILE", "PNG of error against cost.")
    ] = None,
    resume: Annotated[
        Path | None, option("--resume", "FILE", "Results so far; the next run goes on from there.")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Only leave out each part alone and all; takes seconds.")
    ] = False,
    stretch: Annotated[
        bool,
        typer.Option("--extremes/--no-extremes", help="How far the scene may be stretched."),
    ] = True,
    as_json: AsJson = False,
) -> None:
    """Find out which parts and which control rate the simulation of a scene needs.

    It prints options to paste. The exit status is 0 only if the proposal holds on other visits.
    """  # fmt: skip
    if picture is not None:
        need_matplotlib(picture)
    known: dict[str, Any] = {} if config is None else configuration_of(config)
    if parts is not None:
        known["parts"] = [name.strip() for name in parts.split(",") if name.strip()]
    found = _traded(file, wanted_jnds=wanted, quick=quick, stretch=stretch, resume=resume, **known)
    if as_json:
        print_json(as_dict(found))
    else:
        for sentence in lines(found):
            line(out, sentence)
        line(out, f"\n{found.paste()}")
    if picture is not None:  # last: it may fail
        from torsio.trading.figure import save_figure

        save_figure(found, picture, f"What {file.name} needs")
        line(err if as_json else out, f"picture  {picture}")
    if not found.holds:
        raise typer.Exit(1)


def _traded(file: Path, **how: Any) -> Trade:
    """Trade, with progress and warnings on the terminal."""
    with warnings.catch_warnings(record=True) as told, screen.progress(err) as show:
        warnings.simplefilter("always", UserWarning)
        try:
            found = torsio.trade(file, on_progress=show, **how)
        except (ValueError, TypeError, RuntimeError) as error:
            raise error if isinstance(error, Error) else InvalidArgument(str(error)) from error
    for warning in told:
        line(err, f"torsio: {warning.message}")
    return found


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("trade")(plainly(trade_command))
