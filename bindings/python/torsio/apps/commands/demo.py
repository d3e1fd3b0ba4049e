"""Commands of `torsio demo`."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

import torsio
from torsio import perception
from torsio.apps.commands.shared import AsJson, Device, choose, complain, opened, plainly
from torsio.common.emulated import selects_emulated
from torsio.common.extras import how_to_install
from torsio.common.screen import err, line, out, progress
from torsio.demos import output, wall

__all__ = ["add_to"]


def wall_command(
    device: Device = "",
    seed: Annotated[
        int | None,
        typer.Option("--seed", min=0, help="Emulated knob only; 1 if unset.", show_default=False),
    ] = None,
    paced: Annotated[
        bool, typer.Option("--paced", help="Emulated knob only: take real time.")
    ] = False,
    out_folder: Annotated[
        Path, typer.Option("--out", "-o", metavar="FOLDER", help="Folder for picture and numbers.")
    ] = Path("out"),
    as_json: AsJson = False,
) -> None:
    """Push the knob into a virtual wall, and see how well it pushes back.

    Picture and numbers go to FOLDER. The exit status is 0 only if it feels like a wall.
    """
    if not selects_emulated(choose(device)):
        for option, given in (("--seed", seed is not None), ("--paced", paced)):
            if given:
                raise typer.BadParameter(
                    "only for the emulated knob: add --device emulated", param_hint=option
                )
    say = err if as_json else out
    save_figure = _figure_writer()
    png_file, json_file = (out_folder / f"virtual_wall.{kind}" for kind in ("png", "json"))
    output.check([png_file, json_file], "--out")

    emulator = torsio.EmulatorOptions(seed=1 if seed is None else seed, paced=paced, log_truth=True)
    with opened(device, say, emulator) as knob:
        if not knob.is_emulated:
            _prompt_user(say)
        visit = _run_with_progress(knob, say)
    measures = wall.measure(visit)
    numbers = json.dumps(measures.as_dict(), indent=2) + "\n"

    writers: dict[Path, Callable[[Path], object]] = {
        json_file: lambda part: part.write_text(numbers)
    }
    if save_figure is not None:
        writers[png_file] = lambda part: save_figure(visit, measures, part)
    output.write(writers, "--out")
    _print_measures(measures, say)
    picture = png_file if save_figure else f"none without matplotlib: {how_to_install('plot')}"
    line(say, f"\npicture  {picture}")
    line(say, f"numbers  {json_file}")
    if as_json:
        sys.stdout.write(numbers)
    if shortcomings := measures.shortcomings():
        complain("it does not feel like a wall: " + "; ".join(shortcomings))
        raise typer.Exit(1)


def _figure_writer() -> Callable[[wall.WallVisit, wall.WallMeasures, Path], None] | None:
    """Give what draws the picture, if matplotlib is installed."""
    # Only here: it takes a second that list and info need not wait for.
    try:
        from torsio.demos.wall_figure import save_figure
    except ModuleNotFoundError as error:
        if error.name != "matplotlib":
            raise
        return None
    return save_figure


def _prompt_user(say: Console) -> None:
    say.print(
        "The knob will feel a wall "
        f"{math.degrees(wall.WALL_ANGLE_RAD):.0f} degrees from where it is now, in the direction "
        "of positive angle.\nTurn it into the wall, hold for a moment, and come out again, "
        f"within {wall.HARDWARE_DURATION_S:.0f} seconds."
    )
    # Not typer.confirm, for which Ctrl-C is just another way to say no.
    try:
        say.input("Press Enter when you are ready, Ctrl-C to leave it. ")
    except EOFError:
        raise OSError("nobody pressed Enter: standard input has ended") from None


def _run_with_progress(knob: torsio.Knob, say: Console) -> wall.WallVisit:
    with progress(say) as show:
        visit = wall.run(knob, lambda share: show("visiting the wall", share, 1.0))
        show("visiting the wall", 1.0, 1.0)
    return visit


def _print_measures(measures: wall.WallMeasures, say: Console) -> None:
    stiffness = measures.wall_stiffness_nm_per_rad * 1e3 * math.pi / 180
    jnds = {name: perception.text(value) for name, value in measures.jnds().items()}
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("what")
    table.add_column("value", justify="right")
    table.add_column("to a finger", justify="right")
    table.add_column("in plain words")
    table.add_row("wall", f"{stiffness:.1f} mN·m/deg", "", "how fast the torque grows inside it")
    table.add_row(
        "peak torque", f"{1e3 * measures.peak_torque_nm:.1f} mN·m", "", "how hard it was pressed"
    )
    table.add_row(
        "tracking, way in",
        f"{100 * measures.tracking_rms_in:.1f} %",
        jnds["tracking_in"],
        _verdict(measures.tracking_rms_in, wall.GOOD_TRACKING_IN),
    )
    table.add_row(
        "tracking, way out",
        f"{100 * measures.tracking_rms_out:.1f} %",
        jnds["tracking_out"],
        _verdict(measures.tracking_rms_out, wall.GOOD_TRACKING_OUT),
    )
    table.add_row(
        "torque gap",
        f"{1e3 * measures.torque_gap_nm:.1f} mN·m",
        jnds["torque_gap"],
        "most that was missing while the brake let go",
    )
    if measures.sensor_rms_nm is not None:
        table.add_row(
            "sensor error",
            f"{1e3 * measures.sensor_rms_nm:.1f} mN·m",
            jnds["sensor"],
            "sensed against true torque of the shaft, RMS",
        )
    step_nm = perception.count_step_nm(measures.wall_stiffness_nm_per_rad, measures.counts_per_rev)
    table.add_row(
        "one count",
        f"{1e3 * step_nm:.1f} mN·m",
        jnds["count_step"],
        f"step of the torque from count to count; {measures.counts_per_rev} a turn",
    )
    table.add_row(
        "left the wall",
        f"{math.degrees(measures.final_angle_rad):.1f} deg",
        "",
        "yes, nothing stuck" if measures.left_wall else "no: the knob is still in the wall",
    )
    table.add_row(
        "samples",
        f"{measures.samples}",
        "",
        "none lost" if measures.samples_lost == 0 else f"{measures.samples_lost} lost",
    )
    table.add_row(
        "speed", f"{measures.realtime_factor:.3g} x", "", "seconds of the knob in a second of yours"
    )
    say.print()
    say.print(table)
    say.print(f"1 JND: {perception.MEANING}")
    say.print(
        "\n[bold]Not as it should be:[/bold] see the rows above."
        if measures.shortcomings()
        else "\n[bold]It feels like a wall:[/bold] firm on the way in, and it lets go on the way "
        "out.",
    )


def _verdict(share: float, limit: float) -> str:
    word = "good" if share <= limit else "poor"
    return f"{word}: felt against wanted torque, RMS of the peak (good: up to {100 * limit:.0f} %)"


def add_to(app: typer.Typer) -> None:
    """Add the demonstrations."""
    demos = typer.Typer(help="Feel what the knob can do.", no_args_is_help=True)
    demos.command("wall")(plainly(wall_command))
    app.add_typer(demos, name="demo")
