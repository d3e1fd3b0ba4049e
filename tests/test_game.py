"""The example game runs to its end without a screen, draws, and says what is wrong."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest

TREE = Path(__file__).parent.parent
PROGRAM = TREE / "build/asan-ubsan/examples/game/lockpick"
SECONDS = 60
# No joystick of whoever runs the tests.
ENVIRONMENT = os.environ | {"SDL_JOYSTICK_DEVICE": ""}


def _run(*arguments: str | Path, display: str = "dummy") -> subprocess.CompletedProcess[str]:
    if not PROGRAM.exists():
        pytest.fail(f"{PROGRAM.relative_to(TREE)} is not built; run ./dev test", pytrace=False)
    return subprocess.run(
        [PROGRAM, *arguments],
        capture_output=True,
        text=True,
        check=False,
        timeout=SECONDS,
        env=ENVIRONMENT | {"SDL_VIDEODRIVER": display},
    )


def _play(tmp_path: Path, *arguments: str) -> tuple[dict[str, Any], np.ndarray]:
    """Play without a window; return the report and the picture, shape (height, width, 3)."""
    report, picture = tmp_path / "report.json", tmp_path / "picture.bmp"
    result = _run("--headless", "--report", report, "--screenshot", picture, *arguments)
    assert (result.returncode, result.stderr) == (0, "")
    return json.loads(report.read_text()), matplotlib.image.imread(picture)


def _share(picture: np.ndarray, colour: tuple[int, int, int]) -> float:
    """Return how much of the picture is nearly of a colour."""
    distance = np.abs(picture[..., :3].astype(int) - colour).max(axis=-1)
    return float(np.mean(distance < 40))


def test_autopilot_opens_the_lock_and_the_picture_shows_it(tmp_path: Path) -> None:
    report, picture = _play(tmp_path)
    assert report["opened"] == 1
    assert report["dropped"] == 0
    assert report["knob"] is None
    assert 100 < report["frames"] < 3600
    assert picture.shape[:2] == (600, 960)
    green, amber = (96, 214, 140), (246, 178, 74)
    _, start = _play(tmp_path, "--frames", "1")
    # All pins are set now and none was at the start; the shear line and the knob's mark turn too.
    assert _share(picture, green) > 0.008
    assert _share(start, green) < 0.001
    assert _share(start, amber) > 0.0005


def test_every_run_is_the_same_and_every_seed_another(tmp_path: Path) -> None:
    one, picture = _play(tmp_path, "--frames", "200")
    two, again = _play(tmp_path, "--frames", "200")
    assert one == two
    assert np.array_equal(picture, again)
    _, other = _play(tmp_path, "--frames", "200", "--seed", "2")
    assert not np.array_equal(picture, other)


def test_window_shows_frames_and_the_picture_is_not_blank(tmp_path: Path) -> None:
    picture = tmp_path / "picture.bmp"
    result = _run("--no-joystick", "--frames", "5", "--screenshot", picture)
    assert result.returncode == 0
    assert _share(matplotlib.image.imread(picture), (190, 148, 72)) > 0.02  # brass


def test_without_a_knob_it_says_how_to_attach_the_virtual_one() -> None:
    result = _run("--frames", "1")
    assert result.returncode == 0
    assert "no knob found: play with mouse and keyboard" in result.stderr
    assert "usbip attach" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--fast",), "unknown option '--fast'"),
        (("--frames",), "--frames wants a value"),
        (("--frames", "0"), "--frames wants a number"),
        (("--frames", "2.5"), "--frames wants a number"),
        (("--range-deg", "nan"), "--range-deg wants a number"),
        (("--joystick", "-1"), "--joystick wants a number"),
    ],
)
def test_a_bad_option_is_refused_with_status_2(arguments: tuple[str, ...], words: str) -> None:
    result = _run(*arguments)
    assert result.returncode == 2
    assert words in result.stderr
    assert result.stderr.count("\n") == 1


def test_what_cannot_be_done_is_said_in_one_line(tmp_path: Path) -> None:
    nowhere = str(tmp_path / "no such folder" / "file")
    for arguments, words in (
        (("--headless", "--joystick", "200"), "there is no joystick 200"),
        (("--headless", "--frames", "1", "--screenshot", nowhere), "cannot write"),
        (("--headless", "--frames", "1", "--report", nowhere), "cannot write"),
    ):
        result = _run(*arguments)
        assert result.returncode == 1
        assert result.stderr.startswith("lockpick: ")
        assert words in result.stderr
        assert result.stderr.count("\n") == 1


@pytest.mark.parametrize("display", ["dummy", "offscreen"])
def test_a_display_that_nobody_sees_is_refused(display: str) -> None:
    result = _run(display=display)
    assert result.returncode == 1
    assert f"nobody would see the game: SDL has found only its '{display}' display" in result.stderr
    assert result.stderr.count("\n") == 1


def test_help_names_every_option_and_list_runs_without_a_display() -> None:
    text = _run("--help").stdout
    source = (TREE / "examples/game/options.cpp").read_text(encoding="utf-8")
    for option in {word.split('"')[0] for word in source.split('option == "')[1:]} - {"-h"}:
        assert option == "--help" or f"  {option}" in text
    assert _run("--list").returncode == 0
