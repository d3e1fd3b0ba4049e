"""System packages: which the commands need, which of them are missing, how they are installed."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from pathlib import Path

from tools import apt
from tools.dev import running
from tools.dev.running import Failed, become_root, later, say, succeeds

# A package, and how to see that what it brings is there, wherever it comes from.
Package = tuple[str, Callable[[], bool]]


def _program(name: str) -> Callable[[], bool]:
    return lambda: shutil.which(name) is not None


def _header(name: str, compiler: str = "g++") -> Callable[[], bool]:
    test = f"#if !__has_include(<{name}>)\n#error\n#endif\n"
    return lambda: succeeds(compiler, "-E", "-x", "c++", "-", text=test)


def _library(name: str) -> Callable[[], bool]:
    return lambda: succeeds("pkg-config", "--exists", name)


def _executable(path: str) -> Callable[[], bool]:
    return lambda: os.access(path, os.X_OK)


def _static_busybox() -> bool:
    busybox = shutil.which("busybox")
    return busybox is not None and "=>" not in running.output_of("ldd", busybox)


def _usbip() -> Package:
    # Ubuntu has it among the tools of its kernels.
    if apt.os_release("ID") == "ubuntu":
        return ("linux-tools-generic", lambda: any(Path("/usr/lib/linux-tools").glob("*/usbip")))
    return ("usbip", _executable("/usr/sbin/usbip"))


def groups() -> dict[str, tuple[Package, ...]]:
    """Return the packages that each group of commands needs."""
    return {
        # The libraries and the Python package: all that a demo waits for, beside the Python that
        # the script ``dev`` has found.
        "base": (
            ("g++", _program("g++")),
            ("cmake", _program("cmake")),
            ("ninja-build", _program("ninja")),
            ("pkg-config", _program("pkg-config")),
            ("libhidapi-dev", _library("hidapi-hidraw")),
        ),
        "making": (("calculix-ccx", _program("ccx")),),
        "tests": (
            ("doctest-dev", _header("doctest/doctest.h")),
            ("nlohmann-json3-dev", _header("nlohmann/json.hpp")),
            # A user who unpacked the tree from an archive may have none.
            ("git", _program("git")),
        ),
        "mutants": (("bubblewrap", _program("bwrap")),),
        # The boards' firmware, and the processors that it is tested on.
        "firmware": (
            ("gcc-arm-none-eabi", _program("arm-none-eabi-g++")),
            # Comes with newlib.
            ("libstdc++-arm-none-eabi-newlib", _header("optional", "arm-none-eabi-g++")),
            ("qemu-system-arm", _program("qemu-system-arm")),
            ("nodejs", _program("node")),
            ("npm", _program("npm")),
        ),
        "machines": (
            ("qemu-system-x86", _program("qemu-system-x86_64")),
            # The first program in a machine; it must run without any library.
            ("busybox-static", _static_busybox),
            # Applies the udev rule in a machine.
            ("udev", _executable("/lib/systemd/systemd-udevd")),
            # Shows how a desktop understands a dial.
            ("libinput-tools", _program("libinput")),
            # Linux's own programs that try forces out.
            ("joystick", _program("fftest")),
            # Players' programs that take seconds to try.
            ("python3-evdev", Path("/usr/lib/python3/dist-packages/evdev").is_dir),
            ("libsdl2-tests", _executable("/usr/libexec/installed-tests/SDL2/testhaptic")),
            # Plugs a virtual knob in, in a machine.
            _usbip(),
        ),
        # Bundles the studio's page; then browsers to test it in.
        "studio": (("nodejs", _program("node")), ("npm", _program("npm"))),
        "browser": (
            ("chromium", _program("chromium")),
            ("firefox-esr", _program("firefox-esr")),
        ),
        # Other compilers and machines for the emulator.
        "compilers": (
            ("clang", _program("clang++")),
            ("g++-aarch64-linux-gnu", _program("aarch64-linux-gnu-g++")),
            ("qemu-user", _program("qemu-aarch64")),
        ),
        # For tests of the C interface: compilers of other languages, and abidiff.
        "languages": (
            ("mono-mcs", _program("mcs")),
            ("mono-runtime", _program("mono")),
            ("libmono-system-core4.0-cil", Path("/usr/lib/mono/4.5/System.Core.dll").exists),
            ("cargo", _program("cargo")),
            ("rustc", _program("rustc")),
            ("bindgen", _program("bindgen")),
            ("octave-dev", _program("mkoctfile")),
            ("abigail-tools", _program("abidiff")),
        ),
        "windows": (
            ("g++-mingw-w64-x86-64-posix", _program("x86_64-w64-mingw32-g++-posix")),
            ("wine", _program("wine")),
            ("wine64", _executable("/usr/lib/wine/wine64")),
        ),
        # A Python for Windows comes through Maven; udev's functions are named in its header.
        # Programs that players have. A virtual machine tries them.
        "players": (("libois-dev", _header("ois/OIS.h")),),
        "wheels": (
            ("libudev-dev", _header("libudev.h")),
            ("maven", _program("mvn")),
            ("qemu-user", _program("qemu-aarch64")),
        ),
        "game": (("libsdl2-dev", _library("sdl2")),),
        # Reads the C++ headers for the site.
        "documents": (("doxygen", _program("doxygen")),),
        "fresh": (("debootstrap", _executable("/usr/sbin/debootstrap")),),
    }


def missing(wanted: Iterable[str]) -> list[str]:
    """Return the packages of these groups that are not there."""
    every = groups()
    # A package may be of two groups.
    packages = dict(package for group in wanted for package in every[group])
    return [name for name, is_there in packages.items() if not is_there()]


def install(names: list[str], as_root: list[str], wanted: Iterable[str], log: str) -> None:
    """Install packages with apt.

    Raises
    ------
    Failed
        If apt fails, or what they should bring is still not there.
    """
    if not names:
        return
    options = ("-q", "-o", "Acquire::Retries=3", "-o", "DPkg::Lock::Timeout=300")
    command = [*as_root, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", *options]
    running.run_logged(
        log,
        [*command, "update"],
        [*command, "-y", "install", "--no-install-recommends", *names],
        attempts=3,
        # Where something else fails meanwhile: half an installation would be left to the user.
        to_its_end=True,
    )
    if left := missing(wanted):
        raise Failed(f"still missing after apt-get: {' '.join(left)}; log: build/logs/{log}.log")


def begin_set_up(
    first: Iterable[str], then: Iterable[str] = ()
) -> tuple[Future[None], Future[None]]:
    """Install what is missing, in the background.

    Returns
    -------
    first, all
        Done when the packages of the first groups are there, and when all are.

    Raises
    ------
    Failed
        If something is missing and cannot be installed here; says what to run by hand.
    """
    first, then = tuple(first), tuple(then)
    at_once = missing(first)
    rest = [name for name in missing(then) if name not in at_once]
    names = [*at_once, *rest]
    if not names:
        say("system packages: up to date")
        return later(lambda: None), later(lambda: None)
    line = f"apt-get install --no-install-recommends {' '.join(names)}"
    if shutil.which("apt-get") is None:
        raise Failed(f"missing, and this system has no apt-get; on Debian it would be: {line}")
    as_root = become_root("system packages are missing and need root", line)
    say(f"system packages: installing {' '.join(names)}")
    begun = later(install, at_once, as_root, first, "apt")

    def go_on() -> None:
        begun.result()
        install(rest, as_root, then, "apt-more")

    return begun, later(go_on)
