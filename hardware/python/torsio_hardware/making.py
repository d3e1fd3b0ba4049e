"""All files of a knob: solids, drawings, pictures, wiring, bill of materials, expected figures."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from build123d import Color, Compound, ExportSVG, Polyline, Pos, export_step, export_stl

from torsio_hardware import drawing, parts, solids, wires
from torsio_hardware.design import Spring
from torsio_hardware.knob import Knob

_VIEW, _FROM_BELOW = (400.0, -500.0, 350.0), (400.0, -500.0, -250.0)
_VIEWS = {2: _FROM_BELOW, 3: _FROM_BELOW, 9: (-400.0, -500.0, 350.0)}  # of steps of the assembly
_COARSE = 14  # pieces of an arm, in pictures


def picture(old: list[Any], new: list[Any], file: Path, view: Any, names: Any = ()) -> None:
    """Draw solids as lines, without what is hidden; all of what is new is red. Name the old."""
    export = ExportSVG(margin=5, line_weight=0.6)
    export.add_layer("old", line_color=Color(0.15, 0.2, 0.25), line_weight=0.6)
    export.add_layer("new", line_color=Color(0.75, 0.1, 0.1), line_weight=0.9)
    look = tuple(Compound(children=[*old, *new]).center())

    def seen(*of: Any) -> Any:
        return Compound(children=of).project_to_viewport(view, look_at=look)[0]

    export.add_shape(seen(*old, *new), layer="old")
    if new:
        export.add_shape(seen(*new), layer="new")
    named = ((name, seen(of)) for name, of in zip(names, old, strict=bool(names)) if name)
    words = _name(export, list(named)) if names else ""
    export.write(str(file))
    text = file.read_text(encoding="utf-8").removesuffix("</svg>")
    file.write_text(f"{text}{words}</svg>\n", encoding="utf-8")


def _name(export: Any, parts: list[tuple[str, Any]]) -> str:
    """Draw a line from each part to a column at its side; give the words that stand there."""
    rows, words = [], ""
    for name, lines in parts:
        points = np.array([tuple(line @ share)[:2] for line in lines for share in (0, 0.5, 1)])
        rows.append((name, points.mean(axis=0)[0], points))
    middle = np.mean([x for _, x, _ in rows])
    for side in (-1, 1):
        column = [
            (name, at[np.argmax(side * at[:, 0])])
            for name, x, at in rows
            if side * x > side * middle
        ]
        edge = side * max(side * tip[0] for _, tip in column) + 15 * side
        height = np.inf
        for name, tip in sorted(column, key=lambda row: -row[1][1]):
            height = min(height - 14, tip[1])
            far = edge + 160 * side
            export.add_shape(Polyline(tuple(tip), (edge, height), (far, height)), layer="old")
            words += f'<text x="{min(edge, far) + 2:.0f}" y="{-height - 2:.1f}" '
            words += f'style="font:9px sans-serif">{name}</text>'
    return words


def spring_files(spring: Spring, out: Path) -> list[Path]:
    """Write the spring's drawing, STEP and STL into a folder; give their names."""
    svg, step, stl = files = [out / f"spring.{kind}" for kind in ("svg", "step", "stl")]
    svg.write_text(drawing.svg(spring), encoding="utf-8")
    body = solids.spring(spring.flexure)
    export_step(body, str(step))
    export_stl(body, str(stl), tolerance=0.01)
    return files


def _label(number: int, part: solids.Placed, bought: dict[str, parts.Part]) -> str:
    """Call a part as the bill of materials does; of parts that are alike the first alone."""
    name = part.name.removesuffix(" 1")
    if name[-1].isdigit():
        return ""
    bill = None if part.is_printed else bought[name]
    return f"{number} {name}: {bill.maker} {bill.number}" if bill else f"{number} {name}"


def make(knob: Knob, out: Path, tell: Callable[[str], object]) -> list[Path]:
    """Write all files into a folder; give their names.

    Raises `OSError` if one cannot be written, `ValueError` if the bill of materials lacks a part
    that the knob's file names.
    """
    out.mkdir(parents=True, exist_ok=True)
    flexure, bought = knob.spring.flexure, parts.chosen(parts.load(), knob)
    sizes = [float(bought[role].ratings["diameter_mm"]) for role in ("motor", "brake")]
    expected = {"steps": knob.expected(), "figures": knob.figures()}
    texts = {
        "harness.svg": wires.harness_svg(knob),
        "board.svg": wires.board_svg(knob),
        "settings.json": json.dumps(knob.settings(), indent=2) + "\n",
        "expected.json": json.dumps(expected, indent=2) + "\n",
        "parts.csv": parts.bill(knob),
    }
    files = [out / name for name in texts]
    for file in files:
        file.write_text(texts[file.name], encoding="utf-8", newline="")
    tell("solids")
    files += _solids(knob.name, solids.assembly(flexure, *sizes), out)
    files += spring_files(knob.spring, out)
    tell("pictures")
    files += _pictures(solids.assembly(flexure, *sizes, points=_COARSE), bought, out)
    return files


def _solids(name: str, placed: list[solids.Placed], out: Path) -> list[Path]:
    """Write what is printed, each part once, and the whole knob."""
    files = []
    for part in placed:
        own = part.name.removesuffix(" 1").replace(" ", "_")
        if part.is_printed and own != "spring" and not own[-1].isdigit():
            files.append(out / f"{own}.stl")
            export_stl(solids.printed(part), str(files[-1]), tolerance=0.02)
    files.append(out / "assembly.step")
    whole = Compound(children=[part.solid for part in placed], label=name)
    export_step(whole, str(files[-1]))
    return files


def _pictures(coarse: list[solids.Placed], bought: dict[str, parts.Part], out: Path) -> list[Path]:
    """Draw all parts apart, and each step of the assembly."""
    files = [out / "exploded.svg"]
    lifted = [Pos(0, 0, part.lift_mm) * part.solid for part in coarse]
    names = [_label(*row, bought) for row in enumerate(coarse, 1)]
    picture(lifted, [], files[-1], _VIEW, names)
    for step in sorted({part.step for part in coarse}):
        files.append(out / f"step_{step}.svg")
        before = [part.solid for part in coarse if part.step < step]
        new = [part.solid for part in coarse if part.step == step]
        picture(before, new, files[-1], _VIEWS.get(step, _VIEW))
    return files
