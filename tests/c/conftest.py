"""The installed C interface, loaded; a knob and a scene made with it."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.c.calling import HEADER, TREE, good, made, run


@pytest.fixture(scope="session")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the C interface alone; TORSIO_TEST_BUILD names another build of it."""
    prefix = tmp_path_factory.mktemp("c") / "prefix"
    build = os.environ.get("TORSIO_TEST_BUILD", str(TREE / "build/release"))
    run("cmake", "--install", build, "--prefix", prefix, "--component", "c")
    return prefix


@pytest.fixture(scope="session")
def library(prefix: Path) -> Path:
    return prefix / "lib/libtorsio.so"


@pytest.fixture(scope="session")
def lib(library: Path) -> ctypes.CDLL:
    loaded = ctypes.CDLL(str(library))
    for function in HEADER.functions.values():
        known = getattr(loaded, function.name)
        if function.result == "void":
            known.restype = None
        elif function.result.startswith("const char"):
            known.restype = ctypes.c_char_p
        elif function.result.endswith("*"):
            known.restype = ctypes.c_void_p
        elif function.result in ("bool", "size_t"):
            known.restype = {"bool": ctypes.c_bool, "size_t": ctypes.c_size_t}[function.result]
    return loaded


@pytest.fixture
def knob(lib: ctypes.CDLL) -> Iterator[ctypes.c_void_p]:
    options = made(lib, "torsio_open_options")
    emulator = made(lib, "torsio_emulator_options", log_truth=True)
    options.emulator = ctypes.addressof(emulator)
    handle = ctypes.c_void_p()
    good(lib, lib.torsio_knob_open(b"emulated", ctypes.byref(options), ctypes.byref(handle)))
    yield handle
    lib.torsio_knob_free(handle)


@pytest.fixture
def scene(lib: ctypes.CDLL) -> Iterator[ctypes.c_void_p]:
    handle = ctypes.c_void_p()
    good(lib, lib.torsio_scene_new(ctypes.byref(handle)))
    yield handle
    lib.torsio_scene_free(handle)
