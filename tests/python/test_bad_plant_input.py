"""Plant and closed loop refuse what makes no sense, by the argument's name."""

from __future__ import annotations

import math
import socket
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from torsio import PlantParams
from torsio.closed_loop import ClosedLoop, LoopOptions, simulate, simulate_many
from torsio.emulator import Plant

# A capsule, but of something else.
FOREIGN = socket.CAPI
ZEROS = np.zeros(3)


def run(**options: Any) -> object:
    return simulate(LoopOptions(**options), duration_s=0.01)


def last(duration_s: Any) -> object:
    return simulate(LoopOptions(), duration_s=duration_s)


def hold(**torques: Any) -> None:
    ClosedLoop(LoopOptions()).hold_command(**torques)


BAD: list[tuple[Callable[[], object], type[Exception], str]] = [
    (lambda: Plant(step_ns=1.5), TypeError, "step_ns"),  # type: ignore[arg-type]
    (lambda: Plant(step_ns=0), ValueError, "step_ns"),
    (lambda: Plant(stepper=3), TypeError, "stepper"),
    (lambda: Plant(stepper=FOREIGN), ValueError, "stepper comes from"),
    (lambda: Plant(3), TypeError, "params"),  # type: ignore[arg-type]
    (lambda: Plant(PlantParams(belt=3)), TypeError, "belt"),  # type: ignore[arg-type]
    (lambda: Plant().set_command(motor_command_nm=math.nan), ValueError, "motor_command_nm"),
    (lambda: Plant().advance(-1), ValueError, "duration_ns"),
    (lambda: Plant().record(ZEROS, ZEROS, period_ns=0), ValueError, "period_ns"),
    (lambda: Plant().drive(ZEROS, ZEROS, period_ns=-1), ValueError, "period_ns"),
    (lambda: Plant().drive(ZEROS, ZEROS, period_ns=1.5), TypeError, "period_ns"),  # type: ignore[arg-type]
    (lambda: run(plant=3), TypeError, "plant"),
    (lambda: run(plant=PlantParams(cogging=3)), TypeError, "cogging"),  # type: ignore[arg-type]
    (lambda: run(control=3), TypeError, "control"),
    (lambda: run(actuator=3), TypeError, "actuator"),
    (lambda: run(initial=3), TypeError, "initial"),
    (lambda: run(spin_up=3), TypeError, "spin_up"),
    (lambda: run(stepper="magic"), TypeError, "stepper"),
    (lambda: run(step_ns=1.5), TypeError, "step_ns"),
    (lambda: run(control_period_ns=0), ValueError, "control_period_ns"),
    (lambda: simulate(3, duration_s=1.0), TypeError, "options"),  # type: ignore[arg-type]
    (lambda: last(math.nan), ValueError, "duration_s"),
    (lambda: last(math.inf), ValueError, "duration_s"),
    (lambda: last(-1), ValueError, "duration_s"),
    (lambda: last("1"), TypeError, "duration_s"),
    (lambda: last(1e12), ValueError, "duration_s"),
    (lambda: last(3e8), ValueError, "record_every to 6,000 or more"),
    (lambda: ClosedLoop(LoopOptions()).run(duration_s=3e8), ValueError, "300,000,000,000 rows"),
    (lambda: simulate_many([LoopOptions()] * 3, duration_s=2e4), ValueError, "60,000,000 rows"),
    (lambda: simulate(LoopOptions(), duration_s=1.0, record_every=0), ValueError, "record_every"),
    (lambda: simulate_many([LoopOptions()], duration_s=0.1, threads=-1), ValueError, "threads"),
    (lambda: hold(motor_command_nm=math.nan), ValueError, "motor_command_nm"),
    (lambda: hold(brake_command_nm="a"), TypeError, "brake_command_nm"),
]


@pytest.mark.parametrize(("call", "kind", "name"), BAD)
def test_bad_argument_is_refused_by_name(
    call: Callable[[], object], kind: type[Exception], name: str
) -> None:
    with pytest.raises(kind, match=name):
        call()
