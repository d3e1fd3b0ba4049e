"""Shared by the tests of the C interface: the header as read, calls that must succeed, a shell."""

from __future__ import annotations

import ctypes
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

from tests.c import layouts

TREE = Path(__file__).parent.parent.parent
HEADER = layouts.read(layouts.whole())
N = HEADER.numbers


def run(*command: str | Path, **variables: str) -> str:
    """Run a command and return what it prints; the test fails with it if the command does."""
    result = subprocess.run(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        env={**os.environ, **variables},
    )
    if result.returncode != 0:
        pytest.fail(f"{command} failed:\n{result.stdout}", pytrace=False)
    return result.stdout


def said(lib: ctypes.CDLL) -> str:
    """Return the sentence of the last failed call."""
    text: bytes = lib.torsio_last_error()
    return text.decode()


def good(lib: ctypes.CDLL, result: int) -> None:
    """Check that a call went well."""
    assert result == N["TORSIO_OK"], said(lib)


def made(lib: ctypes.CDLL, name: str, **fields: Any) -> Any:
    """Return a structure with its defaults, except these fields."""
    structure = HEADER.structures[name]()
    good(lib, getattr(lib, f"{name}_init")(ctypes.byref(structure)))
    for field, value in fields.items():
        assert hasattr(structure, field)
        setattr(structure, field, value)
    return structure
