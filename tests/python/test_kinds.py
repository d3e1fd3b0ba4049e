"""Public calls name an argument of another kind: knob, scene, recording, state and others."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable, Iterator
from dataclasses import is_dataclass
from typing import Any

import numpy as np

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
    *("before", "now", "report", "values", "data", "emulator", "selector"),
}
# Values that these take, or that name what is not there.
TAKEN = {
    *(
        "options None",
        "selector None",
        "actuator None",
        "control None",
        "emulator None",
        "scene None",
        "hand None",
    ),
    *(f"{name} 'x'" for name in ("path", "recording", "scene", "serial", "state")),
    *("report 'x'", "selector 'x'"),
}
# Made by other calls, or bases of others.
LEFT_OUT = {
    *(torsio.DeviceWatch, torsio.RecordingFile, torsio.Emulator, torsio.Knob),
    *(torsio.Effect, torsio.Hand, torsio.Telemetry, tasks.Task),
}


def _calls(objects: dict[str, Any]) -> Iterator[Callable[..., Any]]:
    for module in map(importlib.import_module, MODULES):
        for found in (getattr(module, name) for name in module.__all__):
            is_kind = isinstance(found, type) and not issubclass(found, Exception)
            if inspect.isfunction(found) or (is_kind and not is_dataclass(found)):
                yield from {found} - LEFT_OUT
    for one in objects.values():
        own = inspect.getmembers(type(one), inspect.isfunction)
        # The environment calls draw.
        yield from (getattr(one, name) for name, _ in own if name[0] != "_" and name != "draw")


def _told(call: Callable[..., Any], place: str, wrong: object, good: dict[str, Any]) -> str:
    """Give what is odd in the answer to a call with one wrong argument."""
    needed = inspect.signature(call).parameters.items()
    names = {name for name, of in needed if of.default is of.empty and of.kind < of.VAR_KEYWORD}
    try:
        made = call(**{name: good[name] for name in names - {place}}, **{place: wrong})
        getattr(made, "__enter__", lambda: None)()
    except (TypeError, ValueError, torsio.Error) as error:
        first, *more = str(error).splitlines()
        if not more and any(name in first for name in (place, "effect", "path")):
            return ""
        return f"{call}, {place}={wrong!r}: {error!r}"
    except (AttributeError, LookupError, OSError) as error:
        return f"{call}, {place}={wrong!r}: {error!r}"
    return f"{call}, {place}={wrong!r}: {made!r}"


def test_argument_of_another_kind_is_told_by_name() -> None:
    loop = closed_loop.LoopOptions()
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(log_truth=True)) as knob:
        objects = {
            **{"knob": knob, "emulator": knob.emulator, "knobs": batch.Knobs(2)},
            **{"envs": KnobVectorEnv(tasks.RenderWall(), 2), "env": KnobEnv(tasks.RenderWall())},
            **{"recorded": torsio.Recorded(knob.record(0.01)), "task": tasks.RenderWall()},
        }
        good: dict[str, Any] = {
            **objects,
            **dict.fromkeys(("calibration", "now", "callback", "excitation", "config", "faults")),
            **{"scene": [], "state": "armed", "options": loop, "loop": loop, "before": {}, "n": 1},
            **{"expected": 0.0, "log": knob.record(0.01), "duration_s": 0.001, "rate_hz": 1e3},
            **{"actuator": torsio.ActuatorConfig(), "control": torsio.ControlConfig()},
            **{"rng": np.random.default_rng(1), "num_envs": 1, "text": "{}", "report": "wall"},
            **{"values": {}, "data": protocol.encode("wall", {}), "counts": [0]},
            **{"plant": torsio.PlantParams(), "stiffness_nm_per_rad": [1.0], "path": "x"},
        }
        asked = [
            _told(call, place, wrong, good)
            for call in _calls(objects)
            for place in sorted(PLACES & inspect.signature(call).parameters.keys())
            for wrong in (3, "x", None)
            if f"{place} {wrong!r}" not in TAKEN
        ]
    assert len(asked) > 100
    assert not any(asked), "\n".join(filter(None, asked))
