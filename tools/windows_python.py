"""Runs the Python package's tests under Wine, on the wheel for Windows.

pip installs the wheel under Wine, so that the command ``torsio`` is there as on Windows. What the
tests need beside it is fetched here. ``tests/windows_plugin.py`` says what cannot run there.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from tools import wheel_pythons, wheels
from tools.wheel_commands import TREE, pip, run, say
from tools.wheel_pythons import MachinePython
from tools.wheel_trials import wine_path

VERSION = "3.13"
SITE = TREE / "build/windows/site"
# Packages that the tests import, in the versions of other systems.
_NEEDED = (
    "gymnasium", "hypothesis", "jsonschema", "matplotlib", "mcap", "numpy", "pyarrow", "pytest",
    "rich", "scipy", "starlette", "typer", "uvicorn", "websockets",
)  # fmt: skip


def packages() -> list[str]:
    """Return what pip is to fetch, with the versions of ``pyproject.toml``."""
    text = (TREE / "pyproject.toml").read_text(encoding="utf-8")
    # Where Pythons need different ones, the newest Python's stands last.
    pins = dict(re.findall(r'"([\w-]+)==([^";]+)', text))
    return [f"{name}=={pins[name]}" for name in _NEEDED]


def install(wheel: Path, own: Path, python: MachinePython) -> None:
    """Fill `SITE` with the wheel and what the tests need."""
    shutil.rmtree(SITE, ignore_errors=True)
    kind = ("--only-binary=:all:", f"--python-version={VERSION}", "--implementation=cp")
    run("windows-packages", *pip(own), "install", *kind, "--platform=win_amd64",
        "--target", SITE, *packages())  # fmt: skip
    here = SITE.with_name("wheel")
    shutil.rmtree(here, ignore_errors=True)
    run("windows-pip", *python.command, "-m", "pip", "install", "--no-deps", "--no-index",
        "--target", wine_path(here), wine_path(wheel), **python.variables)  # fmt: skip
    # Tests look for the command where Python is.
    (here / "bin/torsio.exe").replace(python.program.with_name("torsio.exe"))
    shutil.copytree(here, SITE, dirs_exist_ok=True)


def test(arguments: Sequence[str]) -> int:
    """Build the wheel, install it and run its tests; return pytest's status."""
    wheels.get_source()
    own = wheels.own_python()
    (wheel,) = wheels.build_all("win_amd64", [VERSION], "", own)
    python = wheel_pythons.get(VERSION, "win_amd64", own)
    install(wheel, own, python)
    say("Python under Wine")
    variables = {"PYTHONPATH": wine_path(SITE), "PYTHONDONTWRITEBYTECODE": "1"}
    options = ("-u", "-m", "pytest", "-p", "tests.windows_plugin", "-p", "no:cacheprovider")
    with subprocess.Popen(
        [*python.command, *options, *(arguments or ("tests/python",))],
        cwd=TREE,
        env={**os.environ, **python.variables, **variables},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    ) as tests:
        assert tests.stdout is not None
        for line in tests.stdout:
            print(line.decode(errors="replace").rstrip(), flush=True)
    return tests.returncode
