"""Everything that is compiled: CMake's presets, Python packages, firmware and test programs."""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from pathlib import Path

from tools import boards
from tools.dev import running
from tools.dev.environment import PYTHON, VENV, pip_install
from tools.dev.running import (
    BUILD,
    LOGS,
    TREE,
    Failed,
    Word,
    later,
    run_logged,
    say,
    stamp_is,
    stamped,
    without_aslr,
)

# Targets of the preset ``release`` that the Python package is linked with.
LIBRARIES = ("torsio_sdk", "torsio_conversion", "torsio_emulator")
PRESETS = ("dev", "release", "asan-ubsan", "tsan")
BOARDS = tuple(boards.chips())
# Each chip's processor, as its folder of programs is called.
PROCESSORS = {"rp2350": "m33", "rp2040": "m0plus"}
# Has each board run all of its tests, also those that go to the boards in turn.
EVERY_BOARD_VARIABLE = "TORSIO_EVERY_BOARD"


@dataclass(frozen=True)
class PythonPackage:
    """A Python distribution of this tree.

    Attributes
    ----------
    name
        To import it by.
    folder
        Where its ``pyproject.toml`` stands, from the top of the tree.
    sources
        Files and folders that it is made of: it is built anew when one changes.
    build
        Folder of ``build/`` that its objects are in.
    settings
        CMake's variables on top of those that all have.
    """

    name: str
    folder: str
    sources: tuple[str, ...]
    build: str
    settings: dict[str, str] = field(default_factory=dict)


# Shares ``build/release``, and so all objects of the C++ libraries, with the preset.
TORSIO = PythonPackage(
    "torsio",
    ".",
    ("CMakeLists.txt", "pyproject.toml", "cmake", "firmware", "emulator", "sdk", "bindings"),
    "release",
)
# Needs the first, and its objects, which a build of its own would leave out.
STUDIES = PythonPackage(
    "torsio_studies", "studies", ("studies", *TORSIO.sources), "release", {"TORSIO_BUILD_SDK": "ON"}
)
# Has nothing to compile.
HARDWARE = PythonPackage("torsio_hardware", "hardware", ("hardware", "CMakeLists.txt"), "release")
# ``build`` and ``bench`` install these, in this order. A demo installs the first alone.
PACKAGES = (TORSIO, STUDIES, HARDWARE)


def digest(names: Iterable[str]) -> str:
    """Return a checksum of files and folders of the tree, names included."""
    files: list[Path] = []
    for name in names:
        path = TREE / name
        files += [path] if path.is_file() else path.rglob("*")
    total = hashlib.sha256()
    for file in sorted(files):
        if file.is_file() and not {"__pycache__", "node_modules"} & set(file.parts):
            content = hashlib.sha256(file.read_bytes()).hexdigest()
            total.update(f"{content} {file.relative_to(TREE)}\n".encode())
    return total.hexdigest()


def use_compiler_cache() -> None:
    """Let CMake compile through ccache where that is installed, unless the user has said how."""
    if shutil.which("ccache"):
        os.environ.setdefault("CMAKE_C_COMPILER_LAUNCHER", "ccache")
        os.environ.setdefault("CMAKE_CXX_COMPILER_LAUNCHER", "ccache")
        # Without these it passes over all that uses a precompiled header.
        os.environ.setdefault("CCACHE_SLOPPINESS", "pch_defines,time_macros")


def _own(name: str) -> Path:
    """Return a folder of ``build/``.

    One that was copied with its tree holds the other tree's paths and is dropped.
    """
    folder = BUILD / name
    if not stamp_is(folder / ".root", str(TREE)):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / ".root").write_text(str(TREE), encoding="utf-8")
    return folder


def _cmake_version() -> str:
    return running.output_of("cmake", "--version").partition("\n")[0]


# --- sources that are not the project's ----------------------------------------------------------


