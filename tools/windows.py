"""Builds library, emulated device, C interface and tests for Windows, and runs them under Wine.

``python -m tools.windows [LAYER]...`` runs the C++ tests of these layers, by default all;
``python -m tools.windows python [ARGS]`` the Python package's, and hands ARGS to pytest.
docs/results.md lists what this cannot show: no knob has been plugged into a Windows.
"""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from tools import hidapi_source, windows_python
from tools.wheel_commands import Failed, finish

TREE = Path(__file__).parent.parent
BUILD = TREE / "build/windows"
LAYERS = ("core", "protocol", "device", "emulator", "sdk")
# Headers alone, which are the same for every system.
HEADERS = ("doctest", "nlohmann")
FELT = "the knob was pushed to 0.130 rad"
# Wine keeps its state here, opens no windows, and reports no missing parts.
WINE = {"WINEPREFIX": str(BUILD / "wine"), "WINEDEBUG": "-all", "DISPLAY": ""}


def run(*command: str | Path, show: bool = False) -> str:
    """Run a command at the top of the tree and return what it prints.

    Raises
    ------
    RuntimeError
        If it fails, with the end of its output.
    """
    result = finish(*command, **WINE)
    if show:
        print(result.stdout, end="", flush=True)
    if result.returncode != 0:
        end = "" if show else "\n".join(result.stdout.splitlines()[-40:]) + "\n"
        raise RuntimeError(f"{end}{command[0]} ended with status {result.returncode}")
    return result.stdout


def header_packages() -> Path:
    """Copy what is only headers from this system, so that nothing else of it is found."""
    host = BUILD / "host"
    for name in HEADERS:
        shutil.copytree(f"/usr/include/{name}", host / "include" / name, dirs_exist_ok=True)
    shutil.copytree("/usr/lib/cmake/doctest", host / "lib/cmake/doctest", dirs_exist_ok=True)
    targets = host / "lib/cmake/doctest/doctestTargets.cmake"
    text = targets.read_text(encoding="utf-8")
    targets.write_text(text.replace('_IMPORT_PREFIX "/usr"', f'_IMPORT_PREFIX "{host}"'))
    return host


def build(layers: Sequence[str]) -> None:
    """Configure and build the test programs of these layers, and the C library."""
    host = header_packages()
    settings = {
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_TOOLCHAIN_FILE": TREE / "cmake/Mingw.cmake",
        # Assertions stay, and a test compiles in half of the time.
        "CMAKE_CXX_FLAGS_RELEASE": "-O1",
        "CMAKE_CXX_FLAGS": f"-isystem {host / 'include'}",
        "doctest_DIR": host / "lib/cmake/doctest",
        "TORSIO_BUILD_EXAMPLES": "OFF",
        "TORSIO_HIDAPI_SOURCE": hidapi_source.locate(TREE / "build/hidapi"),
        "TORSIO_INSTALL": "OFF",
        "TORSIO_WERROR": "ON",
    }
    defines = [f"-D{name}={value}" for name, value in settings.items()]
    run("cmake", "-S", TREE, "-B", BUILD / "cmake", "-G", "Ninja", *defines)
    targets = [f"torsio_{layer}_tests" for layer in layers]
    run("cmake", "--build", BUILD / "cmake", "--target", "torsio_c", *targets)


def run_c_example() -> None:
    """Compile the example in C against the library that was built, and run both."""
    program = BUILD / "feel_a_wall.exe"
    library = BUILD / "cmake/sdk/c"
    include = TREE / "sdk/c/include"
    strict = ("-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic")
    source = TREE / "examples/c/feel_a_wall.c"
    run(
        "x86_64-w64-mingw32-gcc-posix", *strict, f"-I{include}", source, "-o", program,
        library / "libtorsio.dll.a",
    )  # fmt: skip
    shutil.copy(library / "torsio.dll", BUILD)
    if FELT not in run("wine", program, show=True):
        raise RuntimeError("the example in C did not feel its wall under Wine")


def fault_of(layer: str) -> str:
    """Run a layer's tests; return what is wrong, or nothing."""
    program = next((BUILD / "cmake/tests/cpp").glob(f"torsio_{layer}_tests.exe"))
    print(f"torsio: {layer} under Wine", flush=True)
    try:
        told = run("wine", program, "--no-colors=true", "--no-skip", show=True)
    except RuntimeError as error:
        return f"{layer}: {error}"
    if not re.search(r"test cases:\s+[1-9]\d* \|\s+\d+ passed \| 0 failed", told):
        return f"{layer}: did not say that its tests passed"
    return ""


def main(arguments: Sequence[str]) -> int:
    """Build and run; return 1 if anything fails."""
    if arguments[:1] == ["python"]:
        try:
            return windows_python.test(arguments[1:])
        except (Failed, RuntimeError) as error:
            print(f"torsio: error: {error}", file=sys.stderr)
            return 1
    unknown = [name for name in arguments if name not in LAYERS]
    if unknown:
        print(f"torsio: error: no layer {unknown[0]}; there are {' '.join(LAYERS)}")
        return 2
    layers = arguments or LAYERS
    failed: list[str] = []
    try:
        print("torsio: C++ (Windows): building", flush=True)
        build(layers)
        failed += filter(None, map(fault_of, layers))
        run_c_example()
    except RuntimeError as error:
        failed.append(str(error))
    for line in failed:
        print(f"torsio: error: {line}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
