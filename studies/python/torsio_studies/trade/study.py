"""`torsio study trade`: `torsio.trade` of many scenes, on many cores or machines."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from matplotlib.figure import Figure
from rich.console import Console

import torsio
from torsio.closed_loop import LoopOptions
from torsio.common.drawing import TEXT, headline
from torsio.common.screen import line, table
from torsio.trading.answers import trade_loop
from torsio.trading.figure import panel
from torsio.trading.runs import PARTS, Variant
from torsio.trading.sources import options_of
from torsio.trading.words import as_dict, lines
from torsio_studies.common import Results, Study, make_folder
from torsio_studies.design.spread import spread

SCENES: Final[dict[str, torsio.Scene]] = {
    "a light switch's detents": torsio.Detents(torque_nm=0.03, pitch_rad=torsio.deg(30)),
    "a stiff wall": torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=3.0),
    "a steering game": [
        torsio.Spring(stiffness_nm_per_rad=0.15),
        torsio.Damper(damping_nm_s_per_rad=1e-3),
        torsio.Periodic(amplitude_nm=5e-3, frequency_hz=40.0),
    ],
}
"""The scenes unless files are named."""


@dataclass(frozen=True)
class One:
    """A scene's work."""

    name: str
    options: LoopOptions
    wanted: float
    quick: bool
    keep: Path | None


def evaluate(one: One) -> Any:
    """Trade one scene, on one core."""
    return trade_loop(
        one.options, wanted=one.wanted, quick=one.quick, keep=one.keep, threads=1, stretch=True
    )


def run(study: Study) -> Results:
    """Trade every scene; what an earlier run has measured is not measured again."""
    settings = study.settings
    work = _work(study)
    report = study.counter("scenes", len(work))
    found: dict[str, Any] = {}
    with spread(
        work,
        scheduler=settings.get("scheduler"),
        workers=settings.get("workers"),
        evaluate=evaluate,
    ) as (_, results):
        for one, answer in results:
            found[one.name] = answer
            report(len(found))
    with study.figure("scenes", size=(13.5, 5.6)) as figure:
        _draw(figure, {one.name: found[one.name] for one in work})
    return {
        "scenes": {one.name: as_dict(found[one.name]) for one in work},
        "words": {one.name: [*lines(found[one.name])] for one in work},
    }


def _work(study: Study) -> list[One]:
    """Give the files that are named, or the scenes, each with a place for its measurements."""
    files = [Path(file) for file in study.settings.get("files") or ()]
    scenes: dict[str, Any] = {str(file): file for file in files} or dict(SCENES)
    wanted = float(study.settings.get("wanted") or 0.5)
    folder = study.out and study.out / "trade"
    if folder is not None:
        make_folder(folder)
    return [
        One(name, options_of(scene, {}), wanted, study.quick, folder and folder / f"{number}.jsonl")
        for number, (name, scene) in enumerate(scenes.items())
    ]


def _draw(figure: Figure, found: dict[str, Any]) -> None:
    axes = figure.subplots(1, len(found), squeeze=False, sharey=True)[0]
    for ax, (name, one) in zip(axes, found.items(), strict=True):
        panel(ax, one, name)
    axes[0].set_ylabel("largest change of the felt torque, JND")
    headline(
        figure,
        "How exact must it be?",
        "Each point leaves out parts or lowers the control rate. Left is cheaper, low is truer. "
        "The lowest line is 0.001 JND or less.",
    )
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=5, frameon=False, labelcolor=TEXT)
    figure.subplots_adjust(left=0.06, right=0.985, top=0.74, bottom=0.2, wspace=0.08)


def show(results: Results, console: Console) -> None:
    """Print the proposals, then what matters, a scene at a time."""
    printed = table(
        "scene", "kept", "left out", "rate", "error, JND", "verified, JND", "saves", words=3
    )
    for name, one in results["scenes"].items():
        rows, found = one["rows"], one["proposal"]
        alone = {part for row in rows if len(row["left_out"]) == 1 for part in row["left_out"]}
        lacks = Variant(tuple(found["left_out"])).lacks
        jnds = [of["largest_jnds"] for of in (found, one["verified"], one["on_device"])]
        saved = 1.0 - rows[0]["knobs_in_real_time"] / found["knobs_in_real_time"]
        printed.add_row(
            name,
            ", ".join(part for part in PARTS if part in alone.difference({"brake", *lacks})),
            ", ".join(found["left_out"]) or "nothing",
            f"{found['rate_hz'] // 1000} kHz",
            f"{jnds[0]:.2f}",
            f"{max(jnds[1:]):.2f}",
            f"{100 * saved:.0f} %",
        )
    console.print(printed)
    for name, words in results["words"].items():
        line(console, f"\n{name}")
        for sentence in words:
            line(console, f"  {sentence}")
