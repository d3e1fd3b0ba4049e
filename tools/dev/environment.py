"""The virtual environment ``.venv``, filled with what a command needs."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import sys
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path

from tools.dev import packages, running
from tools.dev.running import TREE, Failed, later, run_logged, say, stamp_is, stamped, succeeds

VENV = TREE / ".venv"
PYTHON = VENV / "bin/python"
# Its tree and the interpreter that it was made with; the script ``dev`` reads it too.
MADE_WITH = VENV / ".python"
# What the environment is filled with: a demo does not wait for what only tests and studies need.
DEMO, PAGE, ALL = "demo", "page", "all"
# Groups of system packages that CMake's presets are compiled with.
COMPILING = ("base", "tests", "game")


def pip_install(*arguments: str | os.PathLike[str]) -> list[str]:
    """Return the command that installs with pip, into the environment."""
    pip = [str(PYTHON), "-m", "pip", "--disable-pip-version-check", "--no-input", "--retries", "5"]
    return [*pip, "install", *(os.fspath(argument) for argument in arguments)]


def _make() -> None:
    """Make the environment, unless it is whole.

    It holds absolute paths: one that was copied with its tree is made anew.
    """
    made_with = f"{TREE}\n{sys.executable}\n"
    if stamp_is(MADE_WITH, made_with) and succeeds(PYTHON, "-c", ""):
        return
    shutil.rmtree(VENV, ignore_errors=True)
    say(f"Python: making .venv with {sys.executable}")
    run_logged("venv", [sys.executable, "-m", "venv", VENV])
    # Older ones take no more than one setting of a kind for a build.
    run_logged("pip-upgrade", pip_install("pip>=24"))
    MADE_WITH.write_text(made_with, encoding="utf-8")


def _fill(group: str) -> None:
    key = hashlib.sha256((TREE / "pyproject.toml").read_bytes()).hexdigest()
    if any(stamp_is(VENV / f".has-{name}", key) for name in {group, ALL}):
        say("Python environment: up to date")
        return
    say("Python: installing dependencies")
    with stamped(VENV / f".has-{group}", key):
        files = {}
        for name in (group, "pins"):
            files[name] = VENV / f"{name}.txt"
            lines = running.output_of(PYTHON, "-m", "tools.dev.requirements", name)
            if not lines:
                raise Failed("pyproject.toml cannot be read")
            files[name].write_text(lines, encoding="utf-8")
        # The versions are those that are tested, whatever part of them is installed.
        run_logged("pip", pip_install("--requirement", files[group], "--constraint", files["pins"]))


def _has_recent_cmake() -> bool:
    """Older distributions, such as Ubuntu 22.04, ship a CMake without the presets used here."""
    found = re.search(r"(\d+)\.(\d+)", running.output_of("cmake", "--version"))
    return found is None or (int(found[1]), int(found[2])) >= (3, 25)


def make_ros() -> None:
    """Make an environment with ROS 2, unless it is whole.

    It is one of its own: with ROS's packages, dozens of them, every Python starts twice.

    Raises
    ------
    Failed
        If it cannot be made.
    """
    folder = TREE / "build/ros"
    needed = TREE / "tests/ros/requirements.txt"
    stamp = folder / ".installed"
    key = f"{TREE}\n{sys.executable}\n{needed.read_text(encoding='utf-8')}"
    if stamp_is(stamp, key):
        say("ROS 2: up to date")
        return
    say("ROS 2: installing into build/ros")
    shutil.rmtree(folder, ignore_errors=True)
    with stamped(stamp, key):
        pip = (folder / "bin/python", "-m", "pip", "--disable-pip-version-check", "--no-input")
        # Of some packages the newest version is there as sources alone.
        install = ("install", "--retries", "5", "--prefer-binary", "--requirement", needed)
        run_logged("ros", [sys.executable, "-m", "venv", folder], [*pip, *install])


def make_hardware() -> Path:
    """Make an environment that draws and computes elements, unless it is whole; return its Python.

    It is one of its own, which sees the packages of ``.venv`` behind its own: what draws solids
    takes half a gigabyte.

    Raises
    ------
    Failed
        If it cannot be made.
    """
    folder = TREE / "build/hardware"
    stamp = folder / ".installed"
    needed = TREE / "hardware/pyproject.toml"
    key = f"{TREE}\n{sys.executable}\n{needed.read_text(encoding='utf-8')}"
    python = folder / "bin/python"
    if stamp_is(stamp, key):
        say("hardware: up to date")
        return python
    say("hardware: installing what draws and computes elements into build/hardware")
    shutil.rmtree(folder, ignore_errors=True)
    with stamped(stamp, key):
        pip = (python, "-m", "pip", "--disable-pip-version-check", "--no-input", "install")
        versions = ("build123d==0.13.0", "scikit-fem==12.0.2", "matplotlib==3.10.9")
        run_logged("hardware", [sys.executable, "-m", "venv", folder], [*pip, *versions])
        packages_of = running.output_of(
            PYTHON, "-c", "import site; print(site.getsitepackages()[0])"
        )
        seen = running.output_of(python, "-c", "import site; print(site.getsitepackages()[0])")
        lines = [str(TREE / "hardware/python"), packages_of.strip()]
        (Path(seen.strip()) / "torsio.pth").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return python


@dataclass(frozen=True)
class SetUp:
    """What still comes, in the background, while C++ can be compiled already."""

    system: Future[None]
    python: Future[None]

    def finish(self) -> None:
        """Wait for all of it.

        Raises
        ------
        Failed
            If something cannot be had; says what to do.
        """
        self.python.result()
        self.system.result()


def begin(*groups: str, python: str = ALL) -> SetUp:
    """Install what is missing: system packages of these groups, and the environment.

    The one comes from the distribution and the other from PyPI, so they come at the same time; what
    compiles the libraries and their tests comes first, and is there when this returns.

    Raises
    ------
    Failed
        If something cannot be had; says what to do.
    """
    first = [name for name in ("base", *groups) if name in COMPILING]
    compilers, system = packages.begin_set_up(first, groups)
    os.environ["PATH"] = f"{VENV / 'bin'}{os.pathsep}{os.environ.get('PATH', os.defpath)}"

    def fill() -> None:
        _make()
        _fill(python)

    environment = later(fill)
    compilers.result()
    if not _has_recent_cmake():
        environment.result()
        say("Python: installing a newer CMake")
        run_logged("pip-cmake", pip_install("cmake==3.31.10"))
    return SetUp(system, environment)


def set_up(*groups: str, python: str = ALL) -> None:
    """Install what is missing, all of it; see ``begin``."""
    begin(*groups, python=python).finish()
