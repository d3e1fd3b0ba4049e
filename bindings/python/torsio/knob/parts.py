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
) -> Callable[[Callable[..., None]], Callable[Concatenate[Any, _Given], _Result]]:
    """Put a part's method in the place of one that only gives the name.

    A plain assignment would have no declared type, which type checkers ask of a package.
    """
    method.__qualname__ = f"Knob.{method.__name__}"  # errors of a call name it

    @wraps(method)
    def call(whole: Any, /, *given: _Given.args, **named: _Given.kwargs) -> _Result:
        return method(getattr(whole, part), *given, **named)

    return lambda _: call
