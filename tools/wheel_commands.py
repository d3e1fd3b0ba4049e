"""Shared by the tools for wheels and Windows: commands with a log, environments with packages."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
from pathlib import Path

from tools.dev.running import TREE, Failed, say

__all__ = ["BUILD", "TREE", "Failed", "environment", "finish", "pip", "run", "say"]

BUILD = TREE / "build/wheels"


def finish(*command: str | Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a command at the top of the tree to its end, with all that it prints as one text."""
    environ = {**os.environ, **variables}
    if command[0] == "wine":
        # Debian's Wine leaves when its last program has; what begins just then, it lets go of.
        # Where another program keeps it, it stays.
        with contextlib.suppress(subprocess.TimeoutExpired):
            subprocess.run(["wineserver", "--wait"], env=environ, check=False, timeout=10)
    return subprocess.run(
        command,
        cwd=TREE,
        env=environ,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        check=False,
    )


def run(name: str, *command: str | Path, **variables: str) -> str:
    """Run a command; its output goes to build/logs/NAME.log and comes back.

    Raises
    ------
    Failed
        If it fails, with the end of its output.
    """
    log = TREE / "build/logs" / f"{name}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    result = finish(*command, **variables)
    log.write_text(result.stdout, encoding="utf-8")
    if result.returncode != 0:
        end = "\n".join(result.stdout.splitlines()[-30:])
        raise Failed(f"{end}\n{command[0]} failed; full log: build/logs/{log.name}")
    return result.stdout


def pip(python: Path) -> tuple[str | Path, ...]:
    """Return how to call an environment's pip."""
    return (python, "-m", "pip", "--no-input", "--disable-pip-version-check", "--retries", "5")


def environment(folder: Path, python: Path, *packages: str) -> Path:
    """Make a virtual environment with these packages, and return its Python."""
    own = folder / "bin/python"
    done = folder / ".packages"
    if not done.exists() or done.read_text() != f"{python} {packages}":
        shutil.rmtree(folder, ignore_errors=True)
        run(f"venv-{folder.name}", python, "-m", "venv", folder)
        run(f"pip-{folder.name}", *pip(own), "install", "pip>=24", *packages)
        done.write_text(f"{python} {packages}")
    return own
