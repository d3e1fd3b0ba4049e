"""All files of a knob: solids, drawings, pictures, wiring, bill of materials, expected figures."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from build123d import Color, Compound, ExportSVG, Pos, export_step, export_stl

from torsio_hardware import drawing, parts, solids, wires
from torsio_hardware.knob import Knob

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

    # A line is new if points of it lie on the new solids alone, not only where it crosses old ones.
    of_old, of_new = marks(seen(old)), marks(seen(new))
    for line in seen([*old, *new]):
        at = np.array([(point.X, point.Y) for point in (line @ share for share in (0.3, 0.5, 0.7))])
        off_old, off_new = (
            np.linalg.norm(of[:, None] - at, axis=2).min(axis=0, initial=1.0)
            for of in (of_old, of_new)
        )
        export.add_shape(line, layer="new" if any((off_new < 0.3) & (off_old >= 0.3)) else "old")
    export.write(str(file))


def make(knob: Knob, out: Path, tell: Callable[[str], object]) -> list[Path]:
    """Write all files into a folder; give their names.

    Raises `OSError` if one cannot be written, `ValueError` if the bill of materials lacks a part
    that the knob's file names.
    """
    out.mkdir(parents=True, exist_ok=True)
    flexure, named = knob.spring.flexure, parts.named(parts.load(), knob)
    sizes = [float(named[role].ratings["diameter_mm"]) for role in ("motor", "brake")]
    expected = {"steps": knob.expected(), "figures": knob.figures()}
    texts = {
        "spring.svg": drawing.svg(knob.spring),
        "harness.svg": wires.harness_svg(knob),
        "board.svg": wires.board_svg(knob),
        "settings.json": json.dumps(knob.settings(), indent=2) + "\n",
        "expected.json": json.dumps(expected, indent=2) + "\n",
        "parts.csv": _bill(),
    }
    files = [out / name for name in texts]
    for file in files:
        file.write_text(texts[file.name], encoding="utf-8", newline="")
    tell("solids")
    placed = solids.assembly(flexure, *sizes)
    for part in placed:
        if part.is_printed and part.name not in ("leg 2", "leg 3", "leg 4"):
            name = part.name.replace(" ", "_").removesuffix("_1")
            files.append(out / f"{name}.stl")
            export_stl(solids.printed(part), str(files[-1]), tolerance=0.02)
    whole = Compound(children=[part.solid for part in placed], label=knob.name)
    for body, name in ((solids.spring(flexure), "spring"), (whole, "assembly")):
        files.append(out / f"{name}.step")
        export_step(body, str(files[-1]))
    tell("pictures")
    coarse = solids.assembly(flexure, *sizes, points=_COARSE)
    files.append(out / "exploded.svg")
    picture([Pos(0, 0, part.lift_mm) * part.solid for part in coarse], [], files[-1])
    for step in sorted({part.step for part in coarse}):
        files.append(out / f"step_{step}.svg")
        before = [part.solid for part in coarse if part.step < step]
        new = [part.solid for part in coarse if part.step == step]
        picture(before, new, files[-1], _VIEWS.get(step, _VIEW))
    return files


def _bill() -> str:
    """Give the first choices with totals."""
    found, text = parts.load(), io.StringIO()
    writer = csv.writer(text)
    writer.writerow(["part", "quantity", "maker", "number", "low_eur", "high_eur", "source"])
    writer.writerows(
        [part.place, part.quantity, part.maker, part.number, *part.price_eur, part.source]
        for part in found
        if part.is_first
    )
    writer.writerow(["total", "", "", "", *parts.total_eur(found), ""])
    return text.getvalue()