class FirmwareSources:
    """TinyUSB, for the virtual USB knob and the boards, and Raspberry Pi's SDK, for the boards.

    They are found on this machine or fetched once, in the background; see
    ``tools/firmware_sources.py``.
    """

    def __init__(self, *, fetch: bool = True) -> None:
        self._folder = BUILD / "firmware-sources"
        self._log = LOGS / "firmware-sources.log"
        known = os.environ.get("PICO_SDK_PATH") or Path("/usr/src/pico-sdk").is_dir()
        if not (known or self._folder.is_dir()) and fetch:
            say("TinyUSB and the boards' SDK: fetching into build/firmware-sources")
        self._wanted = bool(fetch or known or self._folder.is_dir())
        self._found: Future[str] = later(self._find)

    def _find(self) -> str:
        if not self._wanted:
            return ""
        LOGS.mkdir(parents=True, exist_ok=True)
        from tools import firmware_sources

        try:
            return str(firmware_sources.locate(self._folder))
        except (RuntimeError, OSError) as error:
            self._log.write_text(f"{error}\n{firmware_sources.HINT}\n", encoding="utf-8")
            return ""

    @property
    def sdk(self) -> str:
        """The SDK's folder; empty if there is nothing to be had."""
        return self._found.result()

    @property
    def tinyusb(self) -> str:
        """TinyUSB's folder; empty if there is nothing to be had."""
        return f"{self.sdk}/lib/tinyusb" if self.sdk else ""

    def offer(self) -> str:
        """Return TinyUSB's folder, or nothing, and say then what will be missing."""
        if self._wanted and not self.tinyusb:
            say(
                "no TinyUSB: building without the virtual USB knob; "
                "see build/logs/firmware-sources.log"
            )
        return self.tinyusb

    def require(self) -> str:
        """Return the SDK's folder: the tests and the boards cannot do without.

        Raises
        ------
        Failed
            If there is none.
        """
        if not self.sdk:
            running.show_end(self._log)
            raise Failed(
                "no TinyUSB and no SDK for the boards; full log: build/logs/firmware-sources.log"
            )
        return self.sdk


def begin_fetching_kernels() -> Future[None]:
    """Begin to fetch the kernels that the tests boot; see ``tools/kernels.py``."""
    say("kernels: looking for them")
    return later(run_logged, "kernels", [sys.executable, "-m", "tools.kernels", "build/kernels"])


def build_windows_games() -> None:
    """Make what the tests of Windows games need, and fetch the newest kernels."""
    say("kernels: the newest, and a game for Windows")
    kernels = [sys.executable, "-m", "tools.kernels", "--newest", "build/newest-kernels"]
    run_logged("games", kernels, [PYTHON, "-m", "tools.windows_games"])


def begin_npm(folder: str) -> Future[None]:
    """Begin to fetch the packages that a folder's lock file names, without their scripts."""
    packages = TREE / folder
    stamp = packages / "node_modules/.installed"
    key = digest([f"{folder}/package-lock.json"])
    log = f"npm-{folder.replace('/', '-')}"

    def install() -> None:
        with stamped(stamp, key):
            options = ("--no-audit", "--no-fund", "--ignore-scripts")
            run_logged(log, ["npm", "ci", "--prefix", packages, *options])

    if stamp_is(stamp, key):
        return later(lambda: None)
    say(f"{folder}: installing its npm packages")
    return later(install)


def begin_studio(*parts: str) -> Future[None]:
    """Begin to build the studio's page and the emulated device in it, or the parts that are named.

    Zig compiles only what has changed; the rest takes seconds.
    """
    npm = begin_npm("studio")
    say("studio: building")
    _own("studio")

    def build() -> None:
        npm.result()
        run_logged("studio", [PYTHON, "-m", "tools.studio", *parts])

    return later(build)


# --- C++ -----------------------------------------------------------------------------------------


def build_preset(preset: str, tinyusb: str, *options: str) -> None:
    """Configure and build one of CMake's presets; the options go to ``cmake --build``."""
    folder = _own(preset)
    key = f"{tinyusb} {digest(['CMakePresets.json'])}"
    if not stamp_is(folder / ".configured", key):
        say(f"C++ ({preset}): configuring")
        with stamped(folder / ".configured", key):
            run_logged(
                f"configure-{preset}",
                ["cmake", "--fresh", "--preset", preset, f"-DTORSIO_TINYUSB_PATH={tinyusb}"],
            )
    say(f"C++ ({preset}): building")
    run_logged(f"build-{preset}", without_aslr("cmake", "--build", "--preset", preset, *options))


def build_python(package: PythonPackage, tinyusb: str) -> None:
    """Build a Python package and install it in the environment.

    pip would pack a wheel every time, so it is only asked when a source has changed.
    """
    key = f"{TREE} {tinyusb} {digest(package.sources)}"
    stamp = VENV / f".package-{package.name}"
    title = "Python package" if package is TORSIO else f"Python package {package.name}"
    if stamp_is(stamp, key):
        say(f"{title}: up to date")
        return
    say(f"{title}: building and installing")
    with stamped(stamp, key):
        folder = _own(package.build)
        defines = {"TORSIO_WERROR": "ON", "TORSIO_TINYUSB_PATH": tinyusb, **package.settings}
        settings = [f"--config-settings=build-dir={folder}"]
        settings += [
            f"--config-settings=cmake.define.{name}={value}" for name, value in defines.items()
        ]
        options = ("--no-deps", "--no-build-isolation", "--force-reinstall")
        run_logged(
            f"build-python-{package.name}",
            pip_install(*options, *settings, TREE / package.folder),
            [PYTHON, "-c", f"import {package.name}"],
        )


