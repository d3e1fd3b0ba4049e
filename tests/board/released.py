"""Released firmware, kept with its reports and a recording of each board.

``python -m tests.board.released`` keeps the built firmware under the version in ``CMakeLists.txt``.
Run it when you make a release, and never again for that version.
"""

from __future__ import annotations

import json
import lzma
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import torsio
from tests.board import felt, pico
from tests.board.live import live_knob
from torsio import protocol
from torsio.printed.told import DeviceInfo
from torsio.telemetry import Record

RELEASES = pico.FOLDER / "releases"
STIFFNESS_NM_PER_RAD, WALL_RAD, DEEPEST_RAD = 1.5, 0.05, 0.11
MOVE_S, HOLD_S = 0.12, 0.04


def unpacked(release: str, folder: Path) -> Path:
    """Write the chosen board's firmware of a release into a folder."""
    image = folder / pico.chosen.image.name
    image.write_bytes(lzma.decompress((RELEASES / release / f"{image.name}.xz").read_bytes()))
    return image


@contextmanager
def plain_board(image: Path) -> Iterator[pico.EmulatedPico]:
    """Give a board with this firmware that has booted and nothing more."""
    with pico.EmulatedPico(image=image) as board:
        board.boot()
        board.enumerate()
        yield board


def visit(image: Path, recording: Path) -> tuple[DeviceInfo, Record]:
    """Push into a wall with a firmware, and record it; the library alone speaks to the board."""
    params = felt.plant_of(pico.chosen.name)
    with live_knob(params, lambda: plain_board(image)) as (knob, place), knob.record_to(recording):
        knob.update(confirmed=True)
        knob.update(values_are="stated")
        knob.update(law="compensated", passive_ramp_s=0.005, speed_limit_rad_s=100.0)
        knob.play(torsio.Wall(angle_rad=WALL_RAD, stiffness_nm_per_rad=STIFFNESS_NM_PER_RAD))
        knob.arm()
        begin_s, end_s = place.time_s, place.time_s + 2 * MOVE_S + HOLD_S
        place.set_hand(
            torsio.ImpedanceHand(
                stiffness_nm_per_rad=10.0, damping_nm_s_per_rad=10e-3, inertia_kg_m2=1e-4,
                intended_angle_rad=[
                    (begin_s, 0.0), (begin_s + MOVE_S, DEEPEST_RAD),
                    (end_s - MOVE_S, DEEPEST_RAD), (end_s, 0.0),
                ],
            )
        )  # fmt: skip
        log = knob.record(end_s - begin_s)
        assert (knob.state, knob.faults()) == ("armed", ())
        knob.disarm()
        return knob.info, log


def layouts() -> dict[str, list[Any]]:
    """Give each report's id and direction, then its fields as on the wire."""

    def flat(fields: list[dict[str, Any]]) -> Iterator[list[Any]]:
        for field in fields:
            told = [field[key] for key in ("name", "type", "unit", "count")]
            yield [*told, field.get("choices", [])]
            yield from flat(field.get("fields", []))

    return {
        report["name"]: [report["id"], report["direction"], *flat(report["fields"])]
        for report in protocol.reports()
    }


def _keep() -> None:
    for name in pico.MODELS:
        pico.choose(name)
        image = pico.chosen.image
        folder = RELEASES / torsio.read_firmware(image).version
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{image.name}.xz").write_bytes(lzma.compress(image.read_bytes(), preset=9))
        visit(image, folder / f"{image.stem}.mcap")
        rows = [f"{json.dumps(name)}: {json.dumps(one)}" for name, one in layouts().items()]
        (folder / "reports.json").write_text("{\n" + ",\n".join(rows) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    _keep()
