"""Plugs a knob in for a program that takes a user's first steps, and pushes when it says so."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence

from tests.vm.guest.virtual_bus import VirtualKnob

PUSH = "torque_nm\n0 0\n1 0.05\n"  # like the first steps' own hand


def take_first_steps(command: Sequence[str]) -> str:
    """Run ``tools/first_steps.py`` by a command, with a knob plugged in; return what it says."""
    knob = VirtualKnob("FIRST", 1000, "pushes")
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
