"""Programs in a process of their own: any of Python's, and the `torsio` command."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

TORSIO = "from torsio.__main__ import main; main()"


def python(program: str, *words: str | Path, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run a program to its end."""
    given = {"capture_output": True, "text": True, "timeout": 120, "check": False} | options
    return subprocess.run([sys.executable, "-c", program, *words], **given)


def command(*words: str | Path, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run the command to its end."""
    return python(TORSIO, *words, **options)
