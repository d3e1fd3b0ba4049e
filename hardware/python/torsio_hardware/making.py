"""All files of a knob: solids, drawings, pictures, wiring, bill of materials, expected figures."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from build123d import Color, Compound, ExportSVG, Pos, export_step, export_stl

from torsio_hardware import drawing, parts, solids, wires
from torsio_hardware.knob import Knob
from torsio_hardware.solids import Placed

_VIEW, _FROM_BELOW = (400.0, -500.0, 350.0), (400.0, -500.0, -250.0)
_VIEWS = {2: _FROM_BELOW, 3: _FROM_BELOW, 9: (-400.0, -500.0, 350.0)}  # of steps of the assembly
_COARSE = 14  # pieces of an arm, in pictures


def picture(old: list[Any], new: list[Any], file: Path, view: Any = _VIEW) -> None:
    """Draw solids as lines, without what is hidden; what is new is red."""
    export = ExportSVG(margin=5, line_weight=0.6)
    export.add_layer("old", line_color=Color(0.15, 0.2, 0.25), line_weight=0.6)
    export.add_layer("new", line_color=Color(0.75, 0.1, 0.1), line_weight=0.9)
    look = tuple(Compound(children=[*old, *new]).center())

    def seen(of: list[Any]) -> Any:
        return Compound(children=of).project_to_viewport(view, look_at=look)[0] if of else []

    def marks(lines: Any) -> Any:
        points = [
            edge @ share for edge in lines for share in np.linspace(0, 1, int(edge.length) * 3 + 3)
        ]
        return np.array([(at.X, at.Y) for at in points]).reshape(-1, 2)

    # A line is new if its middle lies on one of the new solids alone, and on none of the old.
    of_old, of_new = marks(seen(old)), marks(seen(new))
    for line in seen([*old, *new]):
        at = line @ 0.5
        off_old, off_new = (
            np.hypot(*(of - (at.X, at.Y)).T).min(initial=1.0) for of in (of_old, of_new)
        )
        export.add_shape(line, layer="new" if off_new < 0.3 <= off_old else "old")
    export.write(str(file))


def exploded(placed: list[Placed]) -> list[Any]:
    """Lift each part along the axis."""
    return [Pos(0, 0, part.lift_mm) * part.solid for part in placed]


def make(knob: Knob, out: Path, tell: Callable[[str], object]) -> list[Path]:
    """Write all files into a folder; give their names.

    Raises
    ------
    OSError
        If one cannot be written.
    ValueError
        If the bill of materials lacks a part that the knob's file names.
    """
    out.mkdir(parents=True, exist_ok=True)
    flexure, named = knob.spring.flexure, parts.named(parts.load(), knob)
    sizes = [float(named[role].ratings["diameter_mm"]) for role in ("motor", "brake")]
    files = [_text(out / "spring.svg", drawing.svg(knob.spring))]
    files.append(_text(out / "harness.svg", wires.harness_svg(knob)))
    files.append(_text(out / "board.svg", wires.board_svg(knob)))
    files.append(_text(out / "settings.json", json.dumps(knob.settings(), indent=2) + "\n"))
    expected = {"steps": knob.expected(), "figures": knob.figures()}
    files.append(_text(out / "expected.json", json.dumps(expected, indent=2) + "\n"))
    files.append(_bill(out / "parts.csv"))
    tell("solids")
    placed = solids.assembly(flexure, *sizes)
    for part in placed:
        if part.is_printed and part.name not in ("leg 2", "leg 3", "leg 4"):
            name = part.name.replace(" ", "_").removesuffix("_1")
            file = out / f"{name}.stl"
            export_stl(solids.printed(part), str(file), tolerance=0.02)
            files.append(file)
    whole = Compound(children=[part.solid for part in placed], label=knob.name)
    export_step(solids.spring(flexure), str(out / "spring.step"))
    export_step(whole, str(out / "assembly.step"))
    files += [out / "spring.step", out / "assembly.step"]
    tell("pictures")
    coarse = solids.assembly(flexure, *sizes, points=_COARSE)
    picture(exploded(coarse), [], out / "exploded.svg")
    files.append(out / "exploded.svg")
    for step in sorted({part.step for part in coarse}):
        file = out / f"step_{step}.svg"
        before = [part.solid for part in coarse if part.step < step]
        new = [part.solid for part in coarse if part.step == step]
        picture(before, new, file, _VIEWS.get(step, _VIEW))
        files.append(file)
    return files


def _text(file: Path, text: str) -> Path:
    file.write_text(text, encoding="utf-8")
    return file


def _bill(file: Path) -> Path:
    """Write the first choices with totals."""
    found = parts.load()
    with file.open("w", encoding="utf-8", newline="") as opened:
        writer = csv.writer(opened)
        writer.writerow(["part", "quantity", "maker", "number", "low_eur", "high_eur", "source"])
        for part in found:
            if part.is_first:
                writer.writerow(
                    [part.place, part.quantity, part.maker, part.number, *part.price_eur,
                     part.source]
                )  # fmt: skip
        writer.writerow(["total", "", "", "", *parts.total_eur(found), ""])
    return file
