"""Methods of a knob that are methods of its parts."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

__all__ = ["of_part"]

_Part = TypeVar("_Part")
_Given = ParamSpec("_Given")
_Result = TypeVar("_Result")


def of_part(
    part: str, method: Callable[Concatenate[_Part, _Given], _Result]
) -> Callable[Concatenate[Any, _Given], _Result]:
    """Make a method for a class that has a part of this name; it calls the part's method."""

    @wraps(method)
    def call(whole: Any, /, *given: _Given.args, **named: _Given.kwargs) -> _Result:
        return method(getattr(whole, part), *given, **named)

    return call