def build_packages(tinyusb: str) -> None:
    """Build and install all of the project's Python packages."""
    for package in PACKAGES:
        build_python(package, tinyusb)


# --- firmware ------------------------------------------------------------------------------------


def _build_apart(title: str, name: str, source: str, key: str, settings: Sequence[str]) -> Path:
    """Configure and build a project of its own, with another compiler than the rest's."""
    folder = _own(name)
    log = name.replace("/", "-")
    if not stamp_is(folder / ".configured", key):
        say(f"{title}: configuring")
        options = ("-DCMAKE_BUILD_TYPE=Release", "-DTORSIO_WERROR=ON", *settings)
        command: tuple[Word, ...] = ("cmake", "--fresh", "-S", source, "-B", folder, "-G", "Ninja")
        with stamped(folder / ".configured", key):
            run_logged(f"configure-{log}", (*command, *options))
    say(f"{title}: building")
    run_logged(f"build-{log}", ["cmake", "--build", folder])
    return folder


def _board_settings(board: str, sdk: str, first: str) -> tuple[str, ...]:
    settings = (f"-DTORSIO_BOARD={board}", f"-DPICO_SDK_PATH={sdk}")
    # The assembler of the chips' I/O programs is compiled with the first board, for all.
    pioasm = BUILD / "firmware" / first / "pioasm-install/pioasm"
    return settings if board == first else (*settings, f"-Dpioasm_DIR={pioasm}")


def build_firmware(sdk: str, names: Sequence[str] = BOARDS) -> None:
    """Build the firmware of boards: ELF file, map and image."""
    for file in (BUILD / "firmware").glob("torsio-*"):  # a board may be gone
        file.unlink()
    compiler = running.output_of("arm-none-eabi-g++", "-dumpfullversion").strip()
    for board in names:
        folder = _build_apart(
            f"firmware ({board})",
            f"firmware/{board}",
            "firmware/boards",
            f"{sdk} {compiler} {_cmake_version()}",
            _board_settings(board, sdk, names[0]),
        )
        for suffix in ("elf", "map"):
            shutil.copy2(folder / f"torsio-{board}.{suffix}", BUILD / "firmware")
        image = BUILD / "firmware" / f"torsio-{board}"
        run_logged(f"uf2-{board}", [PYTHON, "-m", "tools.uf2", f"{image}.elf", f"{image}.uf2"])


def build_unguarded(sdk: str) -> None:
    """Build firmware whose guards tests can switch off; see ``tests/board/unguarded.py``."""
    run_logged("unguarded", [PYTHON, "-m", "tests.board.unguarded"])
    for board in BOARDS:
        folder = _build_apart(
            f"firmware without guards ({board})",
            f"unguarded/{board}",
            "build/unguarded/tree/firmware/boards",
            f"{sdk} {_cmake_version()}",
            (*_board_settings(board, sdk, BOARDS[0]), "-DTORSIO_WERROR=OFF"),
        )
        image = folder / f"torsio-{board}"
        log = f"uf2-unguarded-{board}"
        run_logged(log, [PYTHON, "-m", "tools.uf2", f"{image}.elf", f"{image}.uf2"])


def build_emulated(names: Sequence[str] = BOARDS) -> None:
    """Build the programs for the processors of boards and for this machine, and the boot ROM."""
    chips = boards.chips()
    processors = [PROCESSORS[chips[board]] for board in names]
    for processor in (*processors, "host"):
        _build_apart(
            f"programs for emulated processors ({processor})",
            f"mcu/{processor}",
            "tests/mcu",
            _cmake_version(),
            (f"-DTORSIO_PROCESSOR={processor}", f"-DCMAKE_UNITY_BUILD={processor == 'host'}"),
        )
    if "m0plus" in processors:
        folder = BUILD / "mcu/m0plus"
        copy = ("arm-none-eabi-objcopy", "-O", "binary")
        programs = [
            folder / name for name in ("bench", "bench_core", "bench_shaft", "multiply", "replay")
        ]
        run_logged("objcopy", *((*copy, program, f"{program}.bin") for program in programs))
    run_logged("boot-rom", [PYTHON, "-m", "tests.board.pico"])
