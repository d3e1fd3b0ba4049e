"""Builds the studio: the emulated device as WebAssembly, and the page, in ``build/studio/page``.

``python -m tools.studio [--wasm | --page]``, or ``./dev studio``. WebAssembly is compiled by Zig's
C++ compiler, which comes from PyPI with libraries of its own; the page is bundled by esbuild.
"""

from __future__ import annotations

import itertools
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

TREE = Path(__file__).parent.parent
STUDIO = TREE / "studio"
BUILD = TREE / "build/studio"
PAGE = BUILD / "page"

# Sources of the page's emulated device, without simulate() and the like.
_FOLDERS = ("firmware/core", "firmware/device", "emulator/plant", "studio/wasm")
_FILES = ("emulated_device", "encoder", "power_path", "usb_link")
_INCLUDED = ("firmware", ".", "emulator/include", "sdk")
# As on every other machine: no contracted multiply-adds, so that it computes the same bits.
_FLAGS = (
    *("-target", "wasm32-wasi", "-mexec-model=reactor", "-std=c++20", "-O2", "-g0", "-s"),
    *("-ffp-contract=off", "-DNDEBUG", "-Wall", "-Wextra", "-Werror", "-Wno-missing-braces"),
)
# The page's modules that need no browser.
MODULES = (
    *("codec", "conversion", "emulated_device", "energies", "games", "knob", "lines", "reports"),
    *("samples", "strip", "text_file"),
)


def sources() -> list[Path]:
    """Return the C++ that the emulated device is made of."""
    files = [file for folder in _FOLDERS for file in (TREE / folder).rglob("*.cpp")]
    files += [TREE / "sdk/conversion/swings.cpp"]
    return sorted([*files, *(TREE / "emulator" / f"{name}.cpp" for name in _FILES)])


def _joined() -> list[Path]:
    """Write one file that includes all sources of a folder, for each, and return them.

    It halves the time that their compilation takes, which goes into the standard library's headers.
    """
    folder = BUILD / "joined"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    joined = []
    files = sorted(sources(), key=lambda file: file.parent)
    for parent, inside in itertools.groupby(files, key=lambda file: file.parent):
        joined.append(folder / f"{'-'.join(parent.relative_to(TREE).parts)}.cpp")
        joined[-1].write_text("".join(f'#include "{file}"\n' for file in inside), encoding="utf-8")
    return joined


def _version() -> Sequence[str]:
    text = (TREE / "CMakeLists.txt").read_text(encoding="utf-8")
    found = re.search(r"project\(torsio VERSION (\d+)\.(\d+)\.(\d+)", text)
    assert found is not None
    return found.groups()


def build_wasm() -> Path:
    """Compile the emulated device; Zig compiles only the folders that have changed."""
    PAGE.mkdir(parents=True, exist_ok=True)
    module = PAGE / "knob.wasm"
    caches = {
        f"ZIG_{kind}_CACHE_DIR": str(BUILD / f"zig-{kind.lower()}") for kind in ("LOCAL", "GLOBAL")
    }
    defines = [
        f"-DTORSIO_VERSION_{name}={value}"
        for name, value in zip(("MAJOR", "MINOR", "PATCH"), _version(), strict=True)
    ]
    command = [sys.executable, "-m", "ziglang", "c++", *_FLAGS, *defines]
    command += [f"-I{TREE / folder}" for folder in _INCLUDED]
    command += [*map(str, _joined()), "-o", str(module)]
    subprocess.run(command, check=True, env={**os.environ, **caches})
    return module


def check_page() -> None:
    """Check the page's types."""
    subprocess.run([STUDIO / "node_modules/.bin/tsc", "--noEmit", "-p", STUDIO], check=True)


def build_page() -> Path:
    """Bundle the page."""
    esbuild, quiet = str(STUDIO / "node_modules/.bin/esbuild"), ("--log-level=warning",)
    entries = [str(STUDIO / f"src/{name}.ts") for name in ("main", "worker")]
    PAGE.mkdir(parents=True, exist_ok=True)
    subprocess.run(
        [
            *(esbuild, *entries, *quiet, "--loader:.rules=text", "--loader:.md=text"),
            *("--bundle", "--minify", "--format=esm", "--target=es2022", f"--outdir={PAGE}"),
        ],
        check=True,
    )
    # Tests run these in node. Older releases take a file for a script unless they are told.
    modules = [str(STUDIO / f"src/{name}.ts") for name in MODULES]
    subprocess.run(
        [*(esbuild, *modules, "--bundle", "--format=esm", f"--outdir={BUILD / 'modules'}"), *quiet],
        check=True,
    )
    (BUILD / "modules/package.json").write_text('{"type": "module"}\n', encoding="utf-8")
    for file in (STUDIO / "public").iterdir():
        shutil.copy2(file, PAGE)
    return PAGE


def main(arguments: list[str]) -> int:
    """Build the one, the other or both."""
    if "--page" not in arguments:
        build_wasm()
    if "--wasm" not in arguments:
        if "--unchecked" not in arguments:
            check_page()
        build_page()
    print(f"the page is in {PAGE.relative_to(TREE)}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
