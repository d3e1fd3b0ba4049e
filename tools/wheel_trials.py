"""Installs a wheel where there is neither tree nor compiler, and does what a user does first.

On this machine in a new environment of the Python that it is for; for other machines beside a
Python of theirs, which runs under QEMU or Wine.
"""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path

from tools.wheel_commands import BUILD, TREE, Failed, environment, finish, pip, run
from tools.wheel_pythons import MachinePython

FIRST_STEPS = TREE / "tools/first_steps.py"
# pip's names for the systems of other packages' wheels, such as NumPy's.
PLATFORMS = {
    "aarch64": ("manylinux2014_aarch64", "manylinux_2_27_aarch64", "manylinux_2_28_aarch64"),
    "win_amd64": ("win_amd64",),
}
PICTURE = "virtual_wall.png"
PICTURE_AIM_S = 20


def at_home(wheel: Path, python: Path) -> str:
    """Install the wheel with command line and pictures, draw one, and tell how long that took.

    As for a new user, pip and Matplotlib have kept nothing yet.

    Raises
    ------
    Failed
        If something does not work, or takes more processor time than is the aim.
    """
    folder = BUILD / "trial"
    shutil.rmtree(folder, ignore_errors=True)
    own = environment(folder, python)
    home = folder / "home"
    home.mkdir()
    bare = {
        **{"PATH": str(folder / "bin"), "CC": "/none", "CXX": "/none", "PYTHONPATH": ""},
        **{"HOME": str(home), "XDG_CACHE_HOME": str(home), "MPLCONFIGDIR": str(home)},
    }
    steps = shutil.copy(FIRST_STEPS, folder)
    begin_s, begun = time.monotonic(), os.times()
    install = ("install", "--no-cache-dir", "--only-binary", ":all:", f"{wheel}[cli,plot]")
    run("trial-pip", *pip(own), *install, **bare)
    command = (own, "-m", "torsio", "demo", "wall", "--device", "emulated", "--out", folder)
    run("trial-demo", *command, **bare)
    took_s, done = time.monotonic() - begin_s, os.times()
    # On a machine that others use too the clock says little.
    own_s = sum(done[2:4]) - sum(begun[2:4])
    if own_s > PICTURE_AIM_S:
        raise Failed(
            f"from pip install to the first picture it took {own_s:.1f} s of processor time, and "
            f"the aim is {PICTURE_AIM_S} s"
        )
    assert (folder / PICTURE).stat().st_size > 0
    told = run("trial", own, "-W", "error", steps, **bare)
    run("trial-command", folder / "bin/torsio", "--version", **bare)
    ask_doctor(folder / "bin/torsio", **bare)
    run("trial-virtual-knob", _virtual_knob(own), "--help", **bare)
    took = (
        f"from pip install to the first picture {took_s:.0f} s, of them {own_s:.1f} s of processor "
        f"time; the aim is {PICTURE_AIM_S} s"
    )
    return f"{told.splitlines()[-1]}; {took}"


def _virtual_knob(python: Path) -> Path:
    asked = "from torsio.virtual_knob import program_path; print(program_path())"
    return Path(run("trial-program", python, "-c", asked).strip())


def abroad(wheel: Path, architecture: str, python: MachinePython, own: Path) -> str:
    """Unpack the wheel and what it needs beside a Python of its machine, and use it there."""
    site = BUILD / f"trial-{architecture}"
    shutil.rmtree(site, ignore_errors=True)
    platforms = [f"--platform={name}" for name in PLATFORMS[architecture]]
    kind = ("--only-binary=:all:", f"--python-version={python.version}", "--implementation=cp")
    run(f"trial-{architecture}-pip", *pip(own), "install", *kind, *platforms,
        "--target", site, f"{wheel}[cli]")  # fmt: skip
    there = wine_path if architecture == "win_amd64" else str
    variables = {**python.variables, "PYTHONPATH": there(site)}
    steps = there(Path(shutil.copy(FIRST_STEPS, site)))
    told = run(f"trial-{architecture}", *python.command, "-W", "error", steps, **variables)
    for words in (("--version",), ("info", "--device", "emulated"), ("list",)):
        run(f"trial-{architecture}-command", *python.command, "-m", "torsio", *words, **variables)
    ask_doctor(*python.command, "-m", "torsio", **variables)
    if architecture != "win_amd64":
        program = site / "torsio/bin/torsio_virtual_knob"
        run(f"trial-{architecture}-virtual-knob", *python.runner, program, "--help")
    return f"{told.splitlines()[-1]}; {python.runner[0]} ran it"


def ask_doctor(*torsio: str | Path, **variables: str) -> None:
    """Have `torsio doctor` look for knobs, and at the emulated one; it may find problems.

    Mostly no knob is plugged in, and emulated time cannot keep up under QEMU or Wine.
    """
    answers = {(): "usb", ("--device", "emulated"): "it answers after"}
    for words, part in answers.items():
        result = finish(*torsio, "doctor", *words, **variables)
        told = " ".join(result.stdout.split())
        if result.returncode not in (0, 1) or part not in told or "Traceback" in told:
            raise Failed(f"torsio doctor {' '.join(words)} said nothing of use:\n{result.stdout}")


def wine_path(path: Path) -> str:
    """Return a path as Wine has it, which shows this machine's files as a drive."""
    return f"Z:{path}".replace("/", "\\")
