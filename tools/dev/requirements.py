"""Prints Python requirements out of ``pyproject.toml`` files, one a line.

``python -m tools.dev.requirements demo`` prints what building the package and the demo need,
``page`` what `torsio studio` needs on top,
``all`` what developing and testing need on top, ``pins`` the exact versions of whatever it is.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    from pip._vendor import tomli as tomllib

TREE = Path(__file__).parent.parent.parent
# Optional dependencies: the demo's, for its picture; then those that tests and studies need.
DEMO_EXTRAS = ("cli", "plot")
PAGE_EXTRAS = ("studio",)
ALL_EXTRAS = ("dev",)


def requirements(project: dict[str, Any], group: str) -> list[str]:
    """Return one group's requirements of a ``pyproject.toml``; see the module."""
    extras: dict[str, list[str]] = project["project"].get("optional-dependencies", {})
    if group == "pins":
        return extras.get("dev", [])
    more = {"demo": (), "page": PAGE_EXTRAS}.get(group, ALL_EXTRAS)
    wanted = (*DEMO_EXTRAS, *more)
    return [
        *project["build-system"]["requires"],
        *project["project"].get("dependencies", []),
        *(line for name in wanted for line in extras.get(name, [])),
    ]


if __name__ == "__main__":
    with (TREE / "pyproject.toml").open("rb") as file:
        print("\n".join(requirements(tomllib.load(file), sys.argv[1])))
