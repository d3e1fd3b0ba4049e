"""A function in a process of its own."""

from __future__ import annotations

import io
import os
import signal
import sys
import traceback
from collections.abc import Callable
from typing import TextIO

NOBODY = 65534


class Child:
    """A process that runs a function and ends; a second interpreter would take long to start.

    Parameters
    ----------
    work
        Called in the new process with a file, whose other end is `output`.
    """

    def __init__(self, work: Callable[[TextIO], object]) -> None:
        reading, writing = os.pipe()
        self.pid = os.fork()
        if self.pid == 0:
            status = 1
            try:
                os.close(reading)
                with os.fdopen(writing, "w", buffering=1) as file:
                    work(file)
                status = 0
            except SystemExit as end:
                status = 0 if not end.code else 1
            except BaseException:
                traceback.print_exc()
            finally:
                os._exit(status)
        os.close(writing)
        self.output = os.fdopen(reading)

    def interrupt(self) -> None:
        """Press Ctrl-C."""
        os.kill(self.pid, signal.SIGINT)

    def kill(self) -> None:
        """End it at once, whatever it does; return when it is gone."""
        os.kill(self.pid, signal.SIGKILL)
        self.output.close()
        os.waitpid(self.pid, 0)

    def end(self) -> str:
        """Wait for its end, which must be a good one, and return the rest of its output."""
        with self.output:
            text = self.output.read()
        assert os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1]) == 0, text
        return text


def torsio_command(*arguments: str, typed: str = "") -> Child:
    """Run the command ``torsio``; all that it prints is the child's `output`.

    Parameters
    ----------
    typed
        What is typed while it runs.
    """
    from torsio.apps.cli import app  # here: only some tests need it, and it takes long

    def work(output: TextIO) -> None:
        sys.stdin, sys.stdout, sys.stderr = io.StringIO(typed), output, output
        app(arguments)

    return Child(work)


def become_nobody() -> None:
    """Give up all rights, for the rest of this process."""
    os.setgroups([])
    os.setgid(NOBODY)
    os.setuid(NOBODY)
