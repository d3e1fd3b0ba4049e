"""Opening files that are no knob, with the real hidapi below, which crashes on some of them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.python.processes import python

PROGRAM = """
import sys
import torsio
try:
    torsio.open(sys.argv[1])
except torsio.DeviceNotFound as error:
    print(error)
"""


def _message(path: str, locks: Path) -> str:
    """Open a path in a process of its own, which may crash, and return its words."""
    result = python(PROGRAM, path, env={**os.environ, "XDG_RUNTIME_DIR": str(locks)})
    assert result.returncode == 0, result.stderr
    return result.stdout


@pytest.mark.parametrize("path", ["/dev/null", "/dev/tty", "/etc/passwd", "/dev"])
def test_file_that_is_not_a_hid_device_is_refused_by_name(path: str, tmp_path: Path) -> None:
    message = _message(path, tmp_path)
    assert message.startswith(f"{path} is not a HID device")
    assert "torsio list" in message
    assert list(tmp_path.iterdir()) == []


def test_link_to_a_file_that_is_not_a_hid_device_is_refused_by_name(tmp_path: Path) -> None:
    link = tmp_path / "knob"
    link.symlink_to("/dev/null")
    assert _message(str(link), tmp_path).startswith(f"{link} is not a HID device")
    assert list(tmp_path.iterdir()) == [link]
