"""The `torsio` command."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

import torsio
from torsio import calibrate_cli, config_cli, doctor, games_cli, live_commands, recording_commands
from torsio.command import (
    AsJson,
    Device,
    choose,
    complain,
    err,
    is_emulated,
    opened,
    out,
    plainly,
)
from torsio.demos import output, wall
from torsio.extras import how_to_install
from torsio.other_commands import add_commands
from torsio.virtual_knob import cli as virtual_knob

app = typer.Typer(
    help="A USB knob that pushes back.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
demo_app = typer.Typer(help="Feel what the knob can do.", no_args_is_help=True)
app.add_typer(demo_app, name="demo")
games_app = typer.Typer(help="See what games do, and set what they may do.")
app.add_typer(games_app, name="games")
config_app = typer.Typer(help="Read and set what a knob is made of.", no_args_is_help=True)
app.add_typer(config_app, name="config")
add_commands(app)


def _print_json(value: Any) -> None:
    # Not through rich, which would wrap and colour it.
    sys.stdout.write(json.dumps(value, indent=2) + "\n")


def _version(wanted: bool) -> None:
    if wanted:
        sys.stdout.write(f"torsio {torsio.__version__}\n")
        raise typer.Exit


@app.callback()
def main(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Find, ask and feel Torsio knobs: USB knobs that push back."""


@app.command("list")
@plainly
def list_command(as_json: AsJson = False) -> None:
    """List the knobs that can be opened; the emulated one is always there."""
    devices = torsio.list_devices()
    if as_json:
        _print_json([asdict(device) for device in devices])
        return
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("device", "serial", "product", "board", "transport", "ready"):
        table.add_column(column, overflow="fold")
    for device in devices:
        table.add_row(
            device.path,
            device.serial,
            device.product,
            device.board,
            device.transport,
            device.problem or "yes",
        )
    out.print(table)


@app.command("info")
@plainly
def info_command(device: Device = "", as_json: AsJson = False) -> None:
    """Show who a knob is, how it is, and how it is configured."""
    with opened(device, err if as_json else out) as knob:
        groups = {
            "info": asdict(knob.info),
            "health": asdict(knob.health()),
            "clock": asdict(knob.clock()),
            "actuator_config": asdict(knob.actuator_config()),
            "control_config": asdict(knob.control_config()),
            "board_config": asdict(knob.board_config()),
            "game_config": asdict(knob.game_config()),
            "calibration": calibrate_cli.words_of(knob.info.serial),
        }
    if as_json:
        _print_json(groups)
        return
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column()
    table.add_column()
    for name, values in groups.items():
        table.add_row(f"[bold]{name.replace('_', ' ')}[/bold]")
        for key, value in values.items():
            table.add_row(f"  {key}", _value_text(key, value))
    out.print(table)


@app.command("doctor")
@plainly
def doctor_command(
    device: Annotated[
        str,
        typer.Option(
            "--device",
            metavar="DEVICE",
            help="Path, serial number, or 'emulated'; every real knob unless given.",
        ),
    ] = "",
    as_json: AsJson = False,
) -> None:
    """Check the knobs, and say what to do about what is wrong.

    The exit status is 0 only if all is well. It takes three seconds a knob and leaves it as it is.
    """
    reports = doctor.diagnose(device)
    ok = all(report.ok for report in reports)
    if as_json:
        _print_json({"ok": ok, "reports": [report.as_dict() for report in reports]})
    else:
        for report in reports:
            _print_report(report)
    if not ok:
        raise typer.Exit(1)


def _print_report(report: doctor.Report) -> None:
    if report.device:
        out.print(report.device, style="bold", highlight=False, markup=False)
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column(min_width=7)
    table.add_column(min_width=10)
    table.add_column(overflow="fold")
    for finding in report.findings:
        verdict = "[green]ok[/green]" if finding.ok else "[bold red]problem[/bold red]"
        table.add_row(verdict, finding.check.replace("_", " "), Text(finding.text))
        if finding.advice:
            table.add_row("", "", Text(f"-> {finding.advice}"))
            table.add_row("", "", Text(f"   more in {finding.more}", style="dim"))
    out.print(table)


