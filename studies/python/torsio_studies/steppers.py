"""Other ways to step the plant, to compare the emulator's exact one with.

``exact_single`` is that one in 32-bit floating point, from the same sources.
``trapezoid`` and ``semi_implicit`` are theta-methods with set-valued friction; ``regularised`` is
Runge-Kutta 4 with friction smoothed over 0.01 rad/s, which creeps: it is here as a warning.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final, Literal, get_args

from torsio.closed_loop import LoopOptions
from torsio.emulator import Plant
from torsio.printed.hands import Hand
from torsio.printed.plant import PlantParams
from torsio_studies import _studies

Method = Literal["exact", "exact_single", "trapezoid", "semi_implicit", "regularised"]
METHODS: Final[tuple[Method, ...]] = get_args(Method)


def _stepper(method: Method) -> Any:
    return None if method == "exact" else _studies.stepper(method)


def make_plant(
    method: Method,
    params: PlantParams | None = None,
    hand: Hand | None = None,
    *,
    step_ns: int = 1_000_000,
) -> Plant:
    """Make a plant that is stepped so."""
    return Plant(params, hand, step_ns=step_ns, stepper=_stepper(method))


def stepped_by(method: Method, options: LoopOptions, *, step_ns: int = 1_000_000) -> LoopOptions:
    """Give the options of the same closed loop with its plant stepped so."""
    return replace(options, stepper=_stepper(method), step_ns=step_ns)
