"""Checks of arguments: one sentence names the wrong one."""

from __future__ import annotations

import math
import operator
import os
import reprlib
from collections.abc import Iterable, Iterator, Mapping, Sized
from dataclasses import MISSING, Field, fields, is_dataclass
from difflib import get_close_matches
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, SupportsFloat, SupportsIndex

import numpy as np

from torsio.errors import InvalidArgument

# Lengths of a repr and of a value in a long one, and how many values are worth writing.
_LONGEST: Final = 200
_LONGEST_VALUE: Final = 60
_MOST_VALUES: Final = 64


class ShortRepr:
    """Base of the data classes that may hold much; give them ``repr=False``."""

    __slots__ = ()

    def __repr__(self) -> str:
        """Write the call that makes it.

        One that is long is without the fields at their defaults, and says of long values how many
        they are.
        """
        shown = [each for each in fields(self) if each.repr]  # type: ignore[arg-type]
        values = {each: getattr(self, each.name) for each in shown}
        if not any(map(_is_huge, values.values())):
            whole = _call(self, {each.name: repr(value) for each, value in values.items()})
            if len(whole) <= _LONGEST:
                return whole
        others = {of.name: value for of, value in values.items() if not _is_default(of, value)}
        return _call(self, {name: _brief(value) for name, value in others.items()})


def _call(of: Any, written: dict[str, str]) -> str:
    given = ", ".join(f"{name}={value}" for name, value in written.items())
    return f"{type(of).__qualname__}({given})"


def _is_huge(value: Any) -> bool:
    """Tell which part is not worth writing: a million values take a second."""
    return isinstance(value, Sized) and len(value) > _MOST_VALUES


def _is_default(field: Field[Any], value: Any) -> bool:
    make = field.default_factory
    default = field.default if make is MISSING else make()
    return type(value) is type(default) and bool(value == default)


def _brief(value: Any) -> str:
    if not _is_huge(value) and len(written := repr(value)) <= _LONGEST_VALUE:
        return written
    if isinstance(value, Sized):
        return f"<{type(value).__name__} of {len(value)}>"
    return f"{type(value).__qualname__}(...)" if is_dataclass(value) else written


class ByName(ShortRepr):
    """Base of the data classes whose values are given by name."""

    __slots__ = ()

    if not TYPE_CHECKING:  # for whom the data class's own signature is more exact

        def __new__(cls, *values, **named):
            """Say what is wrong with a call in the terms of the class."""
            known = getattr(cls, "__dataclass_fields__", None)
            if known is None or values or not named.keys() <= known.keys():
                _refuse_unknown(cls, values, named)
            return object.__new__(cls)


def _refuse_unknown(cls: type[Any], values: tuple[Any, ...], named: dict[str, Any]) -> None:
    if not is_dataclass(cls):
        given = ", ".join(one.__name__ for one in cls.__subclasses__())
        raise TypeError(f"{cls.__name__} has no values itself; there are {given}")
    known = [of.name for of in fields(cls)]
    by_place = [of.name for of in fields(cls) if not of.kw_only]
    if len(values) > len(by_place):
        first = " ".join(f"{name}=...," for name in known[: len(values)]).strip(",")
        raise TypeError(
            f"{cls.__name__} takes its values by name, in SI units: "
            f"{cls.__name__}({first}); its fields are {', '.join(known)}"
        )
    for name in named:
        if name not in known:
            raise TypeError(_unknown(cls.__name__, name, known))


def _unknown(kind: str, name: str, known: list[str]) -> str:
    said = f"{kind} has no field {name!r}; its fields are {', '.join(known)}"
    in_rad = f"{name.removesuffix('_deg')}_rad"
    return f"{said}. Angles are in radians: {in_rad}=torsio.deg(...)" if in_rad in known else said


def no_field(name: str, kinds: Iterable[Any]) -> str:
    """Say that none of these configurations has such a field, and which come near."""
    owners = {field.name: kind.__name__ for kind in kinds for field in fields(kind)}
    near = ", ".join(f"{field} ({owners[field]})" for field in get_close_matches(name, owners))
    said = f"there are {near}" if near else "`torsio config get` shows all"
    return f"no configuration has a field {name!r}; {said}"


def usable_cores() -> int:
    """Give the cores that this process may use, which may be fewer than the machine has."""
    if hasattr(os, "sched_getaffinity"):  # on Linux
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def threads(wanted: int | None) -> int:
    """Give how many threads share the work: as many as there are cores for, if none is wanted."""
    return usable_cores() if wanted is None else whole("threads", wanted, 1, 4096)


