"""`torsio-hardware`: computes and draws what a maker needs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from torsio.common import screen
from torsio_hardware import design, drawing, parts
from torsio_hardware import knob as knob_file
from torsio_hardware.flexure import Flexure, bend, closed_form

app = typer.Typer(
    help="Make the files of one Torsio knob. All is computed; nothing has been printed yet.",
    no_args_is_help=True,
)

File = Annotated[
    Path, typer.Argument(help="A knob's file; the reference knob if unset.", show_default=False)
]
Out = Annotated[Path, typer.Option("--out", "-o", metavar="FOLDER", help="Where the files go.")]


def fail(error: Exception) -> typer.Exit:
    """Print what was wrong, and give what ends the command."""
    words = str(error)
    if isinstance(error, OSError) and error.filename is not None:
        words = f"{error.filename}: {error.strerror}"
    screen.line(screen.err, f"torsio-hardware: error: {words}")
    return typer.Exit(1)


def tell(*lines: str) -> None:
    """Print lines as they are."""
    for line in lines:
        screen.line(screen.out, line)


def _number(least: float, most: float, what: str) -> Any:
    return typer.Option(min=least, max=most, help=what)


@app.command("spring")
def spring_command(
    stiffness: Annotated[
        float, _number(0.01, 100, "Stiffness at small twists, in N m/rad.")
    ] = 2.873,
    torque: Annotated[float, _number(1e-3, 10, "Largest torque, in N m.")] = design.FULL_NM,
    material: Annotated[str, typer.Option(help="petg or pla.")] = "petg",
    family: Annotated[str, typer.Option(help="spoke, spiral or meander.")] = "meander",
    line: Annotated[float, _number(0.1, 2, "The printer's line, in mm.")] = 0.45,
    off: Annotated[float, _number(0, 0.2, "So far a printed wall may be off, in mm.")] = 0.05,
    hub: Annotated[float, _number(1, 100, "The arms begin there, in mm.")] = 7.0,
    rim: Annotated[float, _number(2, 200, "The arms end there, in mm.")] = 25.0,
    elements: Annotated[
        bool, typer.Option("--elements", help="Compare with finite elements of two programs.")
    ] = False,
    out: Out = Path("out/hardware"),
) -> None:
    """Search the best spring of a family: curve, strain, tolerance, creep, and its drawing."""
    try:
        of = design.material(material)
        room = design.Room(1e-3 * hub, 1e-3 * rim, 1e-3 * line, 1e-3 * off)
        spring = design.search(room, of, stiffness, family)[0]
        found = spring.as_dict(torque)
        if elements:
            found["elements"] = compare(spring.flexure, of.modulus_pa.value)
        from torsio_hardware import making

        out.mkdir(parents=True, exist_ok=True)
        files = making.spring_files(spring, out)
    except (ValueError, ArithmeticError, RuntimeError, OSError, ModuleNotFoundError) as error:
        raise fail(error) from None
    text = json.dumps(found, indent=2, default=list) + "\n"
    (out / "spring.json").write_text(text, encoding="utf-8")
    rows = found.get("elements", {}).items()
    tell(
        *drawing.words(spring),
        f"Strain at the largest torque {100 * found['strain_at_torque']:.2f} %",
        *(f"  {name:18} " + " ".join(f"{value:.4f}" for value in row) for name, row in rows),
        f"Written: {', '.join(map(str, (*files, out / 'spring.json')))}",
    )


@app.command("all")
def all_command(file: File = knob_file.DEFAULT, out: Out = Path("out/hardware")) -> None:
    """Make all files of a knob: solids, drawings, pictures, wiring, parts, expected figures."""
    try:
        from torsio_hardware import making
    except ModuleNotFoundError as error:
        raise fail(ValueError(f"{error}; ./dev hardware installs what draws")) from None
    try:
        knob = knob_file.load(file)
        bill = parts.load()
        lacking = [*parts.failures(bill, knob), *parts.differences(bill, knob)]
        files = making.make(knob, out, lambda what: tell(f"making {what}"))
    except (ValueError, OSError) as error:
        raise fail(error) from None
    low, high = parts.total_eur(knob)
    tell(
        *lacking,
        f"parts for {low:.0f} to {high:.0f} EUR; parts.csv says what was looked up",
        f"{len(files)} files in {out}; computed and drawn, and nothing printed yet",
    )


def compare(shape: Flexure, modulus_pa: float) -> dict[str, list[float]]:
    """Give the secant stiffness by beams, scikit-fem and CalculiX, flat and as a plate."""
    from torsio_hardware.elements import calculix, scikit_fem

    of, twists = (shape, modulus_pa), (0.001, 0.015, 0.04)
    found = {"twist_rad": list(twists)}
    if shape.family == "spoke":
        found["closed_form"] = [closed_form(*of).stiffness_nm_per_rad]
    runs = {"beams": bend(*of, twists).stiffness_nm_per_rad} | {
        f"scikit_fem_{along}x{across}": scikit_fem(*of, twists, along=along, across=across)
        for along, across in ((40, 2), (80, 3), (120, 4))
    }
    runs["calculix_flat"] = calculix(*of, twists)
    runs["calculix_plate"] = calculix(*of, twists, thin=False)
    return found | {name: run.tolist() for name, run in runs.items()}
