"""Reprs of data classes that stay short whatever they hold."""

from __future__ import annotations

from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any, Final

import numpy as np

__all__ = ["short_repr"]

_LONGEST: Final = 200
_LONGEST_VALUE: Final = 60
_MOST_VALUES: Final = 64


def short_repr(of: Any) -> str:
    """Write the call that makes a data class.

    One that is long is without the fields at their defaults, and says of long values how many they
    are.
    """
    shown = [field for field in fields(of) if field.repr]
    if all(_is_short(getattr(of, field.name)) for field in shown):
        call = _call(of, {field.name: repr(getattr(of, field.name)) for field in shown})
        if len(call) <= _LONGEST:
            return call
    values = {field.name: getattr(of, field.name) for field in shown if not _is_default(of, field)}
    return _call(of, {name: _brief(value) for name, value in values.items()})


def _call(of: Any, written: dict[str, str]) -> str:
    given = ", ".join(f"{name}={value}" for name, value in written.items())
    return f"{type(of).__qualname__}({given})"


def _is_short(value: Any) -> bool:
    """Tell what may be worth writing whole: a million values take a second."""
    if isinstance(value, np.ndarray):
        return bool(value.size <= _MOST_VALUES)
    return not isinstance(value, str | tuple | list) or len(value) <= _MOST_VALUES


def _is_default(of: Any, field: Field[Any]) -> bool:
    make = field.default_factory
    default = field.default if make is MISSING else make()
    value = getattr(of, field.name)
    return type(value) is type(default) and bool(value == default)


def _brief(value: Any) -> str:
    if _is_short(value) and len(written := repr(value)) <= _LONGEST_VALUE:
        return written
    if isinstance(value, np.ndarray):
        return f"<array of shape {value.shape}>"
    if isinstance(value, str):
        return f"<{len(value)} letters>"
    if isinstance(value, tuple | list):
        ends = f"{value[0]!r} to {value[-1]!r}"
        return f"<{len(value)} values{f': {ends}' if len(ends) <= _LONGEST_VALUE else ''}>"
    return f"{type(value).__qualname__}(...)" if is_dataclass(value) else repr(value)
