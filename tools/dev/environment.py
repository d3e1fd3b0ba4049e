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
# Contents of the environment. A demo does not wait for the packages of tests and studies.
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


def _beside(name: str, what: str, needed: Path, *versions: str | Path, sees: str = "") -> Path:
    """Make an environment ``build/NAME`` of its own, unless it is whole; return its Python.

    Parameters
    ----------
    what
        It is for.
    needed
        A file whose change makes it anew.
    versions
        For pip, which installs them.
    sees
        A folder of the tree. Its packages come first, then the packages of ``.venv``.
    """
    folder = TREE / "build" / name
    stamp, python = folder / ".installed", folder / "bin/python"
    key = f"{TREE}\n{sys.executable}\n{needed.read_text(encoding='utf-8')}"
    if stamp_is(stamp, key):
        say(f"{what}: up to date")
        return python
    say(f"{what}: installing into build/{name}")
    shutil.rmtree(folder, ignore_errors=True)
    with stamped(stamp, key):
        pip = (python, "-m", "pip", "--disable-pip-version-check", "--no-input", "install")
        venv: list[str | Path] = [sys.executable, "-m", "venv", folder]
        # Some packages have their newest version as sources only.
        run_logged(name, venv, [*pip, "--retries", "5", "--prefer-binary", *versions])
        if sees:
            of = "import site; print(site.getsitepackages()[0])"
            behind, own = (running.output_of(each, "-c", of).strip() for each in (PYTHON, python))
            (Path(own) / "torsio.pth").write_text(f"{TREE / sees}\n{behind}\n", encoding="utf-8")
    return python


def make_ros() -> Path:
    """Make an environment with ROS 2: with its packages, dozens, every Python starts twice.

    Raises
    ------
    Failed
        If it cannot be made; so do the others.
    """
    needed = TREE / "tests/ros/requirements.txt"
    return _beside("ros", "ROS 2", needed, "--requirement", needed)


def make_hardware() -> Path:
    """Make an environment that draws and computes elements: what draws takes half a gigabyte."""
    versions = ("build123d==0.13.0", "scikit-fem==12.0.2", "matplotlib==3.10.9")
    needed = TREE / "hardware/pyproject.toml"
    return _beside("hardware", "hardware", needed, *versions, sees="hardware/python")


def make_learning() -> Path:
    """Make an environment with PyTorch for an example: it takes five gigabytes."""
    versions = ("stable-baselines3==2.9.2", "torch==2.15.0")
    needed = TREE / "examples/learning/learn_with_sb3.py"
    return _beside("learning", "PyTorch", needed, *versions, sees="examples")


def make_pyright() -> Path:
    """Make an environment with editors' type checker, which fetches its code when it runs first."""
    needed = TREE / "tests/test_guides.py"
    return _beside("pyright", "pyright", needed, "pyright==1.1.414")


def make_players() -> Path:
    """Make an environment with libraries of players' programs: they bring builds of SDL."""
    sdl = ("pygame==2.6.1", "PySDL2==0.9.17", "pysdl2-dll==2.32.10")
    versions = (*sdl, "pyglet==2.1.19", "hid-parser==0.1.0")
    return _beside("players", "players' libraries", Path(__file__), *versions)


@dataclass(frozen=True)
class SetUp:
    """Downloads that still run in the background while C++ is compiled."""

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
