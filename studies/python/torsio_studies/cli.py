"""`torsio study NAME`, which the command `torsio` finds as an entry point."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, get_args

import typer

from torsio.apps.commands.shared import AsJson, complain, print_json
from torsio.common import screen
from torsio.common.screen import err
from torsio.errors import Error
from torsio.printed.config import Law
from torsio_studies import STUDIES

app = typer.Typer(
    help="Find out what the knob can do, and what cannot be trusted.", no_args_is_help=True
)

Out = Annotated[
    Path,
    typer.Option(
        "--out", "-o", metavar="FOLDER", help="Where the pictures go, and the results as NAME.json."
    ),
]
Quick = Annotated[bool, typer.Option("--quick", help="A coarser version that takes a few seconds.")]


# `calibrated` bounds the stiffness, so no spring swings.
_LAWS = [law for law in get_args(Law) if law != "calibrated"]


def _law_of(laws: Sequence[str]) -> Any:
    """Make the option `--law`, which takes these."""

    def known(name: str) -> str:
        if name not in laws:
            raise typer.BadParameter(f"{name!r} is not one of {', '.join(laws)}")
        return name

    return typer.Option(
        "--law",
        callback=known,
        metavar="|".join(laws),
        help="How motor and brake share the torque.",
    )


def _results_in(name: str) -> Any:
    """Make the option `--results` of a study."""
    return typer.Option("--results", metavar="FOLDER", help=f"Parquet files; OUT/{name} if unset.")


def run(name: str, context: typer.Context) -> dict[str, Any]:
    """Run a study with the command's options; what goes wrong is a sentence and an exit status."""
    # Only here: it takes a second that other commands need not wait for.
    from torsio_studies.execution import execute

    settings = dict(context.params)
    as_json, out, quick = (settings.pop(option) for option in ("as_json", "out", "quick"))
    out = Path(out)  # older versions of Typer keep it as text in the parameters
    json_file = out / f"{name}.json"
    console = err if as_json else screen.out
    try:
        results = execute(
            name, json_file=json_file, out=out, quick=quick, console=console, settings=settings
        )
    except KeyboardInterrupt:
        err.print("torsio: interrupted; earlier results are kept")
        raise typer.Exit(130) from None
    except (Error, OSError) as error:
        complain(str(error))
        raise typer.Exit(1) from None
    where = [*(str(out / figure) for figure in results["figures"]), str(json_file)]
    console.print(f"\nWritten in {results['seconds']:.0f} s: {', '.join(where)}")
    if as_json:
        print_json(results)
    return results


def _add(name: str, about: str) -> None:
    def command(
        context: typer.Context,
        as_json: AsJson = False,
        out: Out = Path("out"),
        quick: Quick = False,
    ) -> None:
        run(name, context)

    app.command(name, help=about)(command)


# A study with options of its own has a command below.
for _name, _about in STUDIES.items():
    if _name not in ("calibration", "design", "enclosure", "falsify", "trade"):
        _add(_name, _about)


Workers = Annotated[
    int | None, typer.Option("--workers", min=1, help="Processes; one per core if unset.")
]
Scheduler = Annotated[
    str | None,
    typer.Option("--scheduler", metavar="ADDRESS", help="Dask, such as tcp://host:8786."),
]


@app.command("calibration", help=STUDIES["calibration"])
def calibration(
    context: typer.Context,
    as_json: AsJson = False,
    out: Out = Path("out"),
    quick: Quick = False,
    knobs: Annotated[
        int | None, typer.Option("--knobs", min=4, help="Size of the sample; 200 if unset.")
    ] = None,
    results: Annotated[Path | None, _results_in("calibration")] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Run the study of calibration; an interrupted one goes on where it was."""
    run("calibration", context)


@app.command("falsify", help=STUDIES["falsify"])
def falsify(
    context: typer.Context,
    as_json: AsJson = False,
    out: Out = Path("out"),
    quick: Quick = False,
    cases: Annotated[
        int | None, typer.Option("--cases", min=1, help="Searches; 1120 if unset.")
    ] = None,
    tries: Annotated[
        int | None,
        typer.Option("--tries", min=16, help="Tries of each search, about; 900 if unset."),
    ] = None,
    results: Annotated[Path | None, _results_in("falsify")] = None,
    law: Annotated[str, _law_of(get_args(Law))] = "calibrated",
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Run the search; an interrupted one goes on where it was."""
    run("falsify", context)


@app.command("enclosure", help=STUDIES["enclosure"])
def enclosure(
    context: typer.Context,
    as_json: AsJson = False,
    out: Out = Path("out"),
    quick: Quick = False,
    plants: Annotated[
        int | None, typer.Option("--plants", min=1, help="Random plants; 200 if unset.")
    ] = None,
    tries: Annotated[
        int | None, typer.Option("--tries", min=1, help="Of each search at extremes; 60 if unset.")
    ] = None,
    workers: Workers = None,
) -> None:
    """Enclose the scenes of the study `fidelity`, random plants, and extreme ones by search."""
    run("enclosure", context)


@app.command("trade", help=STUDIES["trade"])
def trade(
    context: typer.Context,
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="FILE...", help="Scenes as for `torsio trade`; three if unset."),
    ] = None,
    as_json: AsJson = False,
    out: Out = Path("out"),
    quick: Quick = False,
    wanted: Annotated[
        float | None, typer.Option("--wanted", metavar="JND", help="0.5 if unset.")
    ] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Trade every scene; an interrupted run goes on where it was.

    The exit status is 0 only if every proposal holds on other visits.
    """
    if not all(one["holds"] for one in run("trade", context)["scenes"].values()):
        raise typer.Exit(1)


@app.command("design", help=STUDIES["design"])
def design(
    context: typer.Context,
    as_json: AsJson = False,
    out: Out = Path("out"),
    quick: Quick = False,
    devices: Annotated[
        int | None, typer.Option("--devices", min=8, help="Size of the sample; 2000 if unset.")
    ] = None,
    results: Annotated[Path | None, _results_in("design")] = None,
    law: Annotated[str, _law_of(_LAWS)] = "paper",
    wall_nm_per_rad: Annotated[
        float | None,
        typer.Option(
            "--wall",
            min=0.0,
            max=1e6,
            metavar="STIFFNESS",
            help="Tell how many counts a wall of so many N m/rad needs.",
        ),
    ] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Run the study of designs; an interrupted one goes on where it was."""
    run("design", context)