@app.command("calibrate")
@plainly
def calibrate_command(
    device: Device = "",
    quick: Annotated[
        bool, typer.Option("--quick", help="Ten seconds: has anything drifted since it was kept?")
    ] = False,
    keep: Annotated[
        bool, typer.Option("--save", help="Keep what is found, without asking.")
    ] = False,
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="FILE", help="PNG of all fits and what they leave."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Measure the knob: friction, inertia, shaft, brake. Take your hand off; it turns by itself.

    Nothing is saved unless you say so. The exit status is 0 only if every step could be trusted
    and, with --quick, nothing has drifted.
    """
    say = err if as_json else out
    with opened(device, say) as knob:
        measured = calibrate_cli.measure(knob, say, quick=quick, picture=picture)
        found = measured["calibration"]
        if as_json:
            changed = [asdict(drift) for drift in measured["changed"]]
            _print_json(found.as_dict() | {"changed": changed})
        else:
            calibrate_cli.show(knob, measured, out)
        if keep or (not quick and not as_json and sys.stdin.isatty() and _asked(say)):
            calibrate_cli.save(knob, found, say)
    if quick and measured["changed"]:
        raise typer.Exit(1)


def _asked(say: Console) -> bool:
    return say.input("Keep this on the device? [y/N] ").strip().lower() in ("y", "yes")


@games_app.callback(invoke_without_command=True)
@plainly
def games_command(
    context: typer.Context,
    device: Device = "",
    seconds: Annotated[
        float | None,
        typer.Option("--seconds", min=0.0, help="End after so long.", show_default=False),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show the effects of games live: what each gives, how often it changes, who has the actuator.

    Ctrl-C ends it. With --json, or without a terminal, it shows one moment and ends.
    """
    if context.invoked_subcommand is not None:
        return
    with opened(device, err if as_json else out) as knob:
        if as_json:
            _print_json(games_cli.as_dict(games_cli.measure(knob)))
        else:
            games_cli.show(knob, out, seconds=seconds)


@games_app.command("set")
@plainly
def games_set_command(
    device: Device = "",
    range_deg: Annotated[
        float | None, typer.Option("--range-deg", help="From end to end of the axis.")
    ] = None,
    gain: Annotated[
        float | None, typer.Option("--gain", help="On top of the games' own, 0 to 1.")
    ] = None,
    torque_max_nm: Annotated[
        float | None, typer.Option("--torque-max-nm", help="Of all effects together.")
    ] = None,
    spring_gain: Annotated[
        float | None, typer.Option("--spring-gain", help="1: full torque at the end of the axis.")
    ] = None,
    end_stiffness_nm_per_rad: Annotated[
        float | None,
        typer.Option("--end-stiffness", help="Of walls at the ends, in N m/rad; 0: none."),
    ] = None,
    join_updates: Annotated[
        bool | None,
        typer.Option("--join-updates/--hold-updates", help="Lines or steps between updates."),
    ] = None,
    enabled: Annotated[
        bool | None, typer.Option("--allow/--shut-out", help="Whether games get the actuator.")
    ] = None,
) -> None:
    """Set a player's settings, and keep them on the knob. What is not named stays as it is."""
    wanted = {
        "range_deg": range_deg,
        "gain": gain,
        "torque_max_nm": torque_max_nm,
        "spring_gain": spring_gain,
        "end_stiffness_nm_per_rad": end_stiffness_nm_per_rad,
        "join_updates": join_updates,
        "enabled": enabled,
    }
    changes = {name: value for name, value in wanted.items() if value is not None}
    if not changes:
        raise typer.BadParameter("name at least one setting; see torsio games set --help")
    with opened(device, out) as knob:
        config = games_cli.change(knob, changes)
    for name in changes:
        out.print(f"{name}  {_value_text(name, getattr(config, name))}", highlight=False)


@config_app.command("get")
@plainly
def config_get_command(
    names: Annotated[list[str] | None, typer.Argument(metavar="[FIELD]...")] = None,
    device: Device = "",
) -> None:
    """Show fields of the configuration, one a line; all unless some are named."""
    with opened(device, err) as knob:
        for name, value in config_cli.get(knob, names or []).items():
            out.print(f"{name}  {_value_text(name, value)}", highlight=False)


@config_app.command("set")
@plainly
def config_set_command(
    assignments: Annotated[list[str], typer.Argument(metavar="FIELD=VALUE...")],
    device: Device = "",
) -> None:
    """Set fields, and keep them on the knob. Wiring takes effect at its next start."""
    with opened(device, err) as knob:
        for name, value in config_cli.set_fields(knob, assignments).items():
            out.print(f"{name}  {_value_text(name, value)}", highlight=False)


@config_app.command("dump")
@plainly
def config_dump_command(device: Device = "") -> None:
    """Print the whole configuration as JSON, for `load`."""
    with opened(device, err) as knob:
        _print_json(config_cli.dump(knob))


@config_app.command("load")
@plainly
def config_load_command(file: Path, device: Device = "") -> None:
    """Set what a file of `dump` has, all or nothing, and keep it on the knob."""
    with opened(device, err) as knob:
        config_cli.load(knob, file)


@app.command("clear-fault")
@plainly
def clear_fault_command(device: Device = "") -> None:
    """Clear latched faults whose cause is gone; `torsio doctor` names them and their cure."""
    with opened(device, out) as knob:
        knob.clear_fault()


@app.command("stop")
@plainly
def stop_command(device: Device = "") -> None:
    """Take the torque from a knob that plays on its own, and empty its scene."""
    with opened(device, out) as knob:
        knob.stop()


@app.command("zero")
@plainly
def zero_command(device: Device = "") -> None:
    """Make the angle where a knob stands its zero."""
    with opened(device, out) as knob:
        knob.zero()


app.command("emulate")(plainly(virtual_knob.emulate_command))
live_commands.add_to(app)
recording_commands.add_to(app)


def _value_text(key: str, value: Any) -> str:
    if key == "fingerprint":
        return f"0x{value:08x}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple | list):
        return ", ".join(value) or "none"
    return str(value)


@demo_app.command("wall")
@plainly
def demo_wall(
    device: Device = "",
    seed: Annotated[
        int | None,
        typer.Option("--seed", min=0, help="Emulated knob only; 1 if unset.", show_default=False),
    ] = None,
    paced: Annotated[
        bool, typer.Option("--paced", help="Emulated knob only: take real time.")
    ] = False,
    out_folder: Annotated[
        Path, typer.Option("--out", "-o", metavar="FOLDER", help="Where picture and numbers go.")
    ] = Path("out"),
    as_json: AsJson = False,
) -> None:
    """Push the knob into a virtual wall, and see how well it pushes back.

    Picture and numbers go to FOLDER. The exit status is 0 only if it feels like a wall.
    """
    if not is_emulated(choose(device)):
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
    say.print(f"\npicture  {picture}", highlight=False, markup=False, soft_wrap=True)
    say.print(f"numbers  {json_file}", highlight=False, markup=False, soft_wrap=True)
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
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        console=say,
    ) as progress:
        task = progress.add_task("visiting the wall", total=1.0)
        visit = wall.run(knob, lambda share: progress.update(task, completed=share))
        progress.update(task, completed=1.0)
    return visit


