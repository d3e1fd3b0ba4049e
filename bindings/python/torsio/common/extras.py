"""Parts of the package that need more than NumPy, and how to install what they need."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from torsio.errors import Error, InvalidArgument

if TYPE_CHECKING:
    from importlib.metadata import Distribution

__all__ = ["how_to_install", "installed", "lacking", "need_matplotlib", "source_folder"]

# Quotes for one word of the system's own shell.
_QUOTE = '"' if sys.platform == "win32" else "'"


def installed() -> Distribution | None:
    """Give what pip knows of the package; None of one that was copied."""
    # Here, since few need it, and it makes a fifth of the package's import.
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        return distribution("torsio")
    except PackageNotFoundError:
        return None


def source_folder() -> Path | None:
    """Give the source tree that the package was installed from, if it is still there."""
    from urllib.parse import urlsplit
    from urllib.request import url2pathname

    known = installed()
    origin = json.loads((known and known.read_text("direct_url.json")) or "{}")
    url = urlsplit(origin.get("url", ""))
    folder = Path(url2pathname(url.path))
    return folder if url.scheme == "file" and folder.is_dir() else None


def _requirements(extra: str) -> list[str]:
    """Give what an extra would bring, as pip takes it."""
    known = installed()
    return [
        requirement.partition(";")[0].strip()
        for requirement in (known and known.requires) or []
        if f"extra == {extra!r}" in requirement.replace('"', "'")
    ]


def how_to_install(extra: str) -> str:
    """Give the command that installs an extra of this package, from where the package came."""
    if folder := source_folder():
        return f"pip install {_QUOTE}{folder}[{extra}]{_QUOTE}"
    # Without the source tree: the packages of the extra, by name.
    names = [f"{_QUOTE}{one}{_QUOTE}" for one in _requirements(extra)]
    if not names:
        return f"install what the extra {extra!r} of its pyproject.toml lists"
    return " ".join(["pip install", *names])


def lacking(what: str, extra: str, error: ModuleNotFoundError) -> str:
    """Say which package of an extra `what` needs; raise what a library itself lacks."""
    if error.name not in (re.split(r"[^\w-]", one)[0] for one in _requirements(extra)):
        raise error
    return (
        f"{what} needs the Python package {error.name}; install what it needs with: "
        f"{how_to_install(extra)}"
    )


def need_matplotlib(picture: Path | None = None) -> None:
    """Raise `Error` where a picture cannot be drawn, before what it is to show takes its time."""
    if importlib.util.find_spec("matplotlib") is None:
        raise Error(f"a picture needs matplotlib: {how_to_install('plot')}")
    if picture is None:
        return
    if picture.suffix not in (".png", ".svg", ".pdf"):
        raise InvalidArgument(f"{picture} ends in neither .png nor .svg nor .pdf")
    if not os.access(picture.resolve().parent, os.W_OK):
        raise InvalidArgument(f"{picture}: its folder does not exist, or cannot be written in")
