"""Today's library drives released firmware, and reads and replays what was recorded of it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

import torsio
from tests.board import pico, released
from torsio import protocol

VERSIONS = sorted(folder.name for folder in released.RELEASES.iterdir())


@pytest.mark.parametrize("version", VERSIONS)
def test_library_drives_released_firmware(version: str, tmp_path: Path) -> None:
    image = released.unpacked(version, tmp_path)
    info, log = released.visit(image, tmp_path / "visit.mcap")
    assert (info.board, info.firmware_version) == (pico.chosen.name, version)
    inside = log["angle_rad"] > released.WALL_RAD
    depth_rad = log["angle_rad"][inside] - released.WALL_RAD
    assert np.max(depth_rad) > 0.03
    felt_nm = (log["spring_torque_nm"] + log["motor_command_nm"])[inside]
    error_nm = felt_nm + released.STIFFNESS_NM_PER_RAD * depth_rad
    assert float(np.sqrt(np.mean(error_nm**2))) < 5e-3


@pytest.mark.parametrize("version", VERSIONS)
def test_recording_of_released_firmware_is_read_and_replayed(version: str) -> None:
    file = released.RELEASES / version / f"{pico.chosen.image.stem}.mcap"
    told = []
    with file.open("rb") as stream:  # by another reader
        for _, _, message in make_reader(stream).iter_messages(topics="telemetry"):
            told.append(json.loads(message.data))
    samples = torsio.load(file).telemetry
    assert len(samples) == len(told) > 900
    for name in ("tick", "position_counts", "angle_rad", "motor_command_nm", "spring_torque_nm"):
        assert samples[name].tolist() == pytest.approx(
            [row[name] for row in told], rel=1e-6, abs=1e-9
        )
    replayed = torsio.replay(file)
    assert len(replayed.replayed) > 900
    largest = replayed.largest_differences()
    assert largest["position_counts"] == 0
    # Between two samples the replay takes the knob to turn evenly.
    assert max(largest["motor_command_nm"], largest["spring_torque_nm"]) < 1e-3


@pytest.mark.parametrize("version", VERSIONS)
def test_reports_of_released_firmware_are_the_begin_of_todays(version: str) -> None:
    today = released.layouts()
    kept = json.loads((released.RELEASES / version / "reports.json").read_text(encoding="utf-8"))
    for name, layout in kept.items():
        assert today[name][:2] == layout[:2], name
        now = today[name][2 : len(layout)]
        assert [field[:4] for field in now] == [field[:4] for field in layout[2:]], name
        for new, (field, *_, choices) in zip(now, layout[2:], strict=True):
            assert new[4][: len(choices)] == choices, f"{name}.{field}"


def test_library_lists_the_firmware_that_is_kept(tmp_path: Path) -> None:
    kept = {
        torsio.read_firmware(released.unpacked(version, tmp_path)).fingerprint
        for version in VERSIONS
    }
    assert kept == set(protocol.DRIVEN_FINGERPRINTS[1:])
