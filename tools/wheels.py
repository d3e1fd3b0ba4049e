"""Builds the wheels: for every Python that is supported, for three kinds of machines, all inside.

``python -m tools.wheels --tinyusb FOLDER`` writes ``out/wheels/``; ``--arch``, ``--python`` choose.
Zig's compiler makes them (``tools/wheel_compilers.py``). Each is then tried where there is neither
tree nor compiler, wheels of other machines under QEMU or Wine (``tools/wheel_trials.py``).
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import sys
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path

from tools import hidapi_source, parts, sdist, wheel_pythons, wheel_trials
from tools.wheel_commands import BUILD, TREE, Failed, environment, pip, run, say
from tools.wheel_compilers import Compilers, compilers

# The sdist, unpacked: what a wheel is built of, so that the sdist lacks nothing.
SOURCE = BUILD / "source"
OUT = TREE / "out/wheels"
HOME = "x86_64"
ARCHITECTURES = (HOME, "aarch64", "win_amd64")
# Packages that build a wheel, in the versions that the tests have.
BUILT_WITH = re.compile(r'"((?:pybind11|scikit-build-core)==[^"]+)"')


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


def own_python() -> Path:
    """Return the Python of an environment with what makes and repairs wheels."""
    return environment(BUILD / "tools", Path(sys.executable), *parts.TOOLS)


def build(version: str, tools: Compilers, tinyusb: str, own: Path) -> Path:
    """Build one wheel, as it comes from the compiler."""
    name = f"{tools.architecture}-{version}"
    pins = BUILT_WITH.findall((TREE / "pyproject.toml").read_text(encoding="utf-8"))
    # A Python of this machine asks CMake for all, and the other machine's brings its headers.
    here = wheel_pythons.get(version, HOME, own)
    target = wheel_pythons.get(version, tools.architecture, own)
    builder = environment(BUILD / f"builder-{version}", here.program, *pins, "ninja==1.13.0")
    raw = BUILD / f"raw-{name}"
    shutil.rmtree(raw, ignore_errors=True)
    # One folder for all Pythons of a machine: the libraries are compiled once. CMake
    # forgets the last Python.
    objects = BUILD / f"objects-{tools.architecture}"
    (objects / "CMakeCache.txt").unlink(missing_ok=True)
    suffix = module_suffix(version, tools.architecture)
    bill = BUILD / "torsio.cdx.json"
    inside = parts.of_wheel(parts.components(Path(tinyusb)), is_windows=tools.is_windows)
    bill.write_text(parts.bill_of_materials(inside), encoding="utf-8")
    settings = {
        **tools.settings,
        "PYTHON_MODULE_EXTENSION": suffix,
        "Python_INCLUDE_DIR": str(target.include),
        "TORSIO_HIDAPI_SOURCE": str(hidapi_source.locate(TREE / "build/hidapi")),
        "TORSIO_BILL_OF_MATERIALS": str(bill),
        "TORSIO_INSTALL": "OFF",
        "TORSIO_TINYUSB_PATH": "" if tools.is_windows else tinyusb,
    }
    system = f"linux-{tools.architecture}"
    if target.library is not None:
        settings["Python_LIBRARY"] = str(target.library)
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
    """Check that a wheel lists its parts, and that one for Linux runs where it promises to."""
    with zipfile.ZipFile(wheel) as files:
        if not any(name.endswith("sboms/torsio.cdx.json") for name in files.namelist()):
            raise Failed(f"{wheel.name} has no list of its parts")
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


def build_all(architecture: str, versions: Sequence[str], tinyusb: str, own: Path) -> list[Path]:
    """Build a machine's wheels."""
    tools = compilers(BUILD / f"tools-{architecture}", architecture, own)
    wheels = []
    for version in versions:
        say(f"wheel for Python {version} on {architecture}: building")
        wheels.append(repair(build(version, tools, tinyusb, own), architecture, own))
        say(f"{wheels[-1].relative_to(TREE)}: {wheels[-1].stat().st_size / 1e6:.2f} MB")
    return wheels


def build_again(architecture: str, versions: Sequence[str], tinyusb: str, own: Path) -> None:
    """Build a machine's wheels from nothing, without what compilers keep, and compare the bytes.

    Raises
    ------
    Failed
        If they are others than before.
    """
    first = {wheel: wheel.read_bytes() for wheel in OUT.glob("*.whl")}
    shutil.rmtree(BUILD / f"objects-{architecture}")
    before = dict(os.environ)
    with tempfile.TemporaryDirectory() as kept:
        os.environ |= {"CCACHE_DISABLE": "1", "ZIG_GLOBAL_CACHE_DIR": kept}
        try:
            wheels = build_all(architecture, versions, tinyusb, own)
        finally:
            os.environ.clear()
            os.environ |= before
    for wheel in wheels:
        if wheel.read_bytes() != first[wheel]:
            raise Failed(f"{wheel.name} has other bytes when it is built again")
    say(f"the wheels for {architecture}, built again from nothing, have the same bytes")


def try_out(wheel: Path, version: str, architecture: str, own: Path) -> None:
    """Use a wheel on a machine of its kind."""
    python = wheel_pythons.get(version, architecture, own)
    say(f"{wheel.name}: trying it")
    if architecture == HOME:
        say(wheel_trials.at_home(wheel, python.program))
    else:
        say(wheel_trials.abroad(wheel, architecture, python, own))


def main(arguments: Sequence[str]) -> int:
    """Build and try what is asked for, by default all."""
    parser = argparse.ArgumentParser(prog="./dev wheels", allow_abbrev=False)
    parser.add_argument("--tinyusb", required=True, help=argparse.SUPPRESS)
    parser.add_argument("--arch", action="append", choices=ARCHITECTURES)
    parser.add_argument("--python", action="append", choices=wheel_pythons.MAVEN)
    parser.add_argument(
        "--twice", action="store_true", help="build each anew, and compare the bytes"
    )
    parser.add_argument("--no-try", action="store_true", help="do not install what was built")
    options = parser.parse_args(arguments)
    try:
        if os.uname().machine != HOME:
            raise Failed(f"the tools that make wheels are for {HOME} only")
        # So that a commit meanwhile does not make half of them of another day.
        os.environ["SOURCE_DATE_EPOCH"] = sdist.epoch()
        get_source()
        own = own_python()
        versions = options.python or [*wheel_pythons.MAVEN]
        for architecture in options.arch or ARCHITECTURES:
            made = build_all(architecture, versions, options.tinyusb, own)
            if options.twice:
                build_again(architecture, versions, options.tinyusb, own)
            if not options.no_try:
                for version, wheel in zip(versions, made, strict=True):
                    try_out(wheel, version, architecture, own)
    except (Failed, RuntimeError) as error:
        print(f"torsio: error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
