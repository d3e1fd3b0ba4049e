"""Where the studio's page is."""

from __future__ import annotations

from pathlib import Path

from torsio.errors import Error
from torsio.extras import source_folder

__all__ = ["page_folder"]

_INSTALLED = Path(__file__).parent / "page"


def page_folder() -> Path:
    """Return the folder of the built page: in the package, or in the tree it was built from.

    Raises
    ------
    torsio.Error
        If it has not been built.
    """
    tree = source_folder()
    for folder in (_INSTALLED, *([tree / "build/studio/page"] if tree else [])):
        if (folder / "index.html").exists():
            return folder
    raise Error(
        "the studio's page is not built: run ./dev studio in a clone of the project, or name the "
        "folder of a built page with --page"
    )
