"""The real udev in a guest, which has none by itself."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

from tests.vm.guest.virtual_bus import wait_for

# The guest's root differs from its first process's, and udev's commands then do nothing.
ENVIRONMENT = {**os.environ, "SYSTEMD_IGNORE_CHROOT": "1"}
RULE = Path("/etc/udev/rules.d/60-torsio.rules")


def run(*command: str | Path) -> str:
    """Run a command that talks to udev, which must end well; return what it says."""
    result = subprocess.run(
        command, env=ENVIRONMENT, capture_output=True, text=True, check=False, cwd="/"
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout + result.stderr


@contextlib.contextmanager
def running() -> Iterator[None]:
    """Run udev, as a computer does from its start."""
    daemon = subprocess.Popen(["/lib/systemd/systemd-udevd"], env=ENVIRONMENT)
    try:
        wait_for("udev", lambda: Path("/run/udev/control").exists())
        yield
    finally:
        daemon.terminate()
        daemon.wait()
        shutil.rmtree("/run/udev")  # no trace for those who look whether udev runs
