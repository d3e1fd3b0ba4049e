"""Prints what a benchmark has measured into docs/results.md.

    ./dev bench brake | .venv/bin/python -m tests.bench.tables brake

updates the tables between their marks, with revision, date and machine. A row that was not measured
stays; one that the page does not have is named on standard error.
Names: `binary`, `brake`, `games`, `guards`, `mcu`, `stiffness`, `usb`.
"""

from __future__ import annotations

import json
import os
import platform
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

TREE = Path(__file__).parents[2]
PAGE = TREE / "docs" / "results.md"
BOARDS = ("pico2", "pico")

Lines = list[dict[str, Any]]
Tables = dict[str, list[list[str]]]
"""By mark: rows. The first cells name the row of the page that is replaced."""


def _percent(share: float, digits: int = 0) -> str:
    return f"{100 * share:.{digits}f} %"


def _lag(microseconds: float) -> str:
    return f"{microseconds:.0f} us" if microseconds < 100 else f"{microseconds / 1e3:.2f} ms"


def _mcu(lines: Lines) -> Tables:
    scenes = (
        *(("disarmed", "disarmed", 0), ("armed, empty scene", "walls", 0)),
        *(("one wall", "walls", 1), ("one wall, of 16 that are written", "walls, 16 written", 1)),
        ("sixteen walls", "walls", 16),
        ("one wall, a sample of telemetry every 40 ticks", "walls, telemetry", 1),
        ("one wall in a soft start, so that each tick decides", "walls, soft start", 1),
        ("one wall, with the law `calibrated`", "walls, calibrated", 1),
        ("the same in a wall that is bounded", "stiff wall, calibrated", 1),
        ("an impact alone", "impact", 1),
        ("the control law alone, one wall", "control law, walls", 1),
    )  # fmt: skip
    counts = {
        (line["board"], line["scene"], line["effects"]): line["instructions_per_tick"]
        for line in lines
        if "tick_time_ns" not in line
    }
    rows = [
        [name, *(f"{counts[board, scene, effects]:,.0f}" for board in BOARDS)]
        for name, scene, effects in scenes
    ]
    bent = [counts[board, "bent shaft", 1] - counts[board, "straight shaft", 1] for board in BOARDS]
    rows.append(["knees of the shaft add, with `calibrated`", *(f"{more:,.0f}" for more in bent)])
    periods = dict(zip(BOARDS, (50, 100), strict=True))
    times: dict[str, list[str]] = {board: [] for board in BOARDS}
    for line in (line for line in lines if "tick_time_ns" in line):
        board, ns, most_ns = (line[key] for key in ("board", "tick_time_ns", "tick_time_max_ns"))
        late = "overrun" if ns is None else "at the edge" if most_ns > 1e3 * periods[board] else ""
        times[board].append(late or f"{ns / 1e3:.1f}")
    walls = [[f"`{board}`, us of {us}", *times[board]] for board, us in periods.items()]
    return {"instructions": rows, "damped walls": walls}


def _brake(lines: Lines) -> Tables:
    def row(line: Mapping[str, Any]) -> list[str]:
        stable = line["stable_nm_per_rad"]
        return [
            f"`{line['law']}`",
            line["coil"],
            f"{1e3 * line['torque_gap_nm']:.1f} mN m",
            _percent(line["exit_error"], 1),
            f"{line['fall_ms']:.0f} ms",
            "stays" if line["exit_s"] is None else f"{1e3 * line['exit_s']:.0f} ms",
            "never" if stable > 290 else f"{stable:.0f} N m/rad",
        ]

    return {"brake": [row(line) for line in lines]}


def _stiffness(lines: Lines) -> Tables:
    stable: dict[tuple[str, str], list[str]] = {}
    rows = []
    for line in lines:
        key = (line["board"], line["loop"])
        if "stable_nm_per_rad" in line:
            stable.setdefault(key, []).append(f"{line['stable_nm_per_rad']:g}")
        elif "off_nm_per_rad" in line:
            rows.append(
                [
                    f"`{line['board']}`, {line['rate_hz'] / 1e3:.0f} kHz",
                    line["loop"],
                    _lag(line["lag_us"]),
                    f"{line['bandwidth_hz'] / 1e3:.2g} kHz",
                    f"{1e3 * line['noise_nm']:g} mN m",
                    *stable[key],
                    *(f"{line[name]:g}" for name in ("off_nm_per_rad", "sagging_nm_per_rad")),
                ]
            )
    return {"current loops": rows}


