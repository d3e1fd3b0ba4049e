"""The lines that a page shows of a scene: Python's play that scene, and C++'s compile."""

from __future__ import annotations

import json
import subprocess
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

import torsio

TREE = Path(__file__).parents[2]
TIMING = torsio.Timing(
    delay_s=0.1, duration_s=1, attack_level=0.5, attack_s=0.2, fade_level=0.25, fade_s=0.3
)
# Every kind, with no field at its default.
EFFECTS: list[Any] = [
    torsio.Wall(angle_rad=-0.3, side="below", stiffness_nm_per_rad=1.4, damping_nm_s_per_rad=2e-3),
    torsio.Spring(angle_rad=0.2, stiffness_nm_per_rad=0.1, deadband_rad=0.01, torque_limit_nm=0.05),
    torsio.Damper(damping_nm_s_per_rad=2e-7, torque_limit_nm=0.05),
    torsio.Friction(torque_nm=0.02, stiffness_nm_per_rad=2),
    torsio.Inertia(inertia_kg_m2=5e-5, torque_limit_nm=0.05),
    torsio.Constant(torque_nm=-0.02, timing=TIMING),
    torsio.Ramp(start_torque_nm=0.01, end_torque_nm=0.04, timing=TIMING),
    torsio.Periodic(
        waveform="sawtooth_down",
        amplitude_nm=0.02,
        offset_nm=0.01,
        frequency_hz=2,
        phase_turns=0.25,
        timing=TIMING,
    ),
    torsio.Detents(angle_rad=0.1, per_turn=24, torque_nm=0.03, profile="click", width=0.25),
    torsio.Detents(pitch_rad=0.2, torque_nm=0.03),
    torsio.EndStops(
        lower_rad=-0.8, upper_rad=0.8, stiffness_nm_per_rad=1.4, damping_nm_s_per_rad=1e-3
    ),
    torsio.Texture(grains_per_turn=120, torque_nm=0.01, grain="square", seed=7),
    torsio.Curve(torque_nm=[0, 0.03, -0.03], angle_rad=0.1, span_rad=2, ends="repeat"),
    torsio.Impact(
        angle_rad=0.25, side="below", strength_nm_s_per_rad=0.02, frequency_hz=250, pulse_s=0.01
    ),
]
SCENES: list[list[Any]] = [[], *([effect] for effect in EFFECTS), EFFECTS]


def _kind(effect: Any) -> str:
    return "end_stops" if isinstance(effect, torsio.EndStops) else type(effect).__name__.lower()


@pytest.fixture(scope="module")
def lines() -> list[dict[str, str]]:
    """Have the page's code write all of them."""
    scenes = [[{"type": _kind(effect), **asdict(effect)} for effect in scene] for scene in SCENES]
    # A field that is empty on the page is not there.
    given = json.dumps(
        [[{k: v for k, v in e.items() if v is not None} for e in scene] for scene in scenes]
    )
    done = subprocess.run(
        ["node", Path(__file__).parent / "lines.mjs"],
        input=given,
        capture_output=True,
        text=True,
        check=True,
    )
    written: list[dict[str, str]] = json.loads(done.stdout)
    return written


def test_lines_of_python_play_every_effect(lines: list[dict[str, str]]) -> None:
    for scene, written in zip(SCENES, lines, strict=True):
        played: list[object] = []
        exec(
            written["python"], {"torsio": torsio, "knob": type("Knob", (), {"play": played.append})}
        )
        assert played == [scene[0] if len(scene) == 1 else scene]


def test_lines_of_cpp_compile_for_every_effect(lines: list[dict[str, str]], tmp_path: Path) -> None:
    bodies = "".join(f"{{\n{written['cpp']}}}\n" for written in lines)
    source = tmp_path / "lines.cpp"
    source.write_text(f'#include "torsio/knob.hpp"\nvoid play(torsio::Knob& knob) {{\n{bodies}}}\n')
    # That one is made by the build.
    made = tmp_path / "torsio/export.hpp"
    made.parent.mkdir()
    made.write_text("#define TORSIO_EXPORT\n")
    folders = (TREE / "sdk/include", TREE / "emulator/include", tmp_path)
    includes = [f"-I{folder}" for folder in folders]
    strictly = ("-std=c++20", "-Wall", "-Wextra", "-Wno-missing-field-initializers", "-Werror")
    done = subprocess.run(
        ["g++", *strictly, "-fsyntax-only", *includes, source],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
