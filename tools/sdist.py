"""Packs the sources as pip takes them: an sdist. Every wheel is built from it.

Only files that git has or is about to have go in, and the same sources make the same bytes.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

TREE = Path(__file__).parent.parent
_MAKE = "import sys; from scikit_build_core.build import build_sdist; build_sdist(sys.argv[1])"


def epoch() -> str:
    """Return the time of the last commit: what every file that is handed out is dated with."""
    if known := os.environ.get("SOURCE_DATE_EPOCH"):
        return known
    told = subprocess.run(
        ["git", "log", "-1", "--format=%ct"], cwd=TREE, capture_output=True, text=True, check=False
    )
    return told.stdout.strip() or "315532800"


def make(folder: Path) -> Path:
    """Make the sdist in a folder, and return the file.

    Raises
    ------
    RuntimeError
        If that fails, or this is no clone.
    """
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=TREE, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if listed.returncode != 0:
        raise RuntimeError(f"what belongs to the sources is known in a clone only: {listed.stderr}")
    copy = folder / "tree"
    for name in filter(None, listed.stdout.split("\0")):
        if (TREE / name).is_file():  # one that was removed is still listed
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(TREE / name, copy / name)
    made = subprocess.run(
        [sys.executable, "-c", _MAKE, str(folder.resolve())],
        cwd=copy, env={**os.environ, "SOURCE_DATE_EPOCH": epoch()},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    shutil.rmtree(copy)
    if made.returncode != 0:
        raise RuntimeError(f"the sdist cannot be made:\n{made.stdout}{made.stderr}")
    return next(folder.glob("torsio-*.tar.gz"))


def unpack(sdist: Path, folder: Path) -> bool:
    """Unpack an sdist into an empty folder; return False if this very one is there already."""
    known = folder.with_name(f"{folder.name}.tar.gz")
    if folder.is_dir() and known.exists() and known.read_bytes() == sdist.read_bytes():
        return False
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    subprocess.run(["tar", "-xzf", sdist, "-C", folder, "--strip-components=1"], check=True)
    shutil.copy(sdist, known)
    return True
