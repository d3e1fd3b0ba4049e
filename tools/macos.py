"""Compiles the device's code, emulated device, C++ library, its C interface and Python's for macOS.

``python -m tools.macos [ARCHITECTURE]...`` makes static libraries with Zig's compiler, by default
for both kinds of processor, and the objects of both interfaces. Parts that link to Apple's
IOKit are left out: hidapi and so every program. Nothing was ever run on a Mac.
"""

from __future__ import annotations

import platform
import re
import sys
from collections.abc import Sequence

import pybind11

from tools import wheel_pythons, wheels
from tools.wheel_commands import TREE, Failed, run, say
from tools.wheel_compilers import compilers

BUILD = TREE / "build/macos"
ARCHITECTURES = ("arm64", "x86_64")
LIBRARIES = ("core", "device", "emulator", "conversion", "sdk")
# Objects of an interface, to be linked to hidapi.
OBJECTS = re.compile(r"^build (\S*/(?:torsio_c|_torsio)\.dir/\S+\.o):", re.MULTILINE)
# Its declarations are all that the library is compiled with, and those are this system's.
HIDAPI_HEADERS = "/usr/include/hidapi"
HIDAPI = """\
add_library(hidapi::darwin INTERFACE IMPORTED GLOBAL)
target_include_directories(hidapi::darwin INTERFACE "{}")
"""


def build(architecture: str) -> None:
    """Compile for one kind of processor."""
    kind = f"macos_{architecture}"
    own = wheels.own_python()
    tools = compilers(BUILD / f"tools-{architecture}", kind, own)
    folder = BUILD / architecture
    declared = BUILD / "hidapi"
    declared.mkdir(parents=True, exist_ok=True)
    (declared / "hidapi-config.cmake").write_text(HIDAPI.format(HIDAPI_HEADERS), encoding="utf-8")
    # The newest Python has headers for both processors. CMake needs the same one of this machine.
    version = list(wheel_pythons.MAVEN)[-1]
    here = wheel_pythons.get(version, platform.machine(), own)
    settings = {
        **tools.settings,
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_UNITY_BUILD": "ON",
        # Whether it compiles is the question, not how fast it runs.
        "CMAKE_CXX_FLAGS_RELEASE": "-O0 -DNDEBUG",
        "CMAKE_OSX_SYSROOT": "/",
        "Python_EXECUTABLE": str(here.program),
        "Python_INCLUDE_DIR": str(wheel_pythons.headers(version, kind, own)),
        "PYTHON_MODULE_EXTENSION": ".so",
        "pybind11_DIR": pybind11.get_cmake_dir(),
        "TORSIO_BUILD_BINDINGS": "ON",
        "TORSIO_BUILD_EXAMPLES": "OFF",
        "TORSIO_BUILD_TESTS": "OFF",
        "TORSIO_INSTALL": "OFF",
        "hidapi_DIR": str(declared),
    }
    defines = [f"-D{name}={value}" for name, value in settings.items()]
    run(f"macos-{architecture}", "cmake", "-S", TREE, "-B", folder, "-G", "Ninja", *defines,
        **tools.variables)  # fmt: skip
    objects = OBJECTS.findall((folder / "build.ninja").read_text(encoding="utf-8"))
    targets = [*(f"torsio_{name}" for name in LIBRARIES), *objects]
    run(f"macos-{architecture}", "cmake", "--build", folder, "--target", *targets)
    say(f"all libraries, torsio.h and the Python module compile for macOS on {architecture}")


def main(arguments: Sequence[str]) -> int:
    """Compile for the kinds of processors that are asked for."""
    unknown = [name for name in arguments if name not in ARCHITECTURES]
    if unknown:
        print(f"torsio: error: no {unknown[0]}; there are {' '.join(ARCHITECTURES)}")
        return 2
    try:
        for architecture in arguments or ARCHITECTURES:
            say(f"macOS on {architecture}: compiling")
            build(architecture)
    except Failed as error:
        print(f"torsio: error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
