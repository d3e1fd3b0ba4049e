"""Commands of `torsio` that give a knob one order: arm, stop, zero, clear-fault."""

from __future__ import annotations

import math
import time
from contextlib import suppress
from typing import Annotated

import typer

import torsio
from torsio.apps.commands.shared import Device, Seconds, opened, plainly
from torsio.apps.doctor.examination import limits_text, missing
from torsio.common.screen import line, out

__all__ = ["add_to"]


def arm_command(device: Device = "", seconds: Seconds = None) -> None:
    """Switch the torque on until Ctrl-C, and print its limits and their reasons.

    The knob's own effects play: a game's, or a scene that an autonomous knob kept.
    """
    with opened(device, out) as knob:
        limits = knob.limits()
        line(out, f"at most  {limits_text(limits)}")
        if lacks := missing(knob.info.board, limits):
            line(out, f"missing  {': '.join(lacks)}")
        try:
            knob.arm()
            out.print("armed    Ctrl-C ends it")
            end_s = math.inf if seconds is None else time.monotonic() + seconds
            while (left_s := end_s - time.monotonic()) > 0 and knob.state == "armed":
                time.sleep(min(left_s, 0.1))
                if knob.is_emulated:
                    knob.sleep(0.1)
            ended = knob.state != "armed"
        finally:
            with suppress(torsio.Disconnected):
                knob.disarm()  # closing leaves an autonomous one alone
        if ended:
            disarm = knob.last_disarm
            why = ", ".join((disarm.reason, *disarm.faults)) if disarm else "unknown"
            raise torsio.Error(f"the torque went: {why}; `torsio doctor` says what to do")


def clear_fault_command(device: Device = "") -> None:
    """Clear latched faults whose cause is gone; `torsio doctor` names them and their cure."""
    with opened(device, out, order=torsio.Knob.clear_fault, changes=True):
        pass


def stop_command(device: Device = "") -> None:
    """Take the torque from a knob that plays on its own, and empty its scene."""
    with opened(device, out, order=torsio.Knob.stop, changes=True):
        pass


def _keep_centre(knob: torsio.Knob) -> None:
    if knob.health().centre != "index":
        raise torsio.Refused(
            "the knob has not found its encoder's index: set encoder_index_pin, start it anew, and "
            "turn it slowly, two turns"
        )
    knob.zero()
    knob.save()


def zero_command(
    device: Device = "",
    keep: Annotated[
        bool, typer.Option("--keep", help="Over power cycles too, by the encoder's index.")
    ] = False,
) -> None:
    """Make the knob's present angle zero."""
    order = _keep_centre if keep else torsio.Knob.zero
    with opened(device, out, order=order, changes=True):
        pass


def add_to(app: typer.Typer) -> None:
    """Add the commands."""
    app.command("arm")(plainly(arm_command))
    app.command("stop")(plainly(stop_command))
    app.command("zero")(plainly(zero_command))
    app.command("clear-fault")(plainly(clear_fault_command))
