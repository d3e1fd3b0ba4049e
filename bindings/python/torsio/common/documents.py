"""Where the project's documents are to be read: on its site, in a clone, or in the project."""

from __future__ import annotations

import os

from torsio.common.extras import installed, source_folder

__all__ = ["VARIABLE", "entry"]

VARIABLE = "TORSIO_DOCUMENTS"
"""The environment's variable with the address of a site of one's own, made by ``./dev site``."""


def _site() -> str:
    """Give the address of the documents' site, or an empty text.

    The project's own stands in `pyproject.toml` and nowhere else: the address named Documentation.
    """
    if own := os.environ.get(VARIABLE, ""):
        return own.rstrip("/")
    known = installed()
    for line in (known and known.metadata.get_all("Project-URL")) or []:
        name, _, address = line.partition(", ")
        if name == "Documentation":
            return str(address).rstrip("/")
    return ""


def entry(name: str, page: str = "reference/troubleshooting") -> str:
    """Give the address of an entry of a page of the documents; a path where there is no site."""
    if site := _site():
        return f"{site}/{page}.html#{name.replace('_', '-')}"
    inside = f"docs/{page}.md"
    folder = source_folder()
    is_here = folder is not None and (folder / inside).exists()
    return f"{(folder / inside).as_uri() if folder and is_here else inside}#{name}"
