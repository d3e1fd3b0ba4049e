"""Where the studio's page is."""

from __future__ import annotations

from pathlib import Path

from torsio.common import checks
from torsio.common.extras import source_folder
from torsio.errors import Error

__all__ = ["page_folder"]

_INSTALLED = Path(__file__).parent / "page"


def page_folder(named: str | Path | None = None) -> Path:
    """Return the folder of the built page: as it is named, in the package, or in the source tree.

    Raises
    ------
    torsio.Error
        If it has not been built.
    """
    if named is not None:
        folder = checks.path("page", named)
        if (folder / "index.html").exists():
            return folder
        raise Error(f"the page is not in {str(folder)!r}: name the folder that ./dev studio builds")
    tree = source_folder()
    for folder in (_INSTALLED, *([tree / "build/studio/page"] if tree else [])):
        if (folder / "index.html").exists():
            return folder
    raise Error(
        "the studio's page is not built: run ./dev studio in a clone of the project, or name the "
        "folder of a built page with --page"
    )