def show(value: Any) -> str:
    """Write any value for a message: short, in one line, and in letters that can be sent on."""
    try:
        shown = " ".join(reprlib.repr(value).split())
    except ValueError:  # Python does not write numbers of thousands of digits
        return "very long"
    return shown.encode(errors="backslashreplace").decode()


def number(name: str, value: Any, lowest: float = -math.inf, highest: float = math.inf) -> float:
    """Give a number of any kind as a float, if it lies in the range.

    Without a range nothing is compared: a NaN passes, for those who say more about it.
    """
    if type(value) is not float:  # by far the most frequent, and the rest costs microseconds
        try:
            if not isinstance(value, SupportsFloat | SupportsIndex):
                raise TypeError
            value = float(value)
        except (TypeError, ValueError):
            raise TypeError(f"{name} must be a number, is {show(value)}") from None
        except OverflowError:
            raise InvalidArgument(f"{name} is too large for a number: {show(value)}") from None
    if (lowest, highest) != (-math.inf, math.inf) and not lowest <= value <= highest:
        raise InvalidArgument(f"{name} is {value:g}, allowed are {lowest:g} to {highest:g}")
    return float(value)


def finite(name: str, value: Any) -> float:
    """Give a number that is neither infinite nor NaN."""
    value = number(name, value)
    if not math.isfinite(value):
        raise InvalidArgument(f"{name} must be finite, is {value:g}")
    return float(value)


def positive(name: str, value: Any) -> float:
    """Give a number that something is divided by: finite and above 0."""
    value = number(name, value)
    if not (math.isfinite(value) and value > 0):
        raise InvalidArgument(f"{name} must be finite and > 0, is {value:g}")
    return float(value)


def numbers(name: str, values: Any) -> tuple[float, ...]:
    """Give any iterable of numbers as a tuple."""
    return tuple(number(name, value) for value in each(name, values, "several numbers"))


def each(name: str, values: Any, wanted: str) -> Iterator[Any]:
    """Iterate over anything except text."""
    try:
        if isinstance(values, str | bytes):
            raise TypeError
        return iter(values)
    except TypeError:
        raise TypeError(f"{name} must be {wanted}, is {show(values)}") from None


def knots(name: str, profile: Any) -> tuple[tuple[float, float], ...]:
    """Give a function of time as a tuple of pairs: a number, or several knots (time_s, value)."""
    if isinstance(profile, Real):
        return ((0.0, number(name, profile)),)
    pairs = []
    for knot in each(name, profile, "a number or knots (time_s, value)"):
        values = numbers(f"{name}, a profile's knot,", knot)
        if len(values) != 2:
            raise InvalidArgument(
                f"{name}: a profile's knot must be (time_s, value), is {show(knot)}"
            )
        pairs.append((values[0], values[1]))
    return tuple(pairs)


def whole(name: str, value: Any, lowest: int, highest: int) -> int:
    """Give a whole number of any kind, if it lies in the range."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} must be a whole number, is {show(value)}") from None
    if not lowest <= number <= highest:
        raise InvalidArgument(f"{name} is {show(number)}, allowed are {lowest} to {highest}")
    return number


def kind(name: str, value: Any, types: type | tuple[type, ...], wanted: str) -> None:
    """Ask for an instance of a class."""
    if not isinstance(value, types):
        raise TypeError(f"{name} must be {wanted}, is {show(value)}")


def path(name: str, value: Any) -> Path:
    """Give the name of a file or folder as a path."""
    kind(name, value, (str, os.PathLike), "a path, a string or a pathlib.Path")
    if value == "" or "\0" in str(value):
        raise InvalidArgument(f"{name} cannot name a file: {show(value)}")
    return Path(value)


def table(name: str, value: Any) -> dict[Any, Any]:
    """Ask for values by name, and give them in a dictionary of their own."""
    kind(name, value, Mapping, "a dictionary")
    return dict(value)


def function(name: str, value: Any) -> None:
    """Ask for something that can be called."""
    if not callable(value):
        raise TypeError(f"{name} must be a function, is {show(value)}")


def text(name: str, value: Any) -> str:
    """Ask for a string."""
    kind(name, value, str, "a string")
    try:
        str(value).encode()
    except UnicodeEncodeError:
        raise InvalidArgument(f"{name} has no valid characters: {show(value)}") from None
    return str(value)


def selector(value: Any) -> str:
    """Ask for a path or serial number; None is the only knob, and an empty text a mistake."""
    if value is not None and not isinstance(value, str):
        raise TypeError(f"selector takes a path, serial number or Transport, not {show(value)}")
    if value == "":
        raise InvalidArgument("selector is empty; without one it is the knob that is plugged in")
    return text("selector", value or "")


def flag(name: str, value: Any) -> bool:
    """Ask for True or False."""
    kind(name, value, (bool, np.bool_), "True or False")
    return bool(value)
