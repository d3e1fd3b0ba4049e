"""What takes a knob, a scene, a recording, a state or the like says so of anything else."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import torsio
from torsio import batch, closed_loop, protocol, tasks
from torsio.gym import KnobEnv, KnobVectorEnv

MODULES = (
    *("torsio", "torsio.testing", "torsio.batch", "torsio.closed_loop", "torsio.calibration"),
    *("torsio.stability", "torsio.games", "torsio.tasks", "torsio.protocol", "torsio.gym"),
)
PLACES = {
    *("knob", "scene", "recording", "path", "state", "calibration", "hand", "config", "kind"),
    *("actuator", "control", "options", "excitation", "faults", "task", "rng", "serial", "log"),
    *("before", "now", "report", "values", "data", "emulator"),
}
# Values that these take, too, or take a while for.
TAKEN = {
    *("options None", "actuator None", "control None", "emulator None", "scene None", "hand None"),
    *("path 'x'", "recording 'x'", "scene 'x'", "serial 'x'", "state 'x'", "report 'x'"),
}
# Made by other calls, as data classes are, or bases of others.
MADE = {
    *(torsio.DeviceWatch, torsio.RecordingFile, torsio.Emulator, torsio.Knob),
    *(tasks.Task, torsio.Effect, torsio.Hand),
}
LOOP = closed_loop.LoopOptions()


@pytest.fixture
def objects(tmp_path: Path) -> Iterator[dict[str, Any]]:
    """Give what has methods, and arguments by their names."""
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(log_truth=True)) as knob:
        yield {
            "knob": knob,
            "emulator": knob.emulator,
            "knobs": batch.Knobs(2),
            "envs": KnobVectorEnv(tasks.RenderWall(), 2),
            "env": KnobEnv(tasks.RenderWall()),
            "loop": closed_loop.ClosedLoop(LOOP),
            "recorded": torsio.Recorded(knob.record(0.01)),
            "task": tasks.RenderWall(),
        }


def _calls(objects: dict[str, Any]) -> Iterator[Callable[..., Any]]:
    for module in map(importlib.import_module, MODULES):
        for name in module.__all__:
            found = getattr(module, name)
            if inspect.isroutine(found) or (
                inspect.isclass(found)
                and not (found in MADE or is_dataclass(found) or issubclass(found, Exception))
            ):
                yield found
    for one in objects.values():
        for name in dir(type(one)):
            is_own = not name.startswith("_") and inspect.isfunction(getattr(type(one), name))
            if is_own and name != "draw":  # a part of a task, which the environment calls
                yield getattr(one, name)


def _tell(call: Callable[..., Any], **given: Any) -> Exception | None:
    try:
        with ExitStack() as stack:
            made = call(**given)
            if isinstance(made, AbstractContextManager):
                stack.enter_context(made)
    except Exception as error:
        return error
    return None


def test_argument_of_another_kind_is_told_by_name(objects: dict[str, Any]) -> None:
    good = {
        **objects,
        **{
            "scene": [],
            "state": "armed",
            "calibration": None,
            "options": LOOP,
            "before": {},
            "now": None,
        },
        **{"expected": 0.0, "log": objects["recorded"].telemetry, "duration_s": 0.001, "n": 1},
        **{"actuator": torsio.ActuatorConfig(), "control": torsio.ControlConfig()},
        **{"rng": np.random.default_rng(1), "rate_hz": 1e3, "num_envs": 1, "text": "{}"},
        **{"report": "wall", "values": {}, "data": protocol.encode("wall", {}), "counts": [0]},
        **{"plant": torsio.PlantParams(), "stiffness_nm_per_rad": [1.0], "loop": LOOP},
    }
    asked, odd = 0, []
    for call in _calls(objects):
        try:
            needed = inspect.signature(call).parameters
        except ValueError:  # of the extension
            continue
        for place in PLACES & needed.keys():
            for wrong in (3, "x", None):
                if f"{place} {wrong!r}" in TAKEN:
                    continue
                others = {
                    name: good[name]
                    for name, of in needed.items()
                    if of.default is of.empty and name != place and of.kind < of.VAR_KEYWORD
                }
                error = _tell(call, **others, **{place: wrong})
                text = str(error).partition("\n")
                told = isinstance(error, TypeError | ValueError | torsio.Error)
                asked += 1
                if not told or (place not in text[0] and "effect" not in text[0]) or text[1]:
                    odd.append(f"{call} {place}={wrong!r}: {error!r}")
    assert asked > 100
    assert not odd, "\n".join(odd)