def _print_measures(measures: wall.WallMeasures, say: Console) -> None:
    stiffness = measures.wall_stiffness_nm_per_rad * 1e3 * math.pi / 180
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("what")
    table.add_column("value", justify="right")
    table.add_column("in plain words")
    table.add_row("wall", f"{stiffness:.1f} mN·m/deg", "how fast the torque grows inside it")
    table.add_row(
        "peak torque", f"{1e3 * measures.peak_torque_nm:.1f} mN·m", "how hard it was pressed"
    )
    table.add_row(
        "tracking, way in",
        f"{100 * measures.tracking_rms_in:.1f} %",
        _verdict(measures.tracking_rms_in, wall.GOOD_TRACKING_IN),
    )
    table.add_row(
        "tracking, way out",
        f"{100 * measures.tracking_rms_out:.1f} %",
        _verdict(measures.tracking_rms_out, wall.GOOD_TRACKING_OUT),
    )
    table.add_row(
        "torque gap",
        f"{1e3 * measures.torque_gap_nm:.1f} mN·m",
        "most that was missing while the brake let go",
    )
    if measures.sensor_rms_nm is not None:
        table.add_row(
            "sensor error",
            f"{1e3 * measures.sensor_rms_nm:.1f} mN·m",
            "sensed against true torque of the shaft, RMS",
        )
    table.add_row(
        "left the wall",
        f"{math.degrees(measures.final_angle_rad):.1f} deg",
        "yes, nothing stuck" if measures.left_wall else "no: the knob is still in the wall",
    )
    table.add_row(
        "samples",
        f"{measures.samples}",
        "none lost" if measures.samples_lost == 0 else f"{measures.samples_lost} lost",
    )
    table.add_row(
        "speed", f"{measures.realtime_factor:.3g} x", "seconds of the knob in a second of yours"
    )
    say.print()
    say.print(table, highlight=False)
    say.print(
        "\n[bold]Not as it should be:[/bold] see the rows above."
        if measures.shortcomings()
        else "\n[bold]It feels like a wall:[/bold] firm on the way in, and it lets go on the way "
        "out.",
        highlight=False,
    )


def _verdict(share: float, limit: float) -> str:
    word = "good" if share <= limit else "poor"
    return f"{word}: felt against wanted torque, RMS of the peak (good: up to {100 * limit:.0f} %)"
