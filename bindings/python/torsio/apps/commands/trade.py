"""`torsio trade`: what of the simulation a scene needs."""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.progress import TaskID

import torsio
from torsio.apps.commands.shared import AsJson, plainly, print_json
from torsio.common import screen
from torsio.common.extras import need_matplotlib
from torsio.common.screen import err, line, out
from torsio.errors import Error, InvalidArgument
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
        typer.Option(
            "--parts",
            metavar="NAMES",
            help="Parts that the plant has, such as belt,cogging. By default all that are known.",
            show_default=False,
        ),
    ] = None,
    config: Annotated[
        Path | None,
        typer.Option(
            "--config",
            metavar="FILE",
            help="The knob's configuration, from `torsio config dump`.",
            show_default=False,
        ),
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option(
            "--picture", metavar="FILE", help="PNG of error against cost.", show_default=False
        ),
    ] = None,
    keep: Annotated[
        Path | None,
        typer.Option(
            "--keep",
            metavar="FILE",
            help="Results so far; the next run goes on from there.",
            show_default=False,
        ),
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
        need_matplotlib()
        if not os.access(picture.resolve().parent, os.W_OK):
            raise InvalidArgument(f"{picture}: its folder does not exist, or cannot be written in")
    known: dict[str, Any] = {} if config is None else configuration_of(config)
    if parts is not None:
        known["parts"] = [name.strip() for name in parts.split(",") if name.strip()]
    with warnings.catch_warnings(record=True) as told, screen.progress(err) as bar:
        warnings.simplefilter("always", UserWarning)
        tasks: dict[str, TaskID] = {}

        def show(what: str, done: int, total: int) -> None:
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=total)
            bar.update(tasks[what], completed=done, total=total)

        try:
            found = torsio.trade(
                file,
                wanted=wanted,
                quick=quick,
                stretch=stretch,
                keep=keep,
                on_progress=show,
                **known,
            )
        except (ValueError, TypeError, RuntimeError) as error:
            raise error if isinstance(error, Error) else InvalidArgument(str(error)) from error
    for warning in told:
        line(err, f"torsio: {warning.message}")
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


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("trade")(plainly(trade_command))
