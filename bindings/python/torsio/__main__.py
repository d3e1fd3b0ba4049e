"""Start of the `torsio` command and of ``python -m torsio``."""

from __future__ import annotations

import io
import sys

from torsio.extras import how_to_install


def main() -> None:
    """Run the command line, or say what it lacks."""
    for stream in (sys.stdout, sys.stderr):
        # Where the system's letters are few, a question mark stands for the others.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    try:
        from torsio.cli import app
    except ModuleNotFoundError as error:
        # What lacks inside a library is not for an extra to bring.
        if error.name not in ("rich", "typer"):
            raise
        sys.exit(
            f"torsio: error: the command line needs the Python package {error.name}; install what "
            f"it needs with: {how_to_install('cli')}"
        )
    app(prog_name="torsio")


if __name__ == "__main__":
    main()
