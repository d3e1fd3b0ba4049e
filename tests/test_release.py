"""The parts of a release: sdist, archives, checksums, list of parts, Pythons of others."""

from __future__ import annotations

import re
import subprocess
import sys
import tarfile
from pathlib import Path

from tools import sdist, wheel_pythons, wheel_trials

TREE = Path(__file__).parent.parent


def test_there_is_a_wheel_for_each_python_that_the_package_names() -> None:
    text = (TREE / "pyproject.toml").read_text(encoding="utf-8")
    named = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', text)
    assert named == [*wheel_pythons.MAVEN]
    assert f'requires-python = ">={named[0]}"' in text


def test_two_sdists_have_the_same_bytes_and_all_that_a_wheel_is_built_of(tmp_path: Path) -> None:
    made = []
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        made.append(sdist.make(tmp_path / name))
    assert made[0].read_bytes() == made[1].read_bytes()
    with tarfile.open(made[0]) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    # Files that `./dev build python` reads. The full proof: every wheel is built from an sdist.
    tracked = subprocess.run(
        ["git", "ls-files", "firmware", "emulator", "sdk", "bindings", "cmake"],
        cwd=TREE, capture_output=True, text=True, check=True,
    ).stdout.split()  # fmt: skip
    assert {name for name in tracked if (TREE / name).exists()} <= names
    assert not any(name.startswith(("tests/", "build/", "studio/")) for name in names)

    source = tmp_path / "source"
    assert sdist.unpack(made[0], source)
    assert not sdist.unpack(made[1], source)
    assert (source / "pyproject.toml").read_bytes() == (TREE / "pyproject.toml").read_bytes()


def test_first_steps_succeed_with_the_package_that_is_installed(tmp_path: Path) -> None:
    steps = [sys.executable, "-W", "error", str(wheel_trials.FIRST_STEPS)]
    told = subprocess.run(steps, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    # 50 mN m into 1.4 N m/rad from 0.1 rad, less the knob's own friction: README says 0.130.
    assert "pushed the knob to 0.130 rad" in told