def _binary(lines: Lines) -> Tables:
    ticks = [
        [
            f"`{line['board']}`",
            f"{line['instructions']:,}",
            f"{line['tick_time_ns'] / 1e3:.1f} us",
            _percent(line["tick_share"]),
            _percent(line["interrupt_share"]),
        ]
        for line in lines
        if line["scenario"] == "tick"
    ]
    return {"tick in a wall": ticks}


def _guards(lines: Lines) -> Tables:
    found: dict[str, dict[str, dict[str, Any]]] = {}
    for line in lines:
        if "off_ms" in line and "without_guard_a" in line:
            found.setdefault(line["danger"], {})[line["board"]] = line
    rows = []
    for danger, boards in found.items():
        if set(boards) == set(BOARDS):
            times = [f"{boards[board]['off_ms']:g} ms" for board in BOARDS]
            rows.append([danger, *("at once" if of == "0 ms" else of for of in times)])
    return {"guards": rows}


def _usb(lines: Lines) -> Tables:
    names = {"raw": "raw hidapi in C", "cpp": "C++", "python": "Python"}
    rows = {}
    for line in lines:
        if line["what"] == "round_trip":
            ratio = f"{line['median_ratio']:.3f}" if "median_ratio" in line else ""
            ms = [f"{line[key]:.3f} ms" for key in ("median_ms", "p99_ms")]
            rows[line["client"]] = [names[line["client"]], *ms, ratio]
        elif line["what"] == "telemetry":
            lost = line["samples_lost"] + line["samples_dropped"]
            cpu = _percent(line["reader_cpu_share"], 1)
            rows[line["client"]] += [f"{line['samples']:,}", str(lost), cpu]
    return {"usb": list(rows.values())}


PRINTERS: dict[str, Callable[[Lines], Tables]] = {
    "binary": _binary,
    "brake": _brake,
    "guards": _guards,
    "mcu": _mcu,
    "stiffness": _stiffness,
    "usb": _usb,
}


def where() -> str:
    """Say what measured: revision, date, machine and compiler."""

    def told(*command: str) -> str:
        return subprocess.run(
            command, cwd=TREE, capture_output=True, text=True, check=True
        ).stdout.strip()

    revision = told("git", "rev-parse", "--short=8", "HEAD")
    cpu = re.search(r"^model name\s*: (.+)$", Path("/proc/cpuinfo").read_text(), re.M)
    return (
        f"Revision {revision}, {time.strftime('%d %B %Y').lstrip('0')}, "
        f"{cpu[1] if cpu else platform.machine()} with {os.cpu_count()} processors, "
        f"GCC {told('gcc', '-dumpfullversion')}."
    )


def put(page: str, mark: str, rows: Iterable[list[str]], note: str) -> str:
    """Replace rows of the table at a mark, and its note.

    A row takes the place of the one with the same name, which two cells make for some tables. Cells
    beyond those given stay.
    """
    begin, end = f"<!-- begin: {mark} -->\n", f"<!-- end: {mark} -->"
    before, found, rest = page.partition(begin)
    table, closed, after = rest.partition(end)
    if not (found and closed):
        raise ValueError(f"{PAGE.name} has no marks for '{mark}'")
    lines = [line for line in table.splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]
    keys = 2 if mark in ("brake", "current loops") else 1
    places = {tuple(row[:keys]): number for number, row in enumerate(cells)}
    for row in rows:
        number = places.get(tuple(row[:keys]))
        if number is None:
            print(f"the table '{mark}' has no row '{', '.join(row[:keys])}'", file=sys.stderr)
            continue
        lines[number] = f"| {' | '.join([*row, *cells[number][len(row) :]])} |"
    return f"{before}{begin}{note}\n\n" + "\n".join(lines) + f"\n{end}{after}"


def main(name: str) -> None:
    """Read the lines of a benchmark, and print its tables into the page."""
    lines = [json.loads(line) for line in sys.stdin]
    page = PAGE.read_text(encoding="utf-8")
    for mark, rows in PRINTERS[name](lines).items():
        page = put(page, mark, rows, where())
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    if sys.argv[1:] and sys.argv[1] in PRINTERS:
        main(sys.argv[1])
    else:
        sys.exit(__doc__)
