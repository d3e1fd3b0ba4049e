"""Plugs a knob in for a program that takes a user's first steps, and pushes when it says so.

``python -m tests.vm.guest.wheel PROGRAM COMMAND...`` plugs in the virtual knob of PROGRAM.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from tests.vm.guest.virtual_bus import PROGRAM, VirtualKnob

PUSH = "torque_nm\n0 0\n1 0.05\n"  # like the first steps' own hand


def take_first_steps(command: Sequence[str], program: Path = PROGRAM) -> str:
    """Run ``tools/first_steps.py`` by a command, with a knob plugged in; return what it says."""
    knob = VirtualKnob("FIRST", 1000, "pushes", program=program)
    try:
        knob.plug()
        with tempfile.NamedTemporaryFile("w", suffix=".hand") as push:
            push.write(PUSH)
            push.flush()
            with subprocess.Popen(
                [*command, "plugged"],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            ) as steps:
                assert steps.stdout is not None
                said = steps.stdout.readline()
                if said == "armed\n":
                    knob.say(f"script {push.name}")
                said += steps.stdout.read()
        assert steps.returncode == 0, f"status {steps.returncode}: {said}"
        return said
    finally:
        knob.end()


if __name__ == "__main__":
    print(take_first_steps(sys.argv[2:], Path(sys.argv[1])), end="")
