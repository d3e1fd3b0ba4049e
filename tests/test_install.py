"""An installed SDK serves a project that knows nothing of this tree."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

TREE = Path(__file__).parent.parent


def _run(*command: str | Path) -> str:
    result = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    if result.returncode != 0:
        pytest.fail(f"{command} failed:\n{result.stdout}", pytrace=False)
    return result.stdout


def test_find_package_torsio_builds_and_runs_a_program_outside_the_tree(tmp_path: Path) -> None:
    prefix, source, build = tmp_path / "prefix", tmp_path / "source", tmp_path / "build"
    shutil.copytree(TREE / "tests" / "install", source)
    _run("cmake", "--install", TREE / "build" / "release", "--prefix", prefix)
    # Installed headers must not need anything that was left behind.
    for header in sorted((prefix / "include").rglob("*.hpp")):
        _run("g++", "-std=c++20", "-fsyntax-only", "-I", prefix / "include", "-x", "c++", header)
    _run("cmake", "-S", source, "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}")
    _run("cmake", "--build", build)
    assert "inside the wall" in _run(build / "torsio_user")
