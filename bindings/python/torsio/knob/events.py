"""Events of a knob on their way to a Python function."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from torsio.common.checks import show
from torsio.printed.told import Event

__all__ = ["tell"]


def tell(callback: Callable[[Event], object] | None) -> Callable[[dict[str, Any]], object] | None:
    """Make of a function of an `Event` what the extension calls."""
    if callback is None:
        return None
    if not callable(callback):
        raise TypeError(f"callback must be a function of an event or None, is {show(callback)}")
    return lambda event: callback(Event(**event))
