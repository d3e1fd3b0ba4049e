"""Start of the `torsio` command and of ``python -m torsio``."""

from __future__ import annotations

import io
import os
import sys

from torsio.common.extras import lacking


def main() -> None:
    """Run the command line, or say what it lacks."""
    if sys.stdout is None:
        sys.exit("torsio: error: standard output is closed; to throw it away, use >/dev/null")
    for stream in (sys.stdout, sys.stderr):
        # Where the system's letters are few, a question mark stands for the others.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    try:
        from torsio.apps.cli import app
    except ModuleNotFoundError as error:
        sys.exit(f"torsio: error: {lacking('the command line', 'cli', error)}")
    status: str | int | None = 0
    try:
        try:
            app(prog_name="torsio")
        except SystemExit as end:
            status = end.code
        sys.stdout.flush()
    except OSError as error:
        # Python would try again at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = status or f"torsio: error: standard output: {error.strerror}"
    sys.exit(status)


if __name__ == "__main__":
    main()
