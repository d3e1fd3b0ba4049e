"""Installs a wheel in the oldest system of the distribution's archive that its Python runs in.

``debootstrap`` makes it, without a compiler, and a Python from Maven Central stands beside it. A
virtual machine then plugs a knob in, which that Python opens through the wheel.
"""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from subprocess import CompletedProcess

from tools import apt
from tools.dev import fresh, running
from tools.wheel_commands import BUILD, finish, pip, run
from tools.wheel_pythons import MachinePython

# From 2021 on, oldest first; what Debian had before has gone from its archive.
SUITES = ("bullseye", "bookworm", "trixie")
USER = "nobody"
# Where its own user has installed the wheel, and where the wheels and Python are.
HOME, TRIAL = "/tmp/own", "/trial"
_FOLDER = BUILD / "oldest"
SYSTEM = _FOLDER / "system"


def try_out(wheel: Path, python: MachinePython, own: Path, first_steps: Path) -> str:
    """Install the wheel there, use it, and open a knob that is plugged into a machine."""
    trial = _FOLDER / "trial"
    as_root = running.become_root("the oldest system is made and entered by root", "./dev wheels")
    _FOLDER.mkdir(exist_ok=True)
    shutil.rmtree(trial, ignore_errors=True)
    # The folder of a Python is two above its program.
    shutil.copytree(python.program.parent.parent, trial / "python", symlinks=True)
    shutil.copy(first_steps, trial)
    run("oldest-pip", *pip(own), "download", "--only-binary", ":all:", "--dest", trial / "wheels",
        "--python-version", python.version, "--implementation", "cp",
        *(f"--platform={name}" for name in ("manylinux2014_x86_64", "manylinux_2_28_x86_64")),
        f"{wheel}[cli]")  # fmt: skip
    variables = {"HOME": "/tmp", "PATH": "/usr/bin:/bin", "LC_ALL": "C.UTF-8"}
    enter = [*as_root, *fresh.entering(SYSTEM, USER, {TRIAL: trial}, variables)]
    program = f"{TRIAL}/python/bin/python{python.version}"

    def start(suite: str) -> CompletedProcess[str]:
        base = _FOLDER / f"base-{suite}"
        fresh.make_base(base, suite, apt.system_archive(), as_root)
        run("oldest-remove", *as_root, "rm", "-rf", "--one-file-system", SYSTEM)
        run("oldest-copy", *as_root, "cp", "-a", base, SYSTEM)
        run("oldest-folder", *as_root, "mkdir", f"{SYSTEM}{TRIAL}")
        return finish(*enter, program, "--version")

    suite = first_that_runs(SUITES, start)
    if finish(*enter, "sh", "-c", "command -v cc gcc clang").returncode == 0:
        raise running.Failed(f"Debian {suite} has a compiler, so that this would show nothing")
    run("oldest-venv", *enter, program, "-m", "venv", HOME)
    install = ("install", "--no-index", "--find-links", f"{TRIAL}/wheels", "torsio[cli]")
    run("oldest-install", *enter, f"{HOME}/bin/python", "-m", "pip", *install)
    steps = ("-W", "error", f"{TRIAL}/{first_steps.name}")
    run("oldest", *enter, f"{HOME}/bin/python", *steps)
    run("oldest-command", *enter, f"{HOME}/bin/torsio", "info", "--device", "emulated")
    guest = (sys.executable, "-m", "tests.vm.wheel", SYSTEM, trial, python.version)
    told = run("oldest-guest", *guest)
    return f"Debian {suite}: installed; in a virtual machine, {told.splitlines()[-1]}"


def first_that_runs(suites: Sequence[str], start: Callable[[str], CompletedProcess[str]]) -> str:
    """Return the first of these systems in which a program starts.

    Raises
    ------
    Failed
        If it starts in none, or not in one for another reason than that its C library is too old.
    """
    for suite in suites:
        result = start(suite)
        if result.returncode == 0:
            return suite
        if not re.search(r"version `GLIBC_[\d.]+' not found", result.stdout):
            raise running.Failed(f"in Debian {suite} Python does not start:\n{result.stdout}")
    raise running.Failed(f"Python needs a newer Linux than Debian {suites[-1]}'s")
