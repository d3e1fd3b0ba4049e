"""Commands of `torsio` that other packages bring, as entry points of the group torsio.commands."""

from __future__ import annotations

import sys
from importlib.metadata import entry_points

import typer

__all__ = ["add_commands"]

_MISSING = {
    "study": "the studies are a package of their own, which is not installed; in a clone of the "
    "project: pip install ./studies",
    "rehearse": "the hardware is a package of its own, which is not installed; in a clone of the "
    "project: pip install ./hardware",
}


def add_commands(app: typer.Typer) -> None:
    """Add other packages' commands, or commands that say how to install the packages."""
    found = {entry.name: entry for entry in entry_points(group="torsio.commands")}
    for name, entry in sorted(found.items()):
        app.add_typer(entry.load(), name=name)
    for name in _MISSING.keys() - found.keys():
        _add_missing(app, name)


def _add_missing(app: typer.Typer, name: str) -> None:
    # Takes any arguments, so that no option is complained about first.
    @app.command(
        name,
        help=f"Not installed; `torsio {name}` says how.",
        context_settings={"allow_extra_args": True, "ignore_unknown_options": True},
        add_help_option=False,
    )
    def missing() -> None:
        sys.stderr.write(f"torsio: error: {_MISSING[name]}\n")
        raise typer.Exit(1)
